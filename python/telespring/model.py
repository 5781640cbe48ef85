"""Robots, the operators who hold them, the two of them as a dyad, and the study that couples it."""

from telespring._core import (
    Coupling,
    DelaySystem,
    Dyad,
    DyadAxis,
    Experiment,
    Network,
    Operator,
    OperatorRange,
    Robot,
    Study,
    Uncertainty,
    hman,
)

__all__ = [
    "Coupling",
    "DelaySystem",
    "Dyad",
    "DyadAxis",
    "Experiment",
    "Network",
    "Operator",
    "OperatorRange",
    "Robot",
    "Study",
    "Uncertainty",
    "hman",
]
