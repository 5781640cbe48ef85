"""What tests of interrupted work have in common: folders, interruptions, processes that are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from telespring.rehearsal.store import LOCK_FILE

__all__ = ["interrupted_after", "killed_at", "left_in", "started", "wait_for", "written"]


def written(folder: Path, text: str) -> Path:
    """Write a study into a folder."""
    folder.mkdir(exist_ok=True)
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    return path


def left_in(folder: Path) -> list[str]:
    """List everything in a folder and below, without locks."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.name != LOCK_FILE)


def interrupted_after(trials: int) -> Callable[[int, int], None]:
    """Return a function that is told the progress and interrupts the work after so many trials."""

    def progress(done: int, _total: int) -> None:
        if done == trials:
            raise KeyboardInterrupt

    return progress


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds, for half a minute at most."""
    for _ in range(3000):
        if condition():
            return
        time.sleep(0.01)
    pytest.fail("waited half a minute in vain")


def started(*arguments: str | Path, until: Callable[[int], bool]) -> subprocess.Popen[bytes]:
    """Start a command of telespring; wait until a condition on its process id holds, or it has ended."""
    call = [sys.executable, "-m", "telespring", *map(str, arguments)]
    process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    wait_for(lambda: until(process.pid) or process.poll() is not None)
    return process


def killed_at(place: str, function: str, study: str, folder: Path) -> None:
    """Call `telespring.<function>` with a study's text and a folder in a process that dies in `place`."""
    code = (
        "import os, signal, sys, unittest.mock, telespring as ts\n"
        "import telespring.comparison.run, telespring.rehearsal.dataset\n"
        "kill = lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL)\n"
        "with unittest.mock.patch(sys.argv[1], kill):\n"
        "    getattr(ts, sys.argv[2])(ts.Study.from_toml(sys.argv[3]), sys.argv[4])"
    )
    call = [sys.executable, "-c", code, place, function, study, str(folder)]
    assert subprocess.run(call, check=False, env=os.environ).returncode == -signal.SIGKILL
