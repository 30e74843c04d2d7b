"""Writing files so that none is ever left half-written: write beside, then rename."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sonarmap.errors import InputError

__all__ = ["atomic_path", "make_folder"]


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` when the block succeeds.

    When the block raises, also on Ctrl-C, the temporary file is removed and whatever stood at
    `path` before stays as it was.

    Parameters
    ----------
    path : str or Path
        The file to be written. Its folder is made if it does not exist.

    Yields
    ------
    Path
        Where to write; it has the suffix of `path`, for libraries that look at it.

    Raises
    ------
    InputError
        If the folder cannot be made or written, or `path` is a folder.
    """
    target = Path(path)
    if target.is_dir():
        raise InputError(f"{target}: is a folder, a file name is needed")
    make_folder(target.parent)
    try:
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix
        )
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror}") from None
    os.close(handle)
    beside = Path(name)
    try:
        yield beside
        _use_default_permissions(beside)
        beside.replace(target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror or error}") from None
    finally:
        beside.unlink(missing_ok=True)


def make_folder(path: str | Path) -> Path:
    """Make the folder `path` with its parents, or raise `InputError` if that cannot be done."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise InputError(f"{folder}: cannot be made a folder: a file is in the way") from None
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
    return folder


def _use_default_permissions(path: Path) -> None:
    # mkstemp makes files that only their owner may read; a result is as open as any other file.
    mask = os.umask(0)
    os.umask(mask)
    path.chmod(0o666 & ~mask)
