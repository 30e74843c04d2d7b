"""PPO on Explore with a map patch: the code that comes to mind beside every setting of threads.

    python benchmarks/training.py

Needs the extra `rl`. One environment as README makes it, and a vector of 256, each learned from by
`PPO("MultiInputPolicy", env)` with nothing said of threads; then PyTorch with 1 and 2 threads, and
the vector with 1 and 2. (One robot never needs more than one thread.) Every run is a process of its
own, for threads that were begun once wait for work ever after; settings take turns, and the best of
two runs counts. It needs a machine that does nothing else, and says so and runs once on one that
does: there a training in which PyTorch has two threads may take twenty times as long, or not.
"""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from itertools import product
from time import perf_counter

ROBOTS = (1, 256)
WARM, STEPS = 256, 1024  # of all robots together
MOST_S = 8.0  # a training that is slow is cut short, between two updates
OBVIOUS = (0, 0)
SETTINGS = (OBVIOUS, *product((1, 2), (1, 2)))  # PyTorch's threads, the environment's
RUNS = 2
QUIET_LOAD = 0.7  # mean of the last minute


def main() -> None:
    if find_spec("stable_baselines3") is None:
        print("PPO: Stable-Baselines3 is not installed: pip install 'sonarbed[rl]' measures it")
        return
    best: dict[tuple[int, tuple[int, int]], float] = {}
    cases = [case for case in product(ROBOTS, SETTINGS) if case[0] > 1 or case[1][1] < 2]
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    is_busy = load > QUIET_LOAD
    if is_busy:
        print(f"PPO: other work is on this machine (load {load:.1f}); its ratios say little")
    for _ in range(1 if is_busy else RUNS):
        for case in cases:
            best[case] = max(best.get(case, 0.0), in_a_process(*case))
    print("| PPO on Explore, map patch of 48 cells | " + " | ".join(map(text, SETTINGS)), end="")
    print(" | obvious / best |\n" + "|---" * (len(SETTINGS) + 2) + "|")
    for robots in ROBOTS:
        rates = [best.get((robots, setting)) for setting in SETTINGS]
        name = "one environment" if robots == 1 else f"vector of {robots}"
        print(
            f"| {name}, steps/s | "
            + " | ".join("" if rate is None else f"{rate:,.0f}" for rate in rates)
            + f" | {rates[0] / max(filter(None, rates)):.2f} (wanted 0.5 and more) |"
        )


def text(setting: tuple[int, int]) -> str:
    return "as it comes" if setting == OBVIOUS else "PyTorch {}, environment {}".format(*setting)


def in_a_process(robots: int, setting: tuple[int, int]) -> float:
    """Return the steps a second of one training in a process of its own."""
    asked = json.dumps([robots, *setting])
    done = subprocess.run(
        [sys.executable, "-W", "ignore", __file__, "--learn", asked],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(done.stdout.split()[-1])


def learn(robots: int, torch_threads: int, env_threads: int) -> float:
    """Return the steps a second of a training, 0 threads: as it comes."""
    import gymnasium
    from stable_baselines3 import PPO

    arguments = {"world": "office", "sonar": "aria", "map_patch": 48}
    if torch_threads:
        import torch

        torch.set_num_threads(torch_threads)
        arguments["threads"] = env_threads
    if robots == 1:
        env = gymnasium.make("sim:sonarbed/Explore-v1", **arguments)
    else:
        from sim.envs.sb3 import SB3VecEnv

        env = SB3VecEnv(
            gymnasium.make_vec(
                "sim:sonarbed/Explore-v1", num_envs=robots, autoreset_mode="SameStep",
                vectorization_mode="vector_entry_point", **arguments,
            )
        )  # fmt: skip
    # As many steps between two updates for every number of robots, or a round of 256 takes minutes.
    model = PPO("MultiInputPolicy", env, n_steps=WARM // robots, device="cpu", seed=0)
    model.learn(WARM)
    begin = perf_counter()
    model.learn(STEPS, callback=lambda *_: perf_counter() - begin < MOST_S)
    return model.num_timesteps / (perf_counter() - begin)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--learn"]:
        print(learn(*json.loads(sys.argv[2])))
    else:
        main()
