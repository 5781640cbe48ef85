"""A file is whole or absent, whatever happens while it is written."""

import errno
import os
import sys
from pathlib import Path

import h5py
import pytest

from telespring._files import replacing, write_whole


def test_law_written_text_is_read_back_and_nothing_else_is_left(tmp_path: Path) -> None:
    target = tmp_path / "new folder" / "note.txt"
    write_whole(target, "δ = 0.1 s\n")
    write_whole(target, "δ = 0.2 s\n")
    assert target.read_text(encoding="utf-8") == "δ = 0.2 s\n"
    assert [entry.name for entry in target.parent.iterdir()] == ["note.txt"]


@pytest.mark.parametrize("trouble", [KeyboardInterrupt, ValueError])
def test_law_interruption_keeps_the_old_file_and_leaves_no_part(
    tmp_path: Path, trouble: type[BaseException]
) -> None:
    target = write_whole(tmp_path / "note.txt", "old")

    def interrupted() -> None:
        with replacing(target) as beside:
            beside.write_text("half of the ne")
            raise trouble

    with pytest.raises(trouble):
        interrupted()
    assert target.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["note.txt"]


def test_law_the_file_is_never_seen_in_part(tmp_path: Path) -> None:
    target = write_whole(tmp_path / "note.txt", "old")
    with replacing(target) as beside:
        beside.write_text("half")
        assert target.read_text() == "old"
        assert beside.parent == target.parent
        beside.write_text("whole")
    assert target.read_text() == "whole"


def test_law_the_file_can_be_read_as_any_other(tmp_path: Path) -> None:
    ordinary = tmp_path / "ordinary.txt"
    ordinary.write_text("")
    written = write_whole(tmp_path / "note.txt", b"")
    assert written.stat().st_mode == ordinary.stat().st_mode


def test_law_trouble_names_the_target_not_the_temporary(tmp_path: Path) -> None:
    taken = tmp_path / "taken.txt"
    taken.mkdir()
    with pytest.raises(OSError, match="taken") as refused:
        write_whole(taken, "new")
    assert refused.value.filename == str(taken)
    assert "unfinished" not in str(refused.value)
    assert [entry.name for entry in tmp_path.iterdir()] == ["taken.txt"]


def test_law_trouble_in_hdf5_names_the_target(tmp_path: Path) -> None:
    target = tmp_path / "run.nc"

    def unwritable() -> None:
        with replacing(target) as beside:
            beside.mkdir()
            try:
                h5py.File(beside, "w")
            finally:
                beside.rmdir()

    with pytest.raises(OSError, match=r"run\.nc") as refused:
        unwritable()
    assert refused.value.filename == str(target)
    assert "unfinished" not in str(refused.value)


def test_law_trouble_with_another_file_keeps_its_name(tmp_path: Path) -> None:
    other = tmp_path / "other.txt"

    def reads_another() -> None:
        with replacing(tmp_path / "note.txt"):
            other.read_text()

    with pytest.raises(FileNotFoundError) as refused:
        reads_another()
    assert refused.value.filename == str(other)


def test_law_the_longest_name_that_a_folder_takes_is_taken(tmp_path: Path) -> None:
    assert write_whole(tmp_path / ("n" * 251 + ".txt"), "x").read_text() == "x"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does this itself")
def test_law_only_what_may_be_written_is_flushed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows refuses to flush a file that was opened to be read."""
    import fcntl

    def flushed(handle: int) -> None:
        if fcntl.fcntl(handle, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))

    monkeypatch.setattr(os, "fsync", flushed)
    assert write_whole(tmp_path / "note.txt", "whole").read_text() == "whole"
