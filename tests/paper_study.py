"""The paper's study as the command `telespring reproduce` made it, and another study."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from typer.testing import Result

__all__ = ["HELD", "PaperStudy"]

# Ranges of operators, jitter, gaps and sampled controllers, so that every part of the network counts.
HELD = """
name = "held"
robot1 = {mass = [0.8334, 1.0649], damping = [7.7257, 10.1168], axes = ["x", "y"]}
robot2 = {mass = [0.7776, 1.3407], damping = [7.4208, 9.3496], axes = ["x", "y"]}
operator1 = {mass = 0.5, damping = 1.0, stiffness = {min = 0.0, max = 300.0}}
operator2 = {mass = 0.5, damping = 1.0}
coupling.stiffness = 30.0
network = {delay = 0.05, jitter = 0.01, max_gap = 0.004}
controller = {sample_period = 0.002, computing_time = 0.0005}
protocol = {stiffness = [30.0], delay = [0.05], trials = 3, duration = 8.0, discard = 2.0}
"""


@dataclass(frozen=True)
class PaperStudy:
    """What `telespring reproduce` printed, and the folder that it wrote."""

    result: Result
    folder: Path
