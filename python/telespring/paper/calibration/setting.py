"""What the published table leaves open about the real arms, agents and coupling, with the printed values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = ["DelayPlacement", "Setting"]

#: Which positions the coupling uses late: the partner's (Eq. 1), the own one as well (the force is late), or
#: the partner's on one side only.
DelayPlacement: TypeAlias = Literal["partner", "both", "at robot 1", "at robot 2"]


@dataclass(frozen=True)
class Setting:
    """One laboratory: alike on both sides and axes where nothing else is said, SI units.

    Attributes
    ----------
    agent_stiffness
        k_c of both agents, N/m.
    spot_lifetime
        Time until a spot of agent 2 is renewed, s.
    arm_mass, arm_damping
        What each arm adds to its robot, kg and N·s/m.
    coulomb
        Coulomb friction of a robot and its arm, N.
    coupling_lag
        Time constant of a first-order lag of the coupling force, s.
    dead_band
        Distance of the handles along an axis up to which the spring does not act, and which it then leaves
        out, m.
    force_limit
        Largest coupling force along an axis, N.
    delay_factor
        Acting delay over the printed one.
    delay_placement
        Which positions the coupling uses late.
    command_lag
        Time constant with which the arms' forces follow the agents' commands, s.
    target_offset_1, target_offset_2
        Constant displacement, along x and y, of the target that an agent follows from the one against which
        its tracking error is measured, m.
    """

    agent_stiffness: float
    spot_lifetime: float
    arm_mass: float = 0.0
    arm_damping: float = 0.0
    coulomb: float = 0.0
    coupling_lag: float = 0.0
    dead_band: float = 0.0
    force_limit: float = math.inf
    delay_factor: float = 1.0
    delay_placement: DelayPlacement = "partner"
    command_lag: float = 0.0
    target_offset_1: tuple[float, float] = (0.0, 0.0)
    target_offset_2: tuple[float, float] = (0.0, 0.0)

    @property
    def is_linear(self) -> bool:
        """Whether the motion is linear in the target and the disturbance."""
        return self.coulomb == 0.0 and self.dead_band == 0.0 and math.isinf(self.force_limit)
