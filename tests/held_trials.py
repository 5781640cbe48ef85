"""An agent that notes each trial, and holds one until its process is killed: the kill meets running work."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from resuming import wait_for

__all__ = ["arm", "begun_trials", "held_agent", "kill_the_held"]

#: It holds the third trial of a process, so that finished work is there; of all processes, one.
_AGENT = """
import os
import time
from pathlib import Path

begun = 0

class Held:
    def __init__(self, seed, folder):
        global begun
        begun += 1
        with open(Path(folder, "log.txt"), "a") as file:
            file.write(f"{os.getpid()} {seed}\\n")
        if begun >= 3 and claimed(folder):
            time.sleep(250.0)
            raise RuntimeError("nobody killed it")

    def __call__(self, time, position, velocity, target):
        return 100.0 * (target[0] - position[0]), 100.0 * (target[1] - position[1])

def claimed(folder):
    try:
        Path(folder, "armed").rename(Path(folder, f"held-{os.getpid()}"))
    except FileNotFoundError:
        return False
    return True
"""


def held_agent(folder: Path) -> dict[str, object]:
    """Write the module of the agent into the folder of a study; return its section."""
    folder.mkdir(exist_ok=True)
    (folder / "held.py").write_text(_AGENT, encoding="utf-8")
    return {"kind": "python", "class": "held:Held", "options": {"folder": folder.as_posix()}}


def arm(folder: Path) -> None:
    """Let a trial be held from now on, and forget those that began before."""
    (folder / "log.txt").unlink(missing_ok=True)
    (folder / "armed").touch()


def kill_the_held(folder: Path) -> int:
    """Kill the process that holds a trial as soon as there is one, and return its number."""
    wait_for(lambda: any(folder.glob("held-*")), seconds=100)
    [held] = folder.glob("held-*")
    process = int(held.name.removeprefix("held-"))
    os.kill(process, signal.SIGKILL)
    return process


def begun_trials(folder: Path) -> list[tuple[int, str]]:
    """List the trials that have begun, in order: the process, and the seed."""
    lines = (folder / "log.txt").read_text(encoding="utf-8").splitlines()
    return [(int(process), seed) for process, seed in (line.split() for line in lines)]
