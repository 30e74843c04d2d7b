"""Files: texts of any Unicode encoding are read; none is left half-written, but written beside."""

from __future__ import annotations

import codecs
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sonarmap.errors import InputError

__all__ = ["atomic_path", "decoded", "make_folder", "read_text"]

# What Notepad, PowerShell and spreadsheets put before a text, and what it means.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def read_text(path: str | Path) -> str:
    """Return the text of a file in UTF-8, or in UTF-16 with its mark; a leading mark is left out.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, or is no such text.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        return decoded(data)
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a text file") from None


def decoded(data: bytes) -> str:
    """Return the text that bytes are in UTF-8, or in UTF-16 with its mark, without that mark."""
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), "utf-8")
    return data.decode(encoding)


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
        If the folder cannot be made or written, or `path` is there and no regular file: a folder,
        a device, a pipe.

    Notes
    -----
    A symbolic link stays one: the file that it points to is replaced.
    """
    target = Path(path)
    if target.is_dir():
        raise InputError(f"{target}: is a folder, a file name is needed")
    if target.exists() and not target.is_file():
        raise InputError(f"{target}: is not a regular file: it would be replaced by one")
    make_folder(target.parent)
    try:
        real = target.resolve() if target.is_symlink() else target
        beside = _new_file_beside(real)
    except (OSError, RuntimeError) as error:  # a link that points to itself is a RuntimeError
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{target}: cannot be written: {reason}") from None
    try:
        yield beside
        _use_usual_permissions(beside, real)
        beside.replace(real)
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


def _new_file_beside(target: Path) -> Path:
    """Make an empty file in the folder of `target`, which only its owner may read."""
    # A name may have 255 bytes, and one letter may take four of them.
    prefix, suffix = f".{target.stem[:40]}-", target.suffix[:20]
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=prefix, suffix=suffix)
    os.close(handle)
    return Path(name)


def _use_usual_permissions(path: Path, target: Path) -> None:
    """Make a file as open as the one that it replaces, or as any new file."""
    if target.exists():
        mode = stat.S_IMODE(target.stat().st_mode)
    else:
        mask = os.umask(0)
        os.umask(mask)
        mode = 0o666 & ~mask
    path.chmod(mode)
