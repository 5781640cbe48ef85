"""What every command writes: to a reader that has gone, to a narrow terminal, and to one of ASCII."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

from telespring import cli

ROOT = Path(__file__).parents[1]
LOG = str(ROOT / "examples" / "log.csv")
TRIALS = str(ROOT / "examples" / "trials")
#: Commands that were added later come by themselves.
COMMANDS = sorted(typer.main.get_command(cli.app).commands)  # type: ignore[attr-defined]


def as_process(*arguments: str, stdout: int, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "telespring", *arguments],
        stdout=stdout,
        stderr=subprocess.PIPE,
        env=os.environ | environment,
        check=False,
    )


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("--help",),
        ("--version",),
        *((command, "--help") for command in COMMANDS),
        ("identify", LOG),
        ("identify", LOG, "--json"),
        ("analyse", TRIALS, "--no-figures"),
        ("analyse", TRIALS, "--no-figures", "--json"),
    ],
    ids=" ".join,
)
def test_law_a_reader_that_has_gone_is_status_141_of_every_command(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    """As `head` leaves a pipe. `telespring --help | head -1` ended with 1."""
    out = ("--out", str(tmp_path)) if arguments[:1] == ("analyse",) and "--help" not in arguments else ()
    reading, writing = os.pipe()
    os.close(reading)
    try:
        found = as_process(*arguments, *out, stdout=writing)
    finally:
        os.close(writing)
    assert found.returncode == 141
    assert found.stderr == b""


@pytest.mark.parametrize("arguments", [("identify", LOG), ("analyse", TRIALS, "--no-figures")])
def test_law_60_columns_and_ascii_lose_nothing(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    out = ("--out", "o") if arguments[0] == "analyse" else ()
    found = subprocess.run(
        [sys.executable, "-m", "telespring", *arguments, *out],
        capture_output=True,
        env=os.environ | {"COLUMNS": "60", "LC_ALL": "C", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
        check=False,
        cwd=tmp_path,
    )
    assert found.returncode == 0, found.stderr
    text = found.stdout.decode("ascii")
    assert max(map(len, text.splitlines())) <= 60
    # no letter was lost, and no cell cut
    assert "?" not in text
    assert "..." not in text
    if arguments[0] == "identify":
        assert "N*s/m" in text
