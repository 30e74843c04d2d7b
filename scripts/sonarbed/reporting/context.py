"""What a study of a report works with: its folder, how much is done, and the drives all share."""

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
from sonarbed.reporting.drawing import save
from sonarbed.reporting.drives import DriveSpec, DriveStore, usual_driver
from sonarbed.reporting.parallel import OnProgress, no_progress, parallel_map
from sonarmap.errors import InputError
from sonarmap.files import atomic_path, make_folder

__all__ = ["StudyContext"]

Task = TypeVar("Task")
Result = TypeVar("Result")

# Raised when a study's files change their meaning: older folders are then refused, not mixed.
FORMAT_VERSION = 2
_FILE = "setting.json"


@dataclass(frozen=True)
class StudyContext:
    """How and where the studies of a report work.

    Parameters
    ----------
    folder : Path
        Where the report goes: a folder a study, and ``logs``.
    quick : bool
        Fewer seeds, shorter drives and coarser sweeps, to look at before the full run.
    sonar : str
        Preset of the simulated sonar.
    jobs : int
        Processes that work at once.
    on_progress : OnProgress
        Hears what is being done, and how far it is.
    study : str
        The study that is running; its files go into its own folder.
    report : str
        Which report it is; the folder of one is refused to the other.
    """

    folder: Path
    quick: bool = False
    sonar: str = "thesis"
    jobs: int = 2
    on_progress: OnProgress = field(default=no_progress, compare=False)
    study: str = ""
    report: str = "report"

    @property
    def seeds(self) -> range:
        """Seeds of every number that depends on chance: ten, or three in a quick run."""
        return range(3 if self.quick else 10)

    @property
    def scans(self) -> int:
        """Length of a drive in scans of all sonars."""
        return 200 if self.quick else 500

    @property
    def study_folder(self) -> Path:
        """Folder of the study that is running."""
        return self.folder / self.study

    @property
    def drives(self) -> DriveStore:
        """The drives that all studies of the report share."""
        return DriveStore(self.folder / "logs")

    def on_study(self, name: str) -> StudyContext:
        """Return this context for a study."""
        return replace(self, study=name)

    def claim(self) -> None:
        """Make the folder this report's own, or raise `InputError` if it is another's."""
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
        found.setdefault("report", "thesis")  # of a time when there was no other
        for name, value in mine.items():
            if found.get(name) != value:
                raise InputError(
                    f"{self.folder}: holds a report with {name} {found.get(name)!r}, asked for "
                    f"{value!r}: choose another folder"
                )

    def specs(
        self,
        room: str,
        *,
        driver: str | None = None,
        scans: int | None = None,
        seeds: Iterable[int] | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> list[DriveSpec]:
        """Return drives of a room, one a seed.

        What is not given is the report's: its seeds and scans, and the room's usual driver.
        `parameters` are the room's, see `worlds.load`.
        """
        room_parameters = tuple(
            (name, float(value)) for name, value in sorted((parameters or {}).items())
        )
        return [
            DriveSpec(
                room=room,
                scans=self.scans if scans is None else scans,
                seed=seed,
                driver=usual_driver(room) if driver is None else driver,
                sonar=self.sonar,
                parameters=room_parameters,
            )
            for seed in (self.seeds if seeds is None else seeds)
        ]

    def simulate_missing(self, specs: Sequence[DriveSpec], label: str = "driving") -> None:
        """Simulate the drives that the report has not made yet."""
        self.drives.simulate_missing(specs, label, jobs=self.jobs, on_progress=self.on_progress)

    def logs(self, specs: Sequence[DriveSpec], label: str = "driving") -> list[sm.SonarLog]:
        """Return the logs of drives, simulated now if the report has not made them yet."""
        self.simulate_missing(specs, label)
        return [self.drives.log(spec) for spec in specs]

    def map(
        self, function: Callable[[Task], Result], tasks: Sequence[Task], label: str
    ) -> list[Result]:
        """Return ``[function(task) for task in tasks]``, see `parallel_map`."""
        return parallel_map(function, tasks, label, jobs=self.jobs, on_progress=self.on_progress)

    def figure(self, name: str, figure: Figure, caption: str) -> tuple[str, str]:
        """Save a figure as ``NAME.png`` in the study's folder; return (file, caption)."""
        file = f"{name}.png"
        save(figure, self.study_folder / file)
        return file, caption

    def table(
        self, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]], caption: str
    ) -> tuple[str, str]:
        """Save a table as ``NAME.csv`` in the study's folder; return (file, caption)."""
        file = f"{name}.csv"
        with (
            atomic_path(self.study_folder / file) as path,
            path.open("w", newline="", encoding="utf-8") as stream,
        ):
            writer = csv.writer(stream)
            writer.writerow(header)
            writer.writerows(rows)
        return file, caption
