import pytest

from sonarbed.reporting.parallel import in_parts, parallel_map
from sonarmap import InputError


def square(number):
    if number == 13:
        raise InputError("13 must not be squared")
    return number**2


@pytest.mark.parametrize("jobs", [1, 2])
def test_map_keeps_the_order_whatever_the_jobs(jobs):
    heard = []
    squares = parallel_map(
        square, [3, 1, 2], "squares", jobs=jobs, on_progress=lambda *news: heard.append(news)
    )
    assert squares == [9, 1, 4]
    assert heard[0] == ("squares", 0, 3)
    assert heard[-1] == ("squares", 3, 3)


@pytest.mark.parametrize("jobs", [1, 2])
def test_map_passes_errors_on(jobs):
    with pytest.raises(InputError, match="13 must not be squared"):
        parallel_map(square, [1, 13, 2], "squares", jobs=jobs)


def test_map_of_nothing_is_nothing():
    assert parallel_map(square, [], "squares") == []


def test_parts_are_equal_and_in_order():
    assert in_parts([1, 2, 3, 4], ["a", "b"]) == {"a": [1, 2], "b": [3, 4]}
