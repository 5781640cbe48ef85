"""The folder of a rehearsal or a comparison is claimed by one rule."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import telespring as ts

ROBOTS = "robot1 = {mass = [0.8, 1.0], damping = 7.7}\nrobot2 = {mass = [0.8, 1.0], damping = 7.7}\n"
PROTOCOL = (
    "protocol = {unconnected = false, conditions = [{stiffness = 40.0, delay = 0.05}], "
    "trials = 1, duration = 1.0, discard = 0.2}\n"
)

RUNS: dict[str, Callable[[ts.Study, Path], object]] = {
    "rehearsal": ts.rehearse,
    "comparison": lambda study, folder: ts.compare(study, folder, quick=True),
}


def study(name: str) -> ts.Study:
    return ts.Study.from_toml(f'name = "{name}"\n{ROBOTS}{PROTOCOL}')


@pytest.mark.parametrize("kind", RUNS)
@pytest.mark.parametrize("content", [b"my notes", b"{}", b"[1]", b"\xff\xfe"])
def test_law_a_file_of_the_name_of_an_identity_that_is_none_is_refused_and_kept(
    kind: str, content: bytes, tmp_path: Path
) -> None:
    file = tmp_path / f"{kind}.json"
    file.write_bytes(content)
    with pytest.raises(ts.InvalidInput, match=f"named like those of a {kind} but are not from one"):
        RUNS[kind](study("one"), tmp_path)
    assert file.read_bytes() == content


@pytest.mark.parametrize("kind", RUNS)
def test_law_an_identity_without_finished_trials_gives_way(kind: str, tmp_path: Path) -> None:
    class Stopped(Exception):
        pass

    def stop(*_: int) -> None:
        raise Stopped

    first, other = study("one"), study("other")
    run = ts.rehearse if kind == "rehearsal" else ts.compare
    with pytest.raises(Stopped):
        run(first, tmp_path, progress=stop)
    assert '"one"' in (tmp_path / f"{kind}.json").read_text()
    assert not list(tmp_path.rglob("*.trial"))
    RUNS[kind](other, tmp_path)
    # with finished trials it stays
    with pytest.raises(ts.InvalidInput, match="another study, 'other'"):
        RUNS[kind](first, tmp_path)
