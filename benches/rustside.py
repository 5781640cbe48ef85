"""Builds and runs the Rust program that times the Rust calls, and reads what it wrote."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from harness import Timing
from numpy.typing import NDArray

CRATE = Path(__file__).resolve().parent / "rust"


class RustSide:
    """Timings and positions from one run of the Rust program."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.values: dict[str, Any] = json.loads((directory / "timings.json").read_text(encoding="utf-8"))

    def timing(self, name: str) -> Timing:
        value = self.values[name]
        if isinstance(value, str):
            raise RuntimeError(value)
        return Timing(**value)

    def positions(self, name: str) -> NDArray[np.float64]:
        """(robot, time), or (simulation, robot, time) flattened for the grid."""
        return np.fromfile(self.directory / f"{name}.f64", dtype="<f8").reshape(2, -1)


PROGRAM = CRATE / "target" / "release" / "telespring-bench"


def build() -> None:
    """Build the program in release mode."""
    subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=CRATE, check=True)


def measure(directory: Path, quick: bool) -> RustSide:
    """Run it, its files into the directory."""
    subprocess.run([PROGRAM, directory, *(["--quick"] if quick else [])], check=True)
    return RustSide(directory)
