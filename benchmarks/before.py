"""Today's speed beside that before exact cones, image sources and batches, in one run.

    python benchmarks/before.py [COMMIT]

Takes the files of `COMMIT` out of git into a temporary folder and measures there what it measures
here (`rows.py`), each in a process of its own and by turns, so that what else the machine does
meets both alike. Rates are by the clock, the best of five; the ratio is best to best. The earlier
code compiles anew, so the first minute shows nothing.
"""

import io
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

COMMIT = "ef6eb9e34b6d0d587a8d25ed73d38295196b6a4b"
"""The last commit before exact cones, image sources, batches of drives and rules of threads."""

HERE = Path(__file__).resolve().parents[1]
TURNS = 5
# Each: its name in `rows.py`, what it is, the unit, the rate wanted, and how many times the rate
# before is wanted.
ROWS: tuple[tuple[str, str, str, float | None, float | None], ...] = (
    ("simulate_one", "`simulate`, one drive, simple cone", "readings/s", None, None),
    ("many_simple", "many drives, simple cone, two cores", "readings/s", 500_000, None),
    ("physical_one", "physical, in turn, one bounce, office", "readings/s", 60_000, None),
    ("physical_two", "the same, two cores", "readings/s", 110_000, None),
    ("vector", "vector of 256, Navigate", "steps/s", None, 4.0),
    ("alone", "one environment, Navigate", "steps/s", None, 3.0),
)


class UnavailableError(Exception):
    """There is no earlier code here; the text says why."""


def main() -> None:
    commit = sys.argv[1] if len(sys.argv) > 1 else COMMIT
    with ExitStack() as stack:
        now = stack.enter_context(measuring(HERE))
        before = None
        try:
            before = stack.enter_context(measuring(stack.enter_context(files_of(commit))))
        except UnavailableError as error:
            print(f"Nothing to compare with: {error}.")
        print(
            f"| | wanted | {commit[:7]} | now | now / before |\n|---|---|---|---|---|", flush=True
        )
        for name, title, unit, least, times in ROWS:
            here, there = 0.0, 0.0
            for _ in range(TURNS):
                here = max(here, rate_of(now, name))
                if before is not None:
                    there = max(there, rate_of(before, name))
            wanted = [] if least is None else [f"{least:,.0f} {unit}"]
            wanted += [] if times is None else [f"{times:g} times before"]
            earlier, ratio = "not here", ""
            if there:
                earlier, ratio = f"{there:,.0f}", f"{here / there:.1f}"
            print(
                f"| {title} | {', '.join(wanted)} | {earlier} | {here:,.0f} {unit} | {ratio} |",
                flush=True,
            )


@contextmanager
def files_of(commit: str) -> Iterator[Path]:
    """Yield a temporary folder with the project's files of a commit.

    Raises
    ------
    UnavailableError
        Without git, outside of a clone (as in an unpacked sdist), or where the clone is shallow
        and lacks the commit.
    """
    command = ["git", "-C", str(HERE), "archive", "--format=tar", commit]
    command += ["sonarmap", "worlds", "sim"]
    try:
        done = subprocess.run(command, capture_output=True, check=False)
    except FileNotFoundError:
        raise UnavailableError("git is not installed") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise UnavailableError(f"git has no commit {commit[:7]} here ({''.join(said)})")
    with tempfile.TemporaryDirectory(prefix="sonarbed-before-") as folder:
        with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
            archive.extractall(folder, filter="data")
        yield Path(folder)


@contextmanager
def measuring(tree: Path) -> Iterator[subprocess.Popen[str]]:
    """Yield a process of `rows.py` that imports the project from a folder."""
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", str(Path(__file__).with_name("rows.py"))],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tree,
        env=os.environ | {"PYTHONPATH": str(tree)},
    )  # fmt: skip
    try:
        yield process
    finally:
        process.stdin.close()
        process.wait()


def rate_of(process: subprocess.Popen[str], name: str) -> float:
    """Return one measurement of a row."""
    process.stdin.write(f"{name}\n")
    process.stdin.flush()
    line = process.stdout.readline()
    if not line:
        raise SystemExit(f"before.py: {name} failed in {process.args}, see above")
    return float(line)


if __name__ == "__main__":
    main()
