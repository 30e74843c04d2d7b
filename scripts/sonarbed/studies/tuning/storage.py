"""Where an Optuna study is kept: connected once a process, and one clear line when it fails."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache

import optuna
from sqlalchemy import event
from sqlalchemy.engine import make_url
from sqlalchemy.exc import SQLAlchemyError

from sonarmap.errors import InputError

__all__ = ["StudyStorage", "connect", "quiet_optuna", "release"]

# Processes that share an SQLite file wait for one another this long, seconds.
_SQLITE_WAIT_S = 60
# Who makes the tables or the study at the same time as another is told of it in these words.
_RACES = ("already exists", "unique constraint", "duplicate", "database is locked")
_TRIES, _PAUSE_S = 20, 0.2


@dataclass(frozen=True)
class StudyStorage:
    """Where a study is kept.

    Parameters
    ----------
    url : str
        URL of Optuna's storage.
    study_name : str
        Name of the study in it.
    maximize : bool
        Whether a higher score is better, for a study that is made now.
    """

    url: str
    study_name: str
    maximize: bool

    @property
    def shown_url(self) -> str:
        """The URL without its password."""
        try:
            return make_url(self.url).render_as_string(hide_password=True)
        except SQLAlchemyError:
            return self.url

    @contextmanager
    def usable(self) -> Iterator[None]:
        """Turn what the storage raises into one `InputError` that names it."""
        try:
            yield
        except (SQLAlchemyError, optuna.exceptions.OptunaError) as error:
            raise self._unusable(error) from None

    def open(self) -> tuple[optuna.storages.RDBStorage, optuna.Study]:
        """Return the storage and its study, made if it is new."""
        url = make_url(self.url)
        sqlite = url.get_backend_name() == "sqlite"
        if sqlite and url.database in (None, "", ":memory:"):
            raise InputError(f"storage must be kept, got {self.url!r}, which is in memory")
        for _ in range(_TRIES - 1):
            try:
                return self._opened(sqlite=sqlite)
            except (SQLAlchemyError, optuna.exceptions.OptunaError) as error:
                if not _is_race(error):
                    raise
                time.sleep(_PAUSE_S)
        return self._opened(sqlite=sqlite)

    def _opened(self, *, sqlite: bool) -> tuple[optuna.storages.RDBStorage, optuna.Study]:
        try:
            storage = optuna.storages.RDBStorage(
                self.url,
                engine_kwargs={"connect_args": {"timeout": _SQLITE_WAIT_S}} if sqlite else None,
            )
        except (ImportError, RuntimeError) as error:
            # No driver for such a database; tables that another version of Optuna made.
            raise self._unusable(error) from None
        if sqlite:
            # A trial is a dozen commits, and each would wait for the disk. With a write-ahead log
            # only a power cut can lose any, the last ones; the file stays sound.
            storage.engine.dispose()
            event.listen(storage.engine, "connect", _write_ahead)
        study = optuna.create_study(
            storage=storage,
            study_name=self.study_name,
            direction="maximize" if self.maximize else "minimize",
            load_if_exists=True,
        )
        return storage, study

    def _unusable(self, error: BaseException) -> InputError:
        # The innermost reason is the database's own: "unable to open database file".
        while error.__cause__ is not None:
            error = error.__cause__
        line = next(iter(str(error).splitlines()), type(error).__name__)
        return InputError(f"storage {self.shown_url} cannot be used: {line}")


def _is_race(error: BaseException | None) -> bool:
    """Return whether a database refuses only because another process does the same just now."""
    while error is not None:
        if any(words in str(error).lower() for words in _RACES):
            return True
        error = error.__cause__
    return False


@lru_cache(maxsize=1)
def _connected(storage: StudyStorage) -> tuple[optuna.storages.RDBStorage, optuna.Study]:
    return storage.open()


def connect(storage: StudyStorage) -> optuna.Study:
    """Return the study, connected once a process."""
    return _connected(storage)[1]


def release(storage: StudyStorage) -> None:
    """Close this process's connection, if there is one; its workers' end with them."""
    if _connected.cache_info().currsize:
        database, _ = _connected(storage)
        database.remove_session()
        database.engine.dispose()
    _connected.cache_clear()


def _write_ahead(connection: sqlite3.Connection, record: object) -> None:
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = NORMAL")


@contextmanager
def quiet_optuna() -> Iterator[None]:
    """Keep Optuna from talking while the block runs; the caller shows its own progress."""
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        yield
    finally:
        optuna.logging.set_verbosity(before)
