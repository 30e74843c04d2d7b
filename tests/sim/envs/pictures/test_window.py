import sys
import time

import numpy as np
import pytest

pytest.importorskip("gymnasium")
from gymnasium.error import DependencyNotInstalled

from sim.envs.pictures.window import Window
from sonarmap import InputError

FRAME = np.zeros((40, 60, 3), np.uint8)
FAST = 1000


@pytest.fixture
def pygame(monkeypatch):
    """The library, with a screen that nobody sees."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    library = pytest.importorskip("pygame")
    yield library
    library.quit()


def windows_of(*shown):
    """Return the windows of the library: what `Window` has opened."""
    return [window._window for window in shown]


def test_frame_is_shown_as_it_is(pygame, rng):
    frame = rng.integers(256, size=(40, 60, 3)).astype(np.uint8)
    window = Window(fps=FAST)
    window.show(frame)
    (opened,) = windows_of(window)
    assert opened.size == (60, 40)
    assert opened.title == "sonarbed"
    shown = pygame.surfarray.array3d(opened.get_surface()).swapaxes(0, 1)
    assert np.array_equal(shown, frame)
    window.close()


def test_window_takes_the_size_of_each_frame(pygame):
    window = Window(fps=FAST)
    for shape in ((40, 60, 3), (90, 50, 3), (30, 30, 3)):
        window.show(np.full(shape, 77, np.uint8))
        (opened,) = windows_of(window)
        assert opened.size == (shape[1], shape[0])
        assert opened.get_surface().get_at((shape[1] - 1, shape[0] - 1))[:3] == (77, 77, 77)
    window.close()


def test_nothing_opens_before_the_first_frame(pygame):
    window = Window(fps=FAST)
    assert not pygame.display.get_init()
    window.close()


def test_closing_twice_is_fine_and_later_frames_are_ignored(pygame):
    window = Window(fps=FAST)
    window.show(FRAME)
    window.close()
    window.close()
    assert window.is_closed
    window.show(FRAME)
    assert windows_of(window) == [None]


@pytest.mark.parametrize("kind", ["WINDOWCLOSE", "QUIT"])
def test_user_closes_the_window(pygame, kind):
    window = Window(fps=FAST)
    window.show(FRAME)
    (opened,) = windows_of(window)
    given = {"window": opened} if kind == "WINDOWCLOSE" else {}
    pygame.event.post(pygame.event.Event(getattr(pygame, kind), given))
    window.show(FRAME)
    assert window.is_closed
    window.show(FRAME)
    window.close()


def test_two_windows_do_not_meet(pygame):
    first, second = Window(fps=FAST), Window(fps=FAST)
    first.show(FRAME)
    second.show(FRAME + 9)
    pygame.event.post(pygame.event.Event(pygame.WINDOWCLOSE, window=windows_of(second)[0]))
    first.show(FRAME)
    assert not first.is_closed
    second.show(FRAME)
    assert second.is_closed
    first.show(FRAME)
    assert windows_of(first)[0].get_surface().get_at((0, 0))[:3] == (0, 0, 0)
    first.close()


def test_frames_come_no_faster_than_the_rate(pygame):
    window = Window(fps=50)
    window.show(FRAME)
    begin = time.perf_counter()
    for _ in range(5):
        window.show(FRAME)
    assert time.perf_counter() - begin > 0.8 * 5 / 50
    window.close()


def test_missing_library_is_named_with_its_cure(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled, match=r"pip install 'sonarbed\[gui\]'"):
        Window(fps=10)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Window(fps=0), r"fps must be > 0, got 0"),
        (lambda: Window(fps=float("nan")), r"fps must be > 0, got nan"),
        (
            lambda: Window(fps=9).show(FRAME[0]),
            r"frame must be uint8 of shape \(height, width, 3\)",
        ),
        (lambda: Window(fps=9).show(FRAME / 2), r"frame must be uint8 .* got float64"),
    ],
)
def test_bad_input_is_refused(pygame, make, message):
    with pytest.raises(InputError, match=message):
        make()
