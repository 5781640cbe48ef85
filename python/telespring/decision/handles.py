"""What holds a study's handles in its rehearsal: arms and agents, as the stability criteria take them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._types import FloatArray
from telespring.model import Dyad, Operator, Study
from telespring.rehearsal.target import path_of_program
from telespring.study.target import figure_eight_path

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = ["Holding", "holding_of", "places_of", "unknown_agents"]

#: Poses that are looked at. Of smooth paths the worst pose is met to its square: 32 to a period of the
#: figure of eight, its four outermost points among them.
POSES = 32

Pair = tuple[float, float]


@dataclass(frozen=True)
class Holding:
    """Robots with what holds their handles.

    Attributes
    ----------
    free
        The bare robots with their coupling damper: arms and agents take the place of a study's operators.
    held
        The same with what is alike in every pose as operators: the agents' springs and dampers, the mass
        and damping of lumped arms.
    jointed
        The arms whose inertia depends on the pose; None on a side without one.
    agent_stiffness, agent_damping
        Of agent 1 and 2, N/m and N·s/m, on both axes.
    arm_mass, arm_damping
        Of lumped arm 1 and 2 per axis, kg and N·s/m; zero for the other kinds.
    """

    free: Dyad
    held: Dyad
    jointed: tuple[Mapping[str, Any] | None, Mapping[str, Any] | None]
    agent_stiffness: Pair
    agent_damping: Pair
    arm_mass: tuple[Pair, Pair]
    arm_damping: tuple[Pair, Pair]

    @property
    def depends_on_pose(self) -> bool:
        """Whether an arm couples the axes, in every pose differently."""
        return self.jointed != (None, None)

    @property
    def has_arms(self) -> bool:
        """Whether an arm has mass or damping."""
        return self.depends_on_pose or self.arm_mass != _NONE or self.arm_damping != _NONE

    def in_words(self) -> str:
        """Say what holds the handles."""
        stiffness = _alike(self.agent_stiffness, "N/m")
        damping = _alike(self.agent_damping, "N·s/m") if any(self.agent_damping) else ""
        agents = f"agents with {stiffness}{f', {damping}' if damping else ''}"
        kinds = [
            "two-link" if jointed is not None else "lumped" if (mass, drag) != (_ZERO, _ZERO) else "massless"
            for jointed, mass, drag in zip(self.jointed, self.arm_mass, self.arm_damping, strict=True)
        ]
        if kinds[0] == kinds[1]:
            return f"{kinds[0]} arms, {agents}"
        return f"a {kinds[0]} and a {kinds[1]} arm, {agents}"


_ZERO: Pair = (0.0, 0.0)
_NONE: tuple[Pair, Pair] = (_ZERO, _ZERO)


def unknown_agents(experiment: Experiment) -> str | None:
    """Say why the stability in arms is not known: nobody knows the stiffness of a program.

    Parameters
    ----------
    experiment
        A study's protocol.

    Returns
    -------
    str or None
        The reason, or None where both agents are springs.
    """
    programs = [
        f"agent {robot} is the program {agent['class']}"
        for robot, agent in enumerate(experiment.agents, start=1)
        if agent["kind"] == "python"
    ]
    if not programs:
        return None
    whose = "whose stiffness is" if len(programs) == 1 else "whose stiffnesses are"
    return f"{' and '.join(programs)}, {whose} not known"


def holding_of(study: Study, experiment: Experiment) -> Holding:
    """Find what holds the handles of a study whose agents are both springs.

    A skilled agent pulls with k_c (p* - p) and its damper (Eq. 13), a less-skilled one with k_c towards
    the mean of its spots (Eq. 14); how either target moves does not matter to stability.

    Parameters
    ----------
    study
        Robots and coupling.
    experiment
        Its protocol, with arms and agents.

    Returns
    -------
    Holding
        Robots, operators and jointed arms.

    Examples
    --------
    >>> import telespring as ts
    >>> study = ts.Study.paper()
    >>> holding_of(study, study.experiment).in_words()
    'massless arms, agents with 120 N/m'
    """
    first, second = experiment.agents
    stiffness = (float(first["stiffness"]), float(second["stiffness"]))
    damping = (float(first.get("damping", 0.0)), float(second.get("damping", 0.0)))
    lumped = [arm.to_dict() if arm.kind == "lumped" else {} for arm in experiment.arms]
    jointed = [arm.to_dict() if arm.kind == "two-link" else None for arm in experiment.arms]
    mass, drag = ([_per_axis(arm.get(key, 0.0)) for arm in lumped] for key in ("mass", "damping"))
    operators = [
        Operator(list(mass[i]), [each + damping[i] for each in drag[i]], [stiffness[i]] * 2) for i in range(2)
    ]
    robots, damper = study.dyad.robots, float(study.dyad.coupling_damping)
    return Holding(
        free=Dyad(*robots, coupling_damping=damper),
        held=Dyad(*robots, (operators[0], operators[1]), damper),
        jointed=(jointed[0], jointed[1]),
        agent_stiffness=stiffness,
        agent_damping=damping,
        arm_mass=(mass[0], mass[1]),
        arm_damping=(drag[0], drag[1]),
    )


def places_of(experiment: Experiment, modules: Path | None = None) -> tuple[FloatArray, str]:
    """Choose places along the target's path at which poses are looked at.

    Parameters
    ----------
    experiment
        A study's protocol.
    modules
        Where a target in Python is looked up first: the folder of the study's file.

    Returns
    -------
    places : ndarray, (pose, 2)
        Different places, m: of the figure of eight evenly in phase; of a target in Python those that leave
        no part of its trial far from one of them.
    along : str
        What they are from.

    Raises
    ------
    telespring.InvalidInput
        Where a target in Python is not found or returns what is no target.

    Examples
    --------
    >>> import telespring as ts
    >>> places, along = places_of(ts.Study.paper().experiment)
    >>> len(places), along  # the centre is passed twice
    (31, 'one period of the target')
    """
    if experiment.task["kind"] != "python":
        path, whole = figure_eight_path(experiment, POSES)
        # Rounded, so that sin(2π) is sin(0): far below what moves a pose.
        places = np.unique(np.round(path, 12) + 0.0, axis=0)
        return places, f"{'one period' if whole else 'the trial'} of the target"
    return _spread(path_of_program(experiment, modules), POSES), "a whole trial of the target"


def _spread(path: FloatArray, count: int) -> FloatArray:
    """Choose points that are as far from each other as can be, one after the other."""
    chosen = [int(np.argmax(np.hypot(*(path - path.mean(axis=0)).T)))]
    distance = np.hypot(*(path - path[chosen[0]]).T)
    while len(chosen) < count and distance.max() > 0.0:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.hypot(*(path - path[chosen[-1]]).T))
    return path[sorted(chosen)]


def _per_axis(value: Any) -> Pair:
    x, y = np.broadcast_to(np.asarray(value, dtype=float), 2).tolist()
    return x, y


def _alike(values: Pair, unit: str) -> str:
    one, two = values
    return f"{one:g} {unit}" if one == two else f"{one:g} and {two:g} {unit}"
