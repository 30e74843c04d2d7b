import errno
import os
import stat
from pathlib import Path

import pytest

from sonarmap.errors import InputError
from sonarmap.files import atomic_path, make_folder


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_file_is_there_when_the_block_is_done(tmp_path):
    target = tmp_path / "out.txt"
    with atomic_path(target) as beside:
        beside.write_text("new")
        assert not target.exists()
        assert beside.parent == tmp_path, "a rename must not cross file systems"
        assert beside.suffix == ".txt"
    assert target.read_text() == "new"
    assert names(tmp_path) == ["out.txt"]


def test_an_older_file_is_replaced_at_once(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with atomic_path(target) as beside:
        beside.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"


@pytest.mark.parametrize("trouble", [RuntimeError, KeyboardInterrupt, SystemExit, MemoryError])
@pytest.mark.parametrize("old", ["old", None])
def test_trouble_inside_leaves_all_as_it_was(trouble, old, tmp_path):
    target = tmp_path / "out.txt"
    if old:
        target.write_text(old)

    def half_way():
        with atomic_path(target) as beside:
            beside.write_text("half")
            raise trouble

    with pytest.raises(trouble):
        half_way()
    assert names(tmp_path) == (["out.txt"] if old else [])
    assert not old or target.read_text() == old


def test_a_full_disk_is_bad_input_and_leaves_all_as_it_was(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("old")

    def full():
        with atomic_path(target) as beside:
            beside.write_text("half")
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(InputError, match=r"out\.txt: cannot be written: No space left on device$"):
        full()
    assert target.read_text() == "old"
    assert names(tmp_path) == ["out.txt"]


def test_folders_are_made(tmp_path):
    with atomic_path(tmp_path / "a" / "b" / "out.txt") as beside:
        beside.write_text("new")
    assert (tmp_path / "a" / "b" / "out.txt").read_text() == "new"
    assert make_folder(tmp_path / "a" / "b") == tmp_path / "a" / "b"


@pytest.mark.parametrize("place", ["file/out.txt", "file/deeper/out.txt"])
def test_a_file_in_the_way_of_a_folder(place, tmp_path):
    (tmp_path / "file").write_text("I was here first")

    def write():
        with atomic_path(tmp_path / place):
            pytest.fail("the block must not run")

    with pytest.raises(InputError, match=r"cannot be made a folder: a file is in the way$"):
        write()
    assert (tmp_path / "file").read_text() == "I was here first"


def test_a_folder_in_the_way_of_a_file(tmp_path):
    def write():
        with atomic_path(tmp_path):
            pytest.fail("the block must not run")

    with pytest.raises(InputError, match=r": is a folder, a file name is needed$"):
        write()


def test_a_folder_that_may_not_be_written(tmp_path, monkeypatch):
    # Root may write everywhere, so the refusal is played.
    def refuse(**_):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("tempfile.mkstemp", refuse)

    def write():
        with atomic_path(tmp_path / "out.txt"):
            pytest.fail("the block must not run")

    with pytest.raises(InputError, match=r"out\.txt: cannot be written: Permission denied$"):
        write()


def test_a_result_is_as_open_as_any_other_file(tmp_path):
    (tmp_path / "plain").write_text("")
    with atomic_path(tmp_path / "out") as beside:
        beside.write_text("")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "out")}
    assert len(modes) == 1


def write_to(path, text="new"):
    with atomic_path(path) as beside:
        beside.write_text(text)


def test_a_device_or_pipe_is_not_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    link = tmp_path / "link-to-a-device"
    link.symlink_to(os.devnull)
    for path in (pipe, link, Path(os.devnull)):
        with pytest.raises(
            InputError, match=r"is not a regular file: it would be replaced by one$"
        ):
            write_to(path)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)


def test_a_link_stays_one_and_its_file_is_replaced(tmp_path):
    real, link = tmp_path / "elsewhere" / "real.txt", tmp_path / "link.txt"
    write_to(real, "old")
    link.symlink_to(real)
    write_to(link)
    assert link.is_symlink()
    assert real.read_text() == "new"
    dangling = tmp_path / "dangling.txt"
    dangling.symlink_to(tmp_path / "elsewhere" / "later.txt")
    write_to(dangling)
    assert (tmp_path / "elsewhere" / "later.txt").read_text() == "new"
    assert [path.name for path in (tmp_path / "elsewhere").iterdir() if path.name[0] == "."] == []


def test_a_file_keeps_the_permissions_that_it_was_given(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    path.chmod(0o600)
    write_to(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "name", ["a" * 251 + ".txt", "ö" * 100 + ".parquet", ".hidden", "no-suffix"]
)
def test_any_name_that_a_file_may_have_can_be_written(name, tmp_path):
    write_to(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == [name]
