"""The file of weights: whole, or refused in one line."""

import dataclasses
import json

import numpy as np
import pytest
from learned_weights import small_weights

import sonarmap as sm
from sonarmap.errors import InputError
from sonarmap.learned.channels import CHANNELS
from sonarmap.learned.network import logits
from sonarmap.learned.weights import CARD, SHIPPED, Calibration, Weights, _digest_of


@pytest.fixture
def file(tmp_path, rng):
    path = tmp_path / "w.npz"
    small_weights(rng).save(path)
    return path


def changed(path, **changes):
    """Write a file again with some of its arrays changed, its digest as it was."""
    with np.load(path) as data:
        arrays = dict(data)
    arrays |= changes
    np.savez(path, **arrays)
    return arrays


def test_what_is_written_is_read(rng, tmp_path):
    weights = small_weights(rng)
    weights.save(tmp_path / "w.npz")
    back = Weights.load(tmp_path / "w.npz")
    x = rng.random((len(CHANNELS), 8, 16)).astype(np.float32)
    np.testing.assert_array_equal(logits(back, x), logits(weights, x))
    for name in ("widths", "calibrations", "occupied_from", "free_up_to", "share"):
        assert getattr(back, name) == getattr(weights, name)
    assert list(back.reading) == ["mean"]


def test_the_same_weights_make_the_same_file(rng, tmp_path):
    weights = small_weights(rng)
    for name in ("a.npz", "b.npz"):
        weights.save(tmp_path / name)
    assert Weights.load(tmp_path / "a.npz").digest == Weights.load(tmp_path / "b.npz").digest


def test_a_file_that_is_cut_short_is_refused(file):
    data = file.read_bytes()
    for size in (0, 10, len(data) // 2, len(data) - 10):
        file.write_bytes(data[:size])
        with pytest.raises(InputError, match="is no file of weights, or is cut short"):
            Weights.load(file)


def test_a_file_that_was_tampered_with_is_refused(file):
    with np.load(file) as data:
        bias = data["head_bias"] + np.float32(1e-3)
    changed(file, head_bias=bias)
    with pytest.raises(InputError, match=r"w\.npz: the weights are not what was written"):
        Weights.load(file)


@pytest.mark.parametrize("name", ["format", "channels"])
def test_weights_of_another_version_are_refused(file, name):
    with np.load(file) as data:
        about = json.loads(data["about"].tobytes())
    arrays = changed(file, about=np.frombuffer(json.dumps(about | {name: 99}).encode(), np.uint8))
    del arrays["digest"]
    changed(file, digest=np.array(_digest_of(arrays)))
    with pytest.raises(InputError, match=rf"{name} must be 1, got 99: .* of another version"):
        Weights.load(file)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.npz: no such file"):
        Weights.load(tmp_path / "none.npz")
    np.savez(tmp_path / "map.npz", log_odds=np.zeros(3))
    with pytest.raises(InputError, match=r"map\.npz: is no file of weights: it has no 'about'"):
        Weights.load(tmp_path / "map.npz")
    with pytest.raises(InputError, match=r"map\.npz: is no file of weights"):
        sm.method("learned", weights=str(tmp_path / "map.npz")).map(
            sm.SonarLog(sm.AMIGOBOT, [0], [0], [0], [0], [0], [0], [1.0]),
            sm.GridSpec(0.05, (0, 0), (4, 4)),
        )


def test_calibration_is_interpolated_between_cell_sizes_and_kept_beyond(rng):
    weights = dataclasses.replace(
        small_weights(rng), calibrations={0.5: Calibration(1, 0), 2.0: Calibration(2, 4)}
    )
    assert weights.calibration(1.0) == Calibration(1.5, 2.0)
    assert weights.calibration(0.1) == Calibration(1, 0)
    assert weights.calibration(9.0) == Calibration(2, 4)


def test_a_calibration_is_the_logistic_function():
    p = Calibration(2.0, -1.0).probability(np.array([0.0, 0.5, 3.0, 800.0, -800.0]))
    np.testing.assert_allclose(p[:3], 1 / (1 + np.exp([1.0, 0.0, -5.0])))
    np.testing.assert_allclose(p[3:], [1, 0])


def test_what_ships_is_whole_small_and_has_its_card():
    weights = Weights.load(SHIPPED)
    assert SHIPPED.stat().st_size < 1_000_000
    assert weights.free_up_to < weights.occupied_from
    assert set(weights.calibrations) == {0.5, 1.0, 2.0}
    assert weights.digest in CARD.read_text(encoding="utf-8")
