"""What `sonarbed warmup` runs so that it is compiled: the smallest of everything."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sonarmap import SonarLog

__all__ = ["is_kept", "parts"]

_ROOM, _SCANS = "l-shape", 3


def parts(*, environments: bool) -> dict[str, Callable[[], object]]:
    """Return what compiles the parts of the product, by the names that people know them by."""
    chosen: dict[str, Callable[[], object]] = {
        "drives, simple cones": _cones,
        "drives, physical sonar": _physical,
        "drives in PyBullet": _bullet,
        "mapping methods": _methods,
        "reading filters": _filters,
        "scores": _scores,
    }
    if environments and find_spec("gymnasium") is not None:
        chosen["environments"] = _environments
    return chosen


def is_kept() -> bool:
    """Return whether what is compiled here is found again by the next process."""
    from worlds.raycast import cast_rays

    cache = getattr(cast_rays, "_cache", None)
    return getattr(cache, "_impl", None) is not None


def _cones() -> None:
    import sim
    import worlds

    room = worlds.load(_ROOM)
    for sonar in ("thesis", "aria", "webots"):
        sim.simulate(room, scans=_SCANS, seed=0, sonar=sonar, engine="segments")
    packets = sim.StatusPackets()  # a drive with them goes step by step
    sim.simulate(room, scans=_SCANS, seed=0, sonar="aria", engine="segments", packets=packets)


def _physical() -> None:
    import sim
    import worlds

    for packets in (None, sim.StatusPackets()):  # a drive with them goes step by step
        sim.simulate(worlds.load(_ROOM), scans=_SCANS, seed=0, engine="segments", packets=packets)


def _bullet() -> None:
    import sim
    import worlds

    for sonar in ("thesis", "physical"):
        sim.simulate(worlds.load(_ROOM), scans=_SCANS, seed=0, sonar=sonar)


def _methods() -> None:
    import sonarmap as sm

    log = _log()
    grid = sm.GridSpec.covering(-1.0, -1.0, 4.0, 4.0, 0.1)
    for name in sm.methods():
        sm.method(name).map(log, grid)


def _filters() -> None:
    import sonarmap as sm

    log = _log()
    for name in sm.filters():
        sm.filter(name).apply(log)


def _scores() -> None:
    import sonarmap as sm
    import worlds

    log, room = _log(), worlds.load(_ROOM)
    truth = worlds.truth(room)
    built = sm.method("bayes-parameterized").map(log, truth.grid)
    sm.score_map(built, truth, observable=truth.observable(log))
    sm.score_readings(log, sm.filter("hsr").apply(log).log)


def _environments() -> None:
    import gymnasium

    import sim  # noqa: F401 - it registers them

    for name in ("Explore", "Navigate", "FollowWall"):
        for robots in (1, 2, 64):  # one, a few by one thread, many by all
            if robots == 1:
                env = gymnasium.make(f"sonarbed/{name}-v1")
                env.reset(seed=0)
                env.step(env.action_space.sample())
            else:
                vector = gymnasium.make_vec(
                    f"sonarbed/{name}-v1",
                    num_envs=robots,
                    vectorization_mode="vector_entry_point",
                )
                vector.reset(seed=0)
                vector.step(vector.action_space.sample())


def _log() -> SonarLog:
    import sim
    import worlds

    return sim.simulate(worlds.load(_ROOM), scans=_SCANS, seed=0, sonar="thesis", engine="segments")
