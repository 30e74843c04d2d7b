"""`Store`: where the outputs of jobs are, a folder of this machine or any fsspec URL."""

from __future__ import annotations

import os
import re
import tempfile
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Any, Protocol

from sonarmap.errors import InputError
from sonarmap.files import atomic_path, make_folder

__all__ = ["Listing", "LocalStore", "RemoteStore", "Store", "open_store"]

# Object stores show a file when all of it is there, and have no cheap renaming.
_SHOW_WHOLE_FILES = {"s3", "s3a", "gs", "gcs", "abfs", "az", "adl", "oci", "oss", "memory"}
_LOCK = ".lock"
# What `sonarmap.files.atomic_path` writes to: .NAME-RANDOM.SUFFIX
_BESIDE = re.compile(r"\..+-[a-z0-9_]{8}(\.[^.]*)?", re.DOTALL)
_LISTED_FOLDERS = 256


class Store(Protocol):
    """A tree of files, named ``folder/name``; it pickles, and may be used by many processes."""

    def __hash__(self) -> int:
        """Return the same for the same place."""

    @property
    def location(self) -> str:
        """The folder or the URL."""

    def has(self, name: str) -> bool:
        """Return whether there is a file of that name that is not empty."""

    def names(self, folder: str) -> frozenset[str]:
        """Return the names of the files in a folder that are not empty; none if it is missing."""

    def writing(self, name: str) -> Any:
        """Give a context: a local path to write to. The file appears whole when it ends well."""

    def reading(self, name: str) -> Any:
        """Give a context: the file, opened for reading bytes."""

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep the store for this process while the block runs."""
        yield

    def tidy(self) -> None:
        """Remove what a killed process left half-written; the store must be held, and ours."""


@dataclass(frozen=True)
class LocalStore:
    """A folder of this machine, or of a file system that all machines of a cluster share.

    Parameters
    ----------
    folder : Path
        The folder, absolute: workers have a current one of their own.
    """

    folder: Path

    @property
    def location(self) -> str:
        """The folder."""
        return str(self.folder)

    def has(self, name: str) -> bool:
        """Return whether there is a file of that name that is not empty."""
        path = self.folder / name
        return path.is_file() and path.stat().st_size > 0

    def names(self, folder: str) -> frozenset[str]:
        """Return the names of the files in a folder that are not empty; none if it is missing."""
        try:
            with os.scandir(self.folder / folder) as entries:
                return frozenset(e.name for e in entries if e.is_file() and e.stat().st_size > 0)
        except (FileNotFoundError, NotADirectoryError):
            return frozenset()

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Give a path beside the file; it takes the file's place when the block succeeds."""
        with atomic_path(self.folder / name) as beside:
            yield beside

    @contextmanager
    def reading(self, name: str) -> Iterator[IO[bytes]]:
        """Give the file, opened for reading bytes."""
        path = self.folder / name
        try:
            file = path.open("rb")
        except FileNotFoundError:
            raise InputError(f"{path}: no such file") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
        with file:
            yield file

    def remove(self, name: str) -> None:
        """Remove a file, if it is there, and its folder, if that is empty then."""
        path = self.folder / name
        path.unlink(missing_ok=True)
        with suppress(OSError):
            if path.parent != self.folder:
                path.parent.rmdir()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep the folder for this process while the block runs.

        Raises
        ------
        InputError
            If another process has it.
        """
        make_folder(self.folder)
        lock = self.folder / _LOCK
        try:
            handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            reason = error.strerror or error
            raise InputError(f"{self.folder}: cannot be written: {reason}") from None
        try:
            if not _locked(handle):
                raise InputError(f"{self.folder}: another process is writing there")
            try:
                yield
            finally:
                # While it is still locked: whoever comes next makes a new one.
                lock.unlink(missing_ok=True)
        finally:
            os.close(handle)

    def tidy(self) -> None:
        """Remove the files that were being written when a process was killed."""
        for folder, _, files in os.walk(self.folder):
            for name in files:
                if _BESIDE.fullmatch(name):
                    Path(folder, name).unlink(missing_ok=True)


@dataclass(frozen=True)
class RemoteStore:
    """A folder of any file system that fsspec knows, by its URL.

    Parameters
    ----------
    url : str
        Such as ``s3://bucket/folder``.
    """

    url: str

    @property
    def location(self) -> str:
        """The URL."""
        return self.url

    def has(self, name: str) -> bool:
        """Return whether there is a file of that name that is not empty."""
        files, root = self._files()
        path = f"{root}/{name}"
        return bool(files.isfile(path) and files.size(path))

    def names(self, folder: str) -> frozenset[str]:
        """Return the names of the files in a folder that are not empty; none if it is missing."""
        files, root = self._files()
        try:
            entries = files.ls(f"{root}/{folder}".rstrip("/"), detail=True, refresh=True)
        except FileNotFoundError:
            return frozenset()
        return frozenset(
            PurePosixPath(entry["name"]).name
            for entry in entries
            if entry["type"] == "file" and entry["size"]
        )

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Give a path of this machine; the file is sent there when the block succeeds."""
        files, root = self._files()
        target = f"{root}/{name}"
        with tempfile.TemporaryDirectory(prefix="sonarbed-") as folder:
            path = Path(folder) / PurePosixPath(name).name
            yield path
            try:
                files.makedirs(str(PurePosixPath(target).parent), exist_ok=True)
                if self._shows_whole_files:
                    files.put_file(str(path), target)
                else:
                    beside = str(PurePosixPath(target).with_name(f".{path.name}-{os.getpid()}"))
                    files.put_file(str(path), beside)
                    files.mv(beside, target)
            except OSError as error:
                reason = error.strerror or error
                raise InputError(f"{self.url}/{name}: cannot be written: {reason}") from error

    @contextmanager
    def reading(self, name: str) -> Iterator[IO[bytes]]:
        """Give the file, opened for reading bytes."""
        files, root = self._files()
        try:
            file = files.open(f"{root}/{name}", "rb")
        except FileNotFoundError:
            raise InputError(f"{self.url}/{name}: no such file") from None
        with file:
            yield file

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        files, root = self._files()
        with suppress(FileNotFoundError):
            files.rm_file(f"{root}/{name}")

    @contextmanager
    def held(self) -> Iterator[None]:
        """Try the place; nothing is locked there, and no half-written file is ever shown."""
        files, root = self._files()
        try:
            files.makedirs(root, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.url}: cannot be written: {error}") from None
        yield

    def tidy(self) -> None:
        """Do nothing: what is half-written there has another name, or none."""

    @property
    def _shows_whole_files(self) -> bool:
        return self.url.partition("://")[0] in _SHOW_WHOLE_FILES

    def _files(self) -> tuple[Any, str]:
        """Return the file system and the path in it."""
        try:
            from fsspec.core import url_to_fs
        except ImportError:
            raise InputError(
                f"{self.url}: a URL needs the package fsspec: pip install 'sonarbed[dask]'"
            ) from None
        try:
            files, root = url_to_fs(self.url)
        except (ImportError, ValueError, OSError) as error:
            raise InputError(f"{self.url}: {' '.join(str(error).split())}") from None
        return files, root.rstrip("/")


class Listing:
    """What is in the folders of a store; each is listed once, the last few are remembered."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._folders: OrderedDict[str, frozenset[str]] = OrderedDict()

    def has(self, name: str) -> bool:
        """Return whether the file was there when its folder was listed."""
        folder, _, file = name.rpartition("/")
        if folder not in self._folders:
            self._folders[folder] = self._store.names(folder)
            if len(self._folders) > _LISTED_FOLDERS:
                self._folders.popitem(last=False)
        return file in self._folders[folder]


def open_store(location: str | Path) -> Store:
    """Return the store of a folder or of a fsspec URL; nothing is made yet."""
    if isinstance(location, str) and "://" in location:
        return RemoteStore(location.rstrip("/"))
    path = Path(location).absolute()
    if path.exists() and not path.is_dir():
        raise InputError(f"{location}: must be a folder, but a file is in the way")
    return LocalStore(path)


def _locked(handle: int) -> bool:
    """Lock an open file for this process, or return False if another has it."""
    try:
        import fcntl
    except ImportError:  # Windows: two commands at once are left to the person
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system that cannot lock
        return True
    return True
