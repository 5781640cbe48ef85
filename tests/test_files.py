"""A file is whole or absent, whatever happens while it is written."""

from pathlib import Path

import pytest

from telespring.files import replacing, write_whole


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
