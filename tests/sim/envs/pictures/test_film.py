import math

import numpy as np
import pytest
from PIL import Image

from sim.envs.pictures.film import write_gif
from sonarmap import InputError


def moving_square(count, *, shape=(60, 80)):
    frames = []
    for step in range(count):
        frame = np.full((*shape, 3), 255, np.uint8)
        frame[10:20, step : step + 10] = (213, 94, 0)
        frame[40:42, 70:72] = (204, 121, 167)  # few pixels of a colour of their own
        frames.append(frame)
    return frames


def read(path):
    with Image.open(path) as film:
        shown = []
        for number in range(film.n_frames):
            film.seek(number)
            shown.append((np.array(film.convert("RGB")), film.info["duration"]))
        return shown, film.info


def test_film_shows_the_frames_at_their_pace_for_ever(tmp_path):
    frames = moving_square(7)
    write_gif(frames, tmp_path / "film.gif", fps=20)
    shown, info = read(tmp_path / "film.gif")
    assert info["loop"] == 0
    assert [duration for _, duration in shown] == [50] * 7
    for (picture, _), frame in zip(shown, frames, strict=True):
        assert np.array_equal(picture, frame)


def test_few_pixels_of_a_colour_keep_it_among_many_colours(tmp_path, rng):
    frames = moving_square(5, shape=(200, 200))
    for frame in frames:
        frame[60:160] = rng.integers(256, size=(100, 200, 1))  # grey noise
        frame[170:180] = rng.integers(200, 256, size=(10, 200, 3))
    write_gif(frames, tmp_path / "film.gif", fps=5)
    for (picture, _), frame in zip(read(tmp_path / "film.gif")[0], frames, strict=True):
        for part in (slice(0, 60), slice(180, 200)):
            assert np.array_equal(picture[part], frame[part])
        assert np.abs(picture.astype(int) - frame).max() < 60


@pytest.mark.parametrize("fps", [3, 12, 15, 30, 50, 0.5])
def test_film_keeps_its_pace_in_hundredths_of_a_second(tmp_path, fps):
    write_gif(moving_square(40), tmp_path / "film.gif", fps=fps)
    shown, _ = read(tmp_path / "film.gif")
    assert sum(duration for _, duration in shown) == pytest.approx(40_000 / fps, abs=10)


def test_frame_that_repeats_lasts_longer(tmp_path):
    still = moving_square(1) * 10
    write_gif([*still, *moving_square(2)[1:]], tmp_path / "film.gif", fps=10)
    assert [duration for _, duration in read(tmp_path / "film.gif")[0]] == [1000, 100]


def test_film_of_one_frame_is_a_picture(tmp_path):
    (frame,) = moving_square(1)
    write_gif([frame], tmp_path / "film.gif", fps=10)
    with Image.open(tmp_path / "film.gif") as film:
        assert np.array_equal(np.array(film.convert("RGB")), frame)


def test_what_stays_takes_hardly_any_space(tmp_path, rng):
    busy = rng.integers(256, size=(60, 80, 1)).astype(np.uint8).repeat(3, axis=2)
    frames = [busy.copy() for _ in range(50)]
    for step, frame in enumerate(frames):
        frame[5, step] = 0
    write_gif(frames[:1], tmp_path / "one.gif", fps=10)
    write_gif(frames, tmp_path / "many.gif", fps=10)
    # 49 more frames, less than 60 bytes each: no palette of their own either.
    more = (tmp_path / "many.gif").stat().st_size - (tmp_path / "one.gif").stat().st_size
    assert more < 49 * 60


FRAME = np.zeros((4, 6, 3), np.uint8)


@pytest.mark.parametrize(
    ("frames", "fps", "message"),
    [
        ([], 10, r"frames must have at least one frame, got none"),
        (
            [FRAME, FRAME[:3]],
            10,
            r"frames\[1\] must have the shape of the first, \(4, 6, 3\), got \(3, 6, 3\)",
        ),
        ([FRAME[..., 0]], 10, r"frames\[0\] must be uint8 of shape \(height, width, 3\)"),
        (
            [FRAME, FRAME / 255],
            10,
            r"frames\[1\] must be uint8 .* got float64 of shape \(4, 6, 3\)",
        ),
        ([FRAME[:0]], 10, r"frames\[0\] must be uint8"),
        ([FRAME], 0, r"fps must be within"),
        ([FRAME], 51, r"fps must be within \[0.0166667, 50\], got 51"),
        ([FRAME], math.nan, r"fps must be within"),
    ],
)
def test_bad_films_are_refused_and_nothing_is_written(tmp_path, frames, fps, message):
    with pytest.raises(InputError, match=message):
        write_gif(frames, tmp_path / "film.gif", fps=fps)
    assert list(tmp_path.iterdir()) == []


def test_film_that_cannot_be_written_says_so(tmp_path):
    with pytest.raises(InputError, match="is a folder"):
        write_gif([FRAME], tmp_path, fps=10)
