"""Many jobs of any kind: by processes of this machine or a Dask cluster, resumed after a kill.

A `Job` is a picklable value with a digest of all that decides its outputs; `run_jobs` runs those
whose outputs are not in the `Store` yet. What is complete is decided by the files alone: each
output has its job's digest in its name, is written beside and renamed. So there is no state that a
kill could tear, and the same call finishes what is missing.

>>> store = open_store("out")
>>> with store.held():
...     store.tidy()  # once it is known that the folder is ours
...     report = run_jobs(jobs, store, workers=Processes(2))
"""

from sim.runs.jobs.cluster import DaskCluster
from sim.runs.jobs.job import Job, JobFailure, digest_of
from sim.runs.jobs.processes import Processes, ThisProcess, Workers, one_thread_each
from sim.runs.jobs.running import JobProgress, JobsReport, run_jobs
from sim.runs.jobs.store import LocalStore, RemoteStore, Store, open_store

__all__ = [
    "DaskCluster",
    "Job",
    "JobFailure",
    "JobProgress",
    "JobsReport",
    "LocalStore",
    "Processes",
    "RemoteStore",
    "Store",
    "ThisProcess",
    "Workers",
    "digest_of",
    "one_thread_each",
    "open_store",
    "run_jobs",
]
