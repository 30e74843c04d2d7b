"""A sample of generated rooms is driven: the robot touches nothing."""

import math

import numpy as np
import pytest

import worlds

# The worlds are tested without a simulator, too.
pytest.importorskip("gymnasium")

SCAN_S, SPEED_MPS = 0.1, 0.2


@pytest.mark.parametrize("style", worlds.styles())
def test_the_route_is_driven_without_touching(style):
    import sim

    for seed in (0, 1):
        world = worlds.generate(style, seed)
        points = np.array([(world.start.x_m, world.start.y_m), *world.route_m])
        length_m = np.hypot(*np.diff(points, axis=0).T).sum()
        scans = math.ceil(min(2.0 * length_m / SPEED_MPS / SCAN_S, 1200))
        log = sim.simulate(
            world,
            scans=scans,
            seed=seed,
            driver="route",
            sonar="aria",
            engine="segments",
            odometry=sim.OdometryModel.exact(),
        )
        truth = log.require_truth("the test")
        assert not truth.collision.any(), world.name
        assert np.isfinite(log.range_m).any(), world.name
        # It comes by every way point that it had the time for.
        away_m = np.hypot(*(np.column_stack([truth.x_m, truth.y_m])[:, None] - points).T)
        near = (away_m.min(axis=1) < 0.25).mean()
        assert near > 0.9 or scans == 1200, world.name
