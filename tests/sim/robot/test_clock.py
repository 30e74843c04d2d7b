import pytest

from sim.robot.clock import check_steps, physics_steps
from sonarmap import InputError


@pytest.mark.parametrize(("time_s", "steps"), [(0.0, 0), (0.005, 1), (0.175, 35), (7 * 0.04, 56)])
def test_times_are_steps(time_s, steps):
    assert physics_steps(time_s) == steps


@pytest.mark.parametrize("time_s", [0.005, 0.1, 3 * 0.1])
def test_whole_steps_are_accepted(time_s):
    check_steps("period_s", time_s)


@pytest.mark.parametrize("time_s", [0.0, -0.005, 0.0012, 0.0075])
def test_other_times_are_refused(time_s):
    with pytest.raises(InputError, match=f"period_s must be a multiple of 0.005 s, got {time_s!r}"):
        check_steps("period_s", time_s)
