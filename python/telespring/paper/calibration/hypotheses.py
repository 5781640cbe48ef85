"""Named hypotheses on what made the published errors: one departure each from the printed laboratory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.setting import Setting

__all__ = ["COMMON", "HYPOTHESES", "NULL", "Hypothesis", "Parameter"]


@dataclass(frozen=True)
class Parameter:
    """A quantity that a fit may choose between `low` and `high`, SI units."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str


#: Free under every hypothesis: the paper prints none of them. Table III's identification went through an
#: arm, so an arm mass of 0 means that Table III includes the arm.
COMMON = (
    Parameter("arm_mass", "kg", 0.0, 4.0, "mass that an arm adds to its robot"),
    Parameter("arm_damping", "N·s/m", 0.0, 40.0, "viscous damping that an arm adds to its robot"),
    Parameter("spot_lifetime", "s", 0.05, 1.0, "time until a spot of agent 2 is renewed"),
)


@dataclass(frozen=True)
class Hypothesis:
    """One departure: its own parameters besides the common ones, or a fixed change.

    Attributes
    ----------
    name
        As in `study.json`.
    own
        Parameters that only this hypothesis frees.
    fixed
        Values of a `Setting` that it changes.
    """

    name: str
    own: tuple[Parameter, ...] = ()
    fixed: Mapping[str, Any] = field(default_factory=dict)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All free parameters, the own ones first."""
        return (*self.own, *COMMON)

    @property
    def low(self) -> FloatArray:
        """Lower ends of the searched ranges."""
        return np.array([each.low for each in self.parameters])

    @property
    def high(self) -> FloatArray:
        """Upper ends of the searched ranges."""
        return np.array([each.high for each in self.parameters])

    def values_at(self, printed: Setting, common: Mapping[str, float]) -> FloatArray:
        """Return values of `parameters`: these common ones, and own ones as near to the printed as can be."""
        plain = [
            common.get(parameter.name, getattr(printed, parameter.name, 0.0)) for parameter in self.parameters
        ]
        return np.asarray(np.clip(np.array(plain, dtype=float), self.low, self.high))

    def setting(self, printed: Setting, values: FloatArray) -> Setting:
        """Return the laboratory with these values of `parameters`, everything else as printed."""
        changes: dict[str, Any] = dict(self.fixed)
        for parameter, value in zip(self.parameters, values.tolist(), strict=True):
            name, _, axis = parameter.name.rpartition("_")
            if name.startswith("target_offset"):
                x, y = changes.get(name, (0.0, 0.0))
                changes[name] = (value, y) if axis == "x" else (x, value)
            else:
                changes[parameter.name] = value
        return replace(printed, **changes)


def _offset(robot: int, axis: str, low: float) -> Parameter:
    return Parameter(
        f"target_offset_{robot}_{axis}", "m", low, 0.03, f"along {axis}, of the target of robot {robot}"
    )


#: The errors that the paper prints for the unconnected mode, in every condition: nothing is fitted.
NULL = "as unconnected"

#: In the order of the report. The agents' stiffness and a gain of the coupling are never both free: with
#: all masses, dampings and stiffnesses scaled alike the motion is the same.
HYPOTHESES = (
    Hypothesis("printed values"),
    Hypothesis(
        "agent stiffness", (Parameter("agent_stiffness", "N/m", 60.0, 500.0, "stiffness of both agents"),)
    ),
    Hypothesis("coupling lag", (Parameter("coupling_lag", "s", 0.0, 1.0, "lag of the coupling force"),)),
    Hypothesis(
        "dead band", (Parameter("dead_band", "m", 0.0, 0.1, "distance within which the spring is off"),)
    ),
    Hypothesis(
        "force limit", (Parameter("force_limit", "N", 0.1, 20.0, "largest coupling force on an axis"),)
    ),
    Hypothesis("Coulomb friction", (Parameter("coulomb", "N", 0.0, 2.0, "friction of a robot and its arm"),)),
    Hypothesis(
        "delay factor", (Parameter("delay_factor", "1", 0.0, 1.5, "acting delay over the printed one"),)
    ),
    Hypothesis("delay of both positions", fixed={"delay_placement": "both"}),
    Hypothesis("delay at robot 1 only", fixed={"delay_placement": "at robot 1"}),
    Hypothesis("delay at robot 2 only", fixed={"delay_placement": "at robot 2"}),
    Hypothesis("command lag", (Parameter("command_lag", "s", 0.0, 0.3, "lag of the arms' forces"),)),
    Hypothesis(
        "target offset",
        # mirrored offsets give the same errors: those of robot 1 need only one sign
        (_offset(1, "x", 0.0), _offset(1, "y", 0.0), _offset(2, "x", -0.03), _offset(2, "y", -0.03)),
    ),
)
