"""Jobs of the tests of the engine that runs them: in a module that workers can import."""

from __future__ import annotations

import errno
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from sim.runs.jobs import digest_of
from sim.runs.jobs.job import DIGITS
from sonarmap.errors import InputError


@dataclass(frozen=True)
class Write:
    """Write a text into a file, and do something else before."""

    seed: int
    deed: str = "nothing"
    diary: str = ""
    seconds: float = 0.0

    @property
    def label(self):
        return f"seed {self.seed:04d}"

    @property
    def description(self):
        return asdict(self)

    @property
    def outputs(self):
        return (f"part={self.seed % 3}/{self.seed:04d}-{digest_of(self.description)[:DIGITS]}.txt",)

    def run(self, store):
        if self.diary:
            with Path(self.diary).open("a") as diary:
                diary.write(f"{self.seed}\n")
        time.sleep(self.seconds)
        DEEDS[self.deed](self)
        with store.writing(self.outputs[0]) as path:
            path.write_text(f"{self.seed}\n" * 1000)
            time.sleep(self.seconds)
        return 1000


def fail(job):
    raise ZeroDivisionError("by\nzero")


def refuse(job):
    raise InputError("scans must be >= 1, got 0")


def die(job):
    os._exit(9)


def die_once(job):
    if Path(job.diary).read_text().split().count(str(job.seed)) == 1:
        os._exit(9)


def fill(job):
    try:
        raise OSError(errno.ENOSPC, "No space left on device")
    except OSError as error:
        raise InputError("x.parquet: cannot be written: No space left on device") from error


DEEDS = {
    "nothing": lambda job: None,
    "fail": fail,
    "refuse": refuse,
    "die": die,
    "die once": die_once,
    "fill": fill,
}
