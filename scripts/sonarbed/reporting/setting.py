"""The setting of a report: where it goes, how much is done, and the logs that studies share."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from matplotlib.figure import Figure

import sonarmap as sm
import worlds
from sim.runs.parallel import run_all
from sonarmap.errors import InputError
from sonarmap.files import atomic_path, make_folder

__all__ = ["Setting"]

Task = TypeVar("Task")
Result = TypeVar("Result")

# Raised when a study's files change their meaning: older folders are then refused, not mixed.
FORMAT_VERSION = 2
_FILE = "setting.json"
_DPI = 110


def _no_progress(label: str, done: int, total: int) -> None:
    """Report nothing."""


@dataclass(frozen=True)
class Setting:
    """How a report is made.

    Parameters
    ----------
    folder : Path
        Where it goes: a folder a study, and ``logs``.
    quick : bool
        Fewer seeds, shorter drives and coarser sweeps, to look at before the full run.
    sonar : str
        Preset of the simulated sonar.
    jobs : int
        Processes that work at once.
    on_progress : callable
        Called with a label, how much is done, and how much there is.
    study : str
        The study that is running; its files go into its own folder.
    report : str
        Which report it is; the folder of one is refused to the other.
    """

    folder: Path
    quick: bool = False
    sonar: str = "thesis"
    jobs: int = 2
    on_progress: Callable[[str, int, int], None] = field(default=_no_progress, compare=False)
    study: str = ""
    report: str = "thesis"

    @property
    def seeds(self) -> range:
        """Seeds of every number that depends on chance: ten, or three in a quick run."""
        return range(3 if self.quick else 10)

    @property
    def scans(self) -> int:
        """Length of a drive in scans of all sonars."""
        return 200 if self.quick else 500

    @property
    def place(self) -> Path:
        """Folder of the study that is running."""
        return self.folder / self.study

    def on_study(self, name: str) -> Setting:
        """Return this setting at work on a study."""
        return replace(self, study=name)

    def in_worker(self) -> Setting:
        """Return this setting for a task: it pickles, works alone and reports nothing."""
        return replace(self, jobs=1, on_progress=_no_progress)

    def claim(self) -> None:
        """Make the folder this setting's own, or raise `InputError` if it is another's."""
        make_folder(self.folder)
        mine = {
            "format": FORMAT_VERSION,
            "sonarbed": version("sonarbed"),
            "quick": self.quick,
            "sonar": self.sonar,
            "report": self.report,
        }
        file = self.folder / _FILE
        if not file.exists():
            with atomic_path(file) as path:
                path.write_text(json.dumps(mine, indent=2) + "\n", encoding="utf-8")
            return
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except ValueError:
            found = None
        if not isinstance(found, dict):
            raise InputError(f"{file}: is not the setting of a report: choose another folder")
        found.setdefault("report", "thesis")  # folders from when there was no other
        for name, value in mine.items():
            if found.get(name) != value:
                raise InputError(
                    f"{self.folder}: holds a report with {name} {found.get(name)!r}, asked for "
                    f"{value!r}: choose another folder"
                )

    def logs(
        self,
        room: str,
        *,
        driver: str = "thesis",
        scans: int | None = None,
        seeds: Iterable[int] | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> list[sm.SonarLog]:
        """Return the logs of a room, one a seed, simulated once and kept in ``logs``.

        `parameters` are the room's, see `worlds.load`.
        """
        drives = [
            _Drive(
                room=room,
                parameters=tuple(sorted((parameters or {}).items())),
                driver=driver,
                sonar=self.sonar,
                scans=self.scans if scans is None else scans,
                seed=seed,
            )
            for seed in (self.seeds if seeds is None else seeds)
        ]
        files = [self.folder / "logs" / drive.file for drive in drives]
        missing = [task for task in zip(files, drives, strict=True) if not task[0].exists()]
        if missing:
            self.map(_simulate, missing, f"driving in {room}")
        return [sm.read_log(file) for file in files]

    def map(
        self, function: Callable[[Task], Result], tasks: Sequence[Task], label: str
    ) -> list[Result]:
        """Return ``[function(task) for task in tasks]``, computed by `jobs` processes.

        `function` and the tasks must pickle. Results come in the order of the tasks, so that
        nothing depends on which process was quicker.
        """
        results: dict[int, Result] = {}
        self.on_progress(label, 0, len(tasks))
        run_all(
            function,
            tasks,
            results,
            jobs=self.jobs,
            on_done=lambda index: self.on_progress(label, len(results), len(tasks)),
        )
        return [results[index] for index in range(len(tasks))]

    def figure(self, name: str, figure: Figure, caption: str) -> tuple[str, str]:
        """Save a figure as ``NAME.png`` in the study's folder; return (file, caption)."""
        file = f"{name}.png"
        with atomic_path(self.place / file) as path:
            figure.savefig(path, dpi=_DPI)
        return file, caption

    def table(
        self, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]], caption: str
    ) -> tuple[str, str]:
        """Save a table as ``NAME.csv`` in the study's folder; return (file, caption)."""
        file = f"{name}.csv"
        with (
            atomic_path(self.place / file) as path,
            path.open("w", newline="", encoding="utf-8") as stream,
        ):
            writer = csv.writer(stream)
            writer.writerow(header)
            writer.writerows(rows)
        return file, caption


@dataclass(frozen=True)
class _Drive:
    """What a log depends on; its file is called after all of it."""

    room: str
    parameters: tuple[tuple[str, float], ...]
    driver: str
    sonar: str
    scans: int
    seed: int

    @property
    def file(self) -> str:
        # Every digit of a parameter: two rooms that differ must not share a file.
        values = [f"{name}={float(value)!r}" for name, value in self.parameters]
        made = (self.driver, self.sonar, str(self.scans), f"{self.seed:04d}")
        return "-".join([self.room, *values, *made]) + ".parquet"


def _simulate(task: tuple[Path, _Drive]) -> None:
    """Simulate a drive into its file."""
    import sim  # the simulator: loaded only when a drive is missing

    path, drive = task
    log = sim.simulate(
        worlds.load(drive.room, **dict(drive.parameters)),
        scans=drive.scans,
        seed=drive.seed,
        driver=drive.driver,
        sonar=drive.sonar,
    )
    log.write(path)
