"""Threads of linear algebra: one where many would wait for each other."""

import numpy as np
import pytest
from drives import log_of, way
from scipy.linalg import svd
from threadpoolctl import threadpool_info, threadpool_limits

import sonarmap as sm
from sonarmap.cores import one_blas_thread
from sonarmap.learned import network
from sonarmap.poses import fitting


def blas_threads():
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


@pytest.fixture
def two_threads():
    """Let linear algebra have two threads, on any machine; skip where nobody can tell."""
    svd(np.eye(2))
    with threadpool_limits(2, user_api="blas"):
        if blas_threads() != {2}:
            pytest.skip("this linear algebra does not say how many threads it takes")
        yield


@pytest.mark.usefixtures("two_threads")
def test_linear_algebra_has_one_thread_inside_and_as_many_as_before_after():
    with one_blas_thread():
        assert blas_threads() == {1}
    assert blas_threads() == {2}


@pytest.mark.usefixtures("two_threads")
def test_an_error_inside_gives_the_threads_back():
    with pytest.raises(ZeroDivisionError), one_blas_thread():
        raise ZeroDivisionError
    assert blas_threads() == {2}


@pytest.mark.usefixtures("two_threads")
@pytest.mark.parametrize(
    ("module", "name", "call"),
    [
        (network, "_tile_logits", lambda log: sm.method("learned").map(log, sm.grid_over(log))),
        (fitting._Agreement, "residuals", sm.refine_poses),
    ],
    ids=["the network", "refined poses"],
)
def test_many_small_products_take_one_thread(module, name, call, walls_log, monkeypatch):
    seen, plain = [], getattr(module, name)

    def counted(*arguments):
        seen.append(blas_threads())
        return plain(*arguments)

    monkeypatch.setattr(module, name, counted)
    call(walls_log)
    assert seen
    assert all(threads == {1} for threads in seen)


@pytest.fixture
def walls_log(rng):
    true = way(1)
    return log_of(true, true, rng)
