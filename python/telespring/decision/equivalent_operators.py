"""Operators equivalent to a study's arms and agents, for the stability criteria."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from telespring.model import Arm, Dyad, Operator, Study

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = ["ArmKind", "EquivalentOperators", "equivalent_operators"]

ArmKind: TypeAlias = Literal["massless", "lumped", "two-link"]
Pair: TypeAlias = tuple[float, float]

_ZERO: Pair = (0.0, 0.0)


@dataclass(frozen=True)
class EquivalentOperators:
    """The robots, and operators equivalent to the arms and agents at their handles.

    Attributes
    ----------
    free
        The bare robots with their coupling damper. Arms and agents replace the operators of the study.
    held
        The same robots with all that does not depend on the pose as operators: the agents' springs and
        dampers, and the mass and damping of lumped arms.
    jointed
        The arms whose inertia depends on the pose; None on a side without one.
    agent_stiffness, agent_damping
        Of agents 1 and 2 on both axes, N/m and N·s/m.
    arm_mass, arm_damping
        Of lumped arms 1 and 2 per axis, kg and N·s/m; zero for other arms.
    """

    free: Dyad
    held: Dyad
    jointed: tuple[Arm | None, Arm | None]
    agent_stiffness: Pair
    agent_damping: Pair
    arm_mass: tuple[Pair, Pair]
    arm_damping: tuple[Pair, Pair]

    @property
    def depends_on_pose(self) -> bool:
        """Whether an arm couples the axes, differently in every pose."""
        return self.jointed != (None, None)

    @property
    def arm_kinds(self) -> tuple[ArmKind, ArmKind]:
        """Kind of both arms; a lumped arm without mass and damping is massless."""

        def kind(side: int) -> ArmKind:
            if self.jointed[side] is not None:
                return "two-link"
            massless = self.arm_mass[side] == self.arm_damping[side] == _ZERO
            return "massless" if massless else "lumped"

        return kind(0), kind(1)


def equivalent_operators(study: Study, experiment: Experiment) -> EquivalentOperators:
    """Replace the arms and agents of a study by operators; both agents must be springs.

    A skilled agent pulls with k_c (p* - p) and its damper (Eq. 13), a less-skilled one with k_c towards
    the mean of its spots (Eq. 14). How the target moves does not affect stability.

    Examples
    --------
    >>> import telespring as ts
    >>> study = ts.Study.paper()
    >>> operators = equivalent_operators(study, study.experiment)
    >>> operators.arm_kinds, operators.agent_stiffness
    (('massless', 'massless'), (120.0, 120.0))
    """
    (arm1, arm2), (agent1, agent2) = experiment.arms, experiment.agents
    stiffness = (agent1.stiffness or 0.0, agent2.stiffness or 0.0)
    damping = (agent1.damping or 0.0, agent2.damping or 0.0)
    # None for the kinds of arm without such a key: a two-link arm acts by its links instead.
    mass = (arm1.mass or _ZERO, arm2.mass or _ZERO)
    drag = (arm1.damping or _ZERO, arm2.damping or _ZERO)
    first, second = (
        Operator(mass[i], [viscous + damping[i] for viscous in drag[i]], [stiffness[i]] * 2) for i in (0, 1)
    )
    robots, damper = study.dyad.robots, study.dyad.coupling_damping
    return EquivalentOperators(
        free=Dyad(*robots, coupling_damping=damper),
        held=Dyad(*robots, (first, second), damper),
        jointed=(arm1 if arm1.kind == "two-link" else None, arm2 if arm2.kind == "two-link" else None),
        agent_stiffness=stiffness,
        agent_damping=damping,
        arm_mass=mass,
        arm_damping=drag,
    )
