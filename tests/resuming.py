"""What tests of interrupted work have in common: folders, interruptions, processes that are killed."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from telespring.rehearsal.store import LOCK_FILE
from telespring.rehearsal.trial_file import read_trial_file

__all__ = [
    "finished_trials",
    "interrupted_after",
    "killed_at",
    "killed_until_it_comes_through",
    "left_in",
    "started",
    "wait_for",
    "written",
]


def written(folder: Path, text: str) -> Path:
    """Write a study into a folder."""
    folder.mkdir(exist_ok=True)
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    return path


def left_in(folder: Path) -> list[str]:
    """List everything in a folder and below, without locks."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.name != LOCK_FILE)


def finished_trials(folder: Path) -> list[Path]:
    """List the files of trials that an unfinished rehearsal or comparison keeps."""
    return list(folder.rglob("[!.]*.trial"))


def interrupted_after(trials: int) -> Callable[[int, int], None]:
    """Return a function that is told the progress and interrupts the work after so many trials."""

    def progress(done: int, _total: int) -> None:
        if done == trials:
            raise KeyboardInterrupt

    return progress


def wait_for(condition: Callable[[], bool], seconds: int = 30) -> None:
    """Wait until a condition holds, for so many seconds of sleep at most: more of them on a busy machine."""
    for _ in range(100 * seconds):
        if condition():
            return
        time.sleep(0.01)
    pytest.fail(f"waited {seconds} s in vain")


def started(*arguments: str | Path, until: Callable[[int], bool]) -> subprocess.Popen[bytes]:
    """Start a command of telespring; wait until a condition on its process id holds, or it has ended."""
    call = [sys.executable, "-m", "telespring", *map(str, arguments)]
    process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    wait_for(lambda: until(process.pid) or process.poll() is not None)
    return process


def killed_until_it_comes_through(
    start: Callable[[], subprocess.Popen[bytes]], folder: Path, *, mean: float, seed: int
) -> None:
    """Kill a command again and again until it ends by itself; each start goes on where the last was.

    The first kill waits for a finished trial, however slow the machine. The others come at random moments,
    later and later, so that every part is met and yet the command comes through.

    Parameters
    ----------
    start
        Starts the command and waits until it is at work.
    folder
        Where it works.
    mean
        By how much the mean time before a kill grows from one to the next, in seconds.
    seed
        Of the random moments.
    """
    moments = random.Random(seed)
    process = start()
    wait_for(lambda: bool(finished_trials(folder)) or process.poll() is not None)
    for attempt in range(100):
        if attempt > 0:
            process = start()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(moments.expovariate(1.0 / (mean * attempt)))
        process.send_signal(signal.SIGKILL)
        output, _ = process.communicate()
        if process.returncode == 0:
            assert attempt > 0, "it ended before it could be killed: this shows nothing"
            return
        assert process.returncode == -signal.SIGKILL, output.decode()
        # never an unfinished trial under a finished one's name
        assert all(read_trial_file(file) is not None for file in finished_trials(folder))
    pytest.fail("it never came through")


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
