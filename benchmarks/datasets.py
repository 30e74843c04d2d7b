"""A data set of 1,000 logs of 200 scans: seconds by preset, two processes against one, memory.

    python benchmarks/datasets.py [LOGS] [--dask]

With fewer logs than 1,000 the times are scaled to it. `--dask` begins a cluster of two workers on
this machine and takes turns with the pool.
"""

import os
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import pyarrow.parquet as pq

import sonarmap as sm
from sim.datasets import make_dataset, parse_spec
from sim.datasets.plan import plan_of
from sim.runs.jobs import DaskCluster, Processes, ThisProcess, Workers

LOGS_A_ROOM = 5
TARGETS_S = {"thesis": 60, "physical": 180}


def main() -> None:
    words = [word for word in sys.argv[1:] if word != "--dask"]
    logs = int(words[0]) if words else 1000
    for sonar, target_s in TARGETS_S.items():
        two, one = timed(sonar, logs, Processes(2)), timed(sonar, logs, ThisProcess())
        scaled = two * 1000 / logs
        print(
            f"{sonar}: {logs} logs of 200 scans in {two:.1f} s by two processes, 1,000 in "
            f"{scaled:.0f} s (target {target_s}); two are {one / two:.2f} times as fast as one "
            "(target 1.7)"
        )
    memory(logs)
    parts(logs)
    if "--dask" in sys.argv:
        cluster(logs)


def spec(sonar: str, logs: int, **changes: object) -> object:
    """Return 200 rooms of five logs each, or as many as make so many logs."""
    table = {"seeds": LOGS_A_ROOM, "sonar": sonar, "scans": 200, "driver": "wander"}
    rooms = max(logs // LOGS_A_ROOM, 1)
    generated = {"generate": [{"style": "office", "seeds": rooms}]}
    if find_spec("worlds.generation") is None:  # the shipped rooms, more often
        generated = {"names": ["*"]}
        table["seeds"] = max(logs // 8, 1)
    return parse_spec({"name": "bench", "rooms": generated, "logs": table | changes})


def timed(sonar: str, logs: int, workers: Workers) -> float:
    with tempfile.TemporaryDirectory() as folder:
        # What is compiled is compiled before.
        make_dataset(spec(sonar, 8, scans=2), f"{folder}/warm", workers=workers)
        begin = perf_counter()
        make_dataset(spec(sonar, logs), f"{folder}/data", workers=workers)
        return perf_counter() - begin


def memory(logs: int) -> None:
    """Print how much the coordinator grows from many short logs to ten times as many."""
    peaks = []
    for count in (logs, 10 * logs):
        script = (
            "import resource\nfrom benchmarks.datasets import spec\n"
            "from sim.datasets import make_dataset\nfrom sim.runs.jobs import Processes\n"
            "import tempfile\n"
            "if __name__ == '__main__':\n"
            "    with tempfile.TemporaryDirectory() as folder:\n"
            f"        make_dataset(spec('aria', {count}, scans=2), folder + '/d', "
            "workers=Processes(2))\n"
            "    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
        )
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "coordinator.py"
            path.write_text(script)
            here = str(Path(__file__).parents[1])
            environment = os.environ | {
                "PYTHONPATH": os.pathsep.join([here, os.environ.get("PYTHONPATH", "")])
            }
            done = subprocess.run(
                [sys.executable, path], capture_output=True, text=True, check=True, env=environment
            )
            peaks.append(int(done.stdout) / 1024)
    few, many = peaks
    print(f"memory of the coordinator: {few:.0f} MB for {logs} logs, {many:.0f} for ten times that")


def parts(logs: int) -> None:
    """Print what a log costs beside its drive: planning, its bytes, its row in the manifest."""
    plan = plan_of(spec("physical", 100_000), Path())
    begin = perf_counter()
    count = sum(len(job.outputs) for room in plan.rooms() for job in plan.logs_of(room))
    planned = (perf_counter() - begin) / count
    with tempfile.TemporaryDirectory() as folder:
        make_dataset(spec("physical", min(logs, 80)), folder)
        begin = perf_counter()
        again = make_dataset(spec("physical", min(logs, 80)), folder)
        row = (perf_counter() - begin) / again.logs.done
        files = list(Path(folder, "logs").rglob("*.parquet"))
        size = sum(file.stat().st_size for file in files) / len(files)
        readings = pq.read_table(f"{folder}/manifest.parquet")["readings"].to_numpy().mean()
        data = sm.SonarDataset(folder, window=256, kept_logs=1)
        begin = perf_counter()
        for i in range(len(data))[::7]:
            data[i]
        window = (perf_counter() - begin) / len(range(len(data))[::7])
    print(
        f"a log: planned in {planned * 1e6:.0f} us; {size / 1000:.0f} kB, {size / readings:.0f} "
        f"bytes a reading; found complete and listed in {row * 1e6:.0f} us; a window of a log that "
        f"is not kept: {window * 1000:.1f} ms"
    )


def cluster(logs: int) -> None:
    """Print a Dask cluster of two workers against the pool, by turns, start-up left out."""
    with dask_cluster() as address:
        ratios = []
        for _ in range(3):
            pool, dask = (
                timed("thesis", logs, workers) for workers in (Processes(2), DaskCluster(address))
            )
            ratios.append(dask / pool)
    print(
        f"dask / pool of two: {sorted(ratios)[1]:.2f} (target at most 1.15), "
        f"{min(ratios):.2f} to {max(ratios):.2f} in {len(ratios)} turns"
    )


@contextmanager
def dask_cluster():
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    ) as running:
        yield running.scheduler_address


if __name__ == "__main__":
    main()
