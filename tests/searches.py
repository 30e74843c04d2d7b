"""Small searches for parameters in tests."""

from dataclasses import replace

from sonarbed.reporting.drives import DriveSpec, DriveStore
from sonarbed.studies.tuning.search import Search
from sonarbed.studies.tuning.settings import TuneSettings

SMALL = TuneSettings(
    target="model",
    model="parameterized",
    sampler="tpe",
    score="skill",
    train=("thesis-exp1",),
    seeds=2,
    scans=6,
)
JUDGES = ("l-shape",)


def search_in(folder, seed=0, **changes):
    """Return a small search that is kept in a folder."""
    url = f"sqlite:///{folder}/study.db"
    return Search(replace(SMALL, **changes), folder, url, seed=seed)


def make_drives(folder):
    """Simulate the drives of small searches into a folder; return where they are."""
    search = search_in(folder)
    search.drives.simulate_missing(SMALL.drives((*SMALL.train, *JUDGES)))
    return search.drives.folder


def path_of(folder, seed):
    """Return where the drive of a small search is, of its one room."""
    return DriveStore(folder / "logs").path_of(DriveSpec("thesis-exp1", scans=6, seed=seed))


def ignore(label, done, total):
    """Take no notice of progress."""
