"""Robots, the operators who hold them, the two of them as a dyad, and the study that couples it."""

from telespring._core import (
    Agent,
    Arm,
    Condition,
    Coupling,
    DelaySystem,
    Dyad,
    Experiment,
    LaboratorySettings,
    Network,
    Operator,
    OperatorRange,
    Robot,
    Study,
    Task,
    Uncertainty,
    hman,
)

__all__ = [
    "Agent",
    "Arm",
    "Condition",
    "Coupling",
    "DelaySystem",
    "Dyad",
    "Experiment",
    "LaboratorySettings",
    "Network",
    "Operator",
    "OperatorRange",
    "Robot",
    "Study",
    "Task",
    "Uncertainty",
    "hman",
]
