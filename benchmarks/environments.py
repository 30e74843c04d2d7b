"""Steps a second of the environments: on both engines, alone and as a vector; memory.

Control at 10 Hz, eight sonars, exact or (on `bullet`) of 31 rays, in `office`. The engine `bullet`
is compared with a bare loop of the same PyBullet calls, recorded from the environment's own steps;
the others with ir-sim (248 lidar beams) where that is installed.
"""

import resource
from time import perf_counter

import gymnasium
import numpy as np

from sim.envs.registration import IDS
from sim.sonar import presets as sonars  # importing sim registers the environments
from sim.sonar.cone.sonar import FAN_RAYS

RUNS = 7
SHORT, LONG = 100, 1000
ROBOTS = 256


def main() -> None:
    assert len(sonars.preset("aria").ring) * FAN_RAYS == 8 * 31
    bullet()
    peer = irsim_steps()
    for name in IDS:
        alone(name, peer)
    for name in IDS:
        together(name, 0, 60_000)
    together("sonarbed/Explore-v1", 48, 10_000)
    a_million_steps()


def bullet() -> None:
    """Print steps a second on PyBullet, and what share of the time its own calls need."""
    env = gymnasium.make("sonarbed/Navigate-v1", engine="bullet", world="office")
    whole, bare = [], []
    for run in range(RUNS):
        env.reset(seed=run)
        actions = [env.action_space.sample() for _ in range(SHORT)]
        engine = env.unwrapped.batch._parts.backend._robots[0].engine
        recorder = Recorder(engine._p)
        engine._p = recorder
        step_all(env, actions)
        engine._p = recorder.pybullet
        env.reset(seed=run)
        whole.append(timed(lambda actions=actions: step_all(env, actions)))
        # The engine of a new episode has the same bodies by the same numbers, so the calls fit it,
        # but for its connection.
        env.reset(seed=run)
        client = env.unwrapped.batch._parts.backend._robots[0].engine._client
        bare.append(timed(lambda recorder=recorder, client=client: recorder.replay(client)))
    env.close()
    print(
        f"bullet: {SHORT / min(whole):,.0f} steps/s (target 400), "
        f"{min(bare) / min(whole):.0%} of the bare loop of the same PyBullet calls, best to best "
        f"of {RUNS} runs (target 75 %)"
    )


class Recorder:
    """Passes calls on to PyBullet and notes them."""

    def __init__(self, pybullet) -> None:
        self.pybullet, self._calls = pybullet, []

    def __getattr__(self, name):
        function = getattr(self.pybullet, name)
        if not callable(function):
            return function

        def call(*arguments, **named):
            self._calls.append((function, arguments, named))
            return function(*arguments, **named)

        return call

    def replay(self, client: int) -> None:
        for function, arguments, named in self._calls:
            named["physicsClientId"] = client
            function(*arguments, **named)


def alone(name: str, peer: float | None) -> None:
    """Print steps a second of one environment on `segments`."""
    env = gymnasium.make(name, world="office")
    env.reset(seed=0)
    actions = [env.action_space.sample() for _ in range(LONG)]
    step_all(env, actions)
    best = LONG / min(timed(lambda: step_all(env, actions)) for _ in range(RUNS))
    against = "" if peer is None else f", {best / peer:.1f} times ir-sim"
    print(f"segments, {name}: {best:,.0f} steps/s (target 8,000){against}")


def together(name: str, map_patch: int, target: int) -> None:
    """Print environment steps a second of the vector environment."""
    env = vector(name, map_patch=map_patch, world="office")
    env.reset(seed=0)
    actions = [env.action_space.sample() for _ in range(20)]
    best = min(timed(lambda: [env.step(action) for action in actions]) for _ in range(3 * RUNS))
    patch = f", map patch {map_patch}" if map_patch else ""
    print(
        f"vector of {ROBOTS}, {name}{patch}: {ROBOTS * len(actions) / best:,.0f} steps/s "
        f"(target {target:,})"
    )


def a_million_steps() -> None:
    """Print how memory grows over a million steps, and check every observation on the way."""
    env = vector("sonarbed/Explore-v1", world=["office", "clutter", "corridor", "thesis-exp2"])
    env.reset(seed=0)
    # The worlds, their maps and the compiled code are in memory after the first episodes.
    run_checked(env, 1500)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = perf_counter()
    steps = 1_000_000 // ROBOTS + 1
    run_checked(env, steps)
    taken = perf_counter() - begin
    growth = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / before - 1
    print(
        f"{steps * ROBOTS:,} steps with every observation checked in {taken:.0f} s: memory grows "
        f"by {growth:.2%} (target below 2 %), no NaN, all observations in their space"
    )


def run_checked(env, steps: int) -> None:
    for _ in range(steps):
        observation, reward, *_ = env.step(env.action_space.sample())
        if not (env.observation_space.contains(observation) and np.isfinite(reward).all()):
            raise RuntimeError("an observation outside of its space, or a reward that is no number")


def vector(name: str, **options):
    return gymnasium.make_vec(
        name, num_envs=ROBOTS, vectorization_mode="vector_entry_point", threads="all", **options
    )


def irsim_steps() -> float | None:
    """Return the peer's steps a second with 248 lidar beams, None where it is not installed."""
    try:
        from irsim_peer import steps_a_second
    except ImportError:
        print("ir-sim is not installed: pip install ir-sim compares with it")
        return None
    return steps_a_second(LONG)


def step_all(env, actions) -> None:
    for action in actions:
        *_, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()


def timed(work) -> float:
    begin = perf_counter()
    work()
    return perf_counter() - begin


if __name__ == "__main__":
    main()
