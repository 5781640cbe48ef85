"""Whether a study's conditions are stable in its own arms, held by its own agents.

Arms that are alike in every pose are operators, and the exact criteria answer per axis. Two-link arms
couple x and y, differently in every pose: the answer is then the worst over the poses along the target.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.decision.handles import Holding, holding_of, places_of, unknown_agents
from telespring.model import Study
from telespring.theory import spectrum
from telespring.theory.axis import axes_of
from telespring.theory.poses import SIGNIFICANT_CROSS_INERTIA, cross_inertia, pose_stability

__all__ = ["ConditionInArms", "InArms", "Poses", "names_arms_or_agents", "stability_in_arms"]


@dataclass(frozen=True)
class ConditionInArms:
    """One stiffness and delay in arms.

    Attributes
    ----------
    stiffness
        Of the virtual spring, N/m.
    delay
        One-way delay, forward and backward, s.
    unstable_axes
        Names of the axes on which it is unstable; None where the arms couple the axes.
    spectral_abscissa
        Largest real part of the characteristic roots but s = 0, 1/s, the worst over axes and poses.
    least_abscissa
        The same in the best pose.
    independent_abscissa
        The worst over the poses with all that couples x and y left out.
    unstable_poses
        In how many poses it is unstable; None where the pose does not matter.
    worst_position
        Where both handles are in the worst pose, m; None where the pose does not matter.
    stable
        Whether it is stable on every axis and in every pose.
    complete
        Whether it is certain that no characteristic root was missed.
    """

    stiffness: float
    delay: tuple[float, float]
    unstable_axes: tuple[str, ...] | None
    spectral_abscissa: float
    least_abscissa: float
    independent_abscissa: float
    unstable_poses: int | None
    worst_position: tuple[float, float] | None
    stable: bool
    complete: bool

    def verdict(self) -> str:
        """Say it in a few words, as for a column of a table."""
        if self.worst_position is None:
            axes = " and ".join(self.unstable_axes or ())
            return "stable" if self.stable else f"unstable on {axes}"
        word = "stable" if self.stable else "unstable"
        return f"{word}, worst at {_place(self.worst_position)}"

    def pace(self) -> str:
        """Say how fast the slowest motion dies away or the worst one grows."""
        rate = self.spectral_abscissa
        if rate == 0.0:
            return "swinging on without end"
        return f"{'growing' if rate > 0.0 else 'decaying'} by the factor e every {_time(1.0 / abs(rate))}"


@dataclass(frozen=True, eq=False)
class Poses:
    """Where arms that depend on the pose were looked at.

    Attributes
    ----------
    places
        Positions of both handles, m, shape (pose, 2).
    along
        What they are from, such as "one period of the target".
    cross_inertia
        For each pose and robot, arm included: |m_xy| over the geometric mean of m_xx and m_yy.
    """

    places: FloatArray
    along: str
    cross_inertia: FloatArray

    @property
    def axes_are_independent(self) -> bool:
        """Whether the cross-axis inertia is below 5 % in every pose and on both sides."""
        return bool((self.cross_inertia < SIGNIFICANT_CROSS_INERTIA).all())

    def in_words(self) -> str:
        """Say where they are, and whether the axes are independent there."""
        one, two = (f"{100.0 * each:.2g} %" for each in self.cross_inertia.max(axis=0))
        how = "nearly" if self.axes_are_independent else "not"
        return (
            f"Worst of {len(self.places)} poses along {self.along}; x and y are {how} independent, the "
            f"cross-axis inertia is up to "
            f"{one} (robot 1) and {two} (robot 2) of the diagonal"
        )


@dataclass(frozen=True, eq=False)
class InArms:
    """Stability of some conditions in a study's own arms.

    Attributes
    ----------
    unknown
        Why it is not known, or None where it is.
    holding
        What holds the handles; None where that is not known.
    poses
        Where they were looked at; None where the pose does not matter.
    conditions
        The answers, in the order asked; none where it is not known.
    """

    unknown: str | None
    holding: Holding | None = None
    poses: Poses | None = None
    conditions: tuple[ConditionInArms, ...] = ()

    def in_words(self) -> str:
        """Say what the answers hold for, or why there are none."""
        if self.holding is None:
            return f"not known, {self.unknown}."
        words = f"{self.holding.in_words()}; continuous controllers, constant delay."
        return words if self.poses is None else f"{words} {self.poses.in_words()}."

    def to_json(self) -> dict[str, Any]:
        """Give the one condition that `telespring decide` asks about, in SI units."""
        found: dict[str, Any] = {"known": self.unknown is None, "reason": self.unknown}
        if self.holding is None:
            return found
        (one,) = self.conditions
        poses = self.poses
        return {
            **found,
            "agent_stiffness": list(self.holding.agent_stiffness),
            "agent_damping": list(self.holding.agent_damping),
            "arm_mass": [list(each) for each in self.holding.arm_mass],
            "arm_damping": [list(each) for each in self.holding.arm_damping],
            "depends_on_pose": poses is not None,
            "stable": one.stable,
            "unstable_axes": None if one.unstable_axes is None else list(one.unstable_axes),
            "spectral_abscissa": one.spectral_abscissa,
            "independent_abscissa": one.independent_abscissa,
            "poses": None if poses is None else len(poses.places),
            "unstable_poses": one.unstable_poses,
            "worst_position": None if one.worst_position is None else list(one.worst_position),
            "axes_independent": poses is None or poses.axes_are_independent,
            "cross_inertia": [0.0, 0.0] if poses is None else poses.cross_inertia.max(axis=0).tolist(),
            "complete": one.complete,
        }


def stability_in_arms(
    study: Study,
    conditions: Sequence[tuple[float, float | tuple[float, float]]],
    modules: Path | None = None,
) -> InArms:
    """Judge conditions with the handles held by the study's own arms and agents.

    Controllers are continuous and the delay is constant; Coulomb friction and limits of torque are left
    out. Poses are frozen: both handles are on the target, and what moving from pose to pose adds is not
    counted.

    Parameters
    ----------
    study
        A study with robots of two axes.
    conditions
        Stiffness (N/m) and one-way delay (s), or the pair (forward, backward).
    modules
        Where a target in Python is looked up first: the folder of the study's file.

    Returns
    -------
    InArms
        An answer for every condition, or why there is none.

    Raises
    ------
    telespring.InvalidInput
        Where a stiffness or delay is out of its range, or the robots have not two axes.

    Examples
    --------
    >>> import telespring as ts
    >>> found = stability_in_arms(ts.Study.paper(), [(71.2, 0.084), (142.0, 0.084)])
    >>> [each.verdict() for each in found.conditions]
    ['stable', 'unstable on x']
    """
    experiment = study.experiment
    if experiment is None:
        raise InvalidInput(
            "robot1.axes",
            ", ".join(study.dyad.axes),
            "arms hold robots with exactly two axes",
            "Describe both robots with the axes x and y.",
        )
    if (unknown := unknown_agents(experiment)) is not None:
        return InArms(unknown)
    asked = [(float(k), _both(delay)) for k, delay in conditions]
    holding = holding_of(study, experiment)
    if not holding.depends_on_pose:
        return InArms(None, holding, None, tuple(_on_axes(holding, *each) for each in asked))
    try:
        places, along = places_of(experiment, modules)
    except InvalidInput as refused:
        return InArms(f"the target {refused.value} cannot be followed: {refused.allowed}")
    try:
        cross = cross_inertia(holding.held, holding.jointed, places)
    except InvalidInput as refused:
        if not refused.field.startswith("positions"):
            raise
        return InArms("the target leaves the reach of an arm")
    poses = Poses(places, along, cross)
    return InArms(None, holding, poses, tuple(_in_poses(holding, poses, *each) for each in asked))


def names_arms_or_agents(study_file: Path) -> bool:
    """Tell whether a study file says itself what holds the handles in the rehearsal.

    Parameters
    ----------
    study_file
        A file that `telespring.Study.read` accepts.

    Returns
    -------
    bool
        True where it has one of the sections `[arm1]`, `[arm2]`, `[agent1]` and `[agent2]`.
    """
    return Study.read(study_file).names_arms_or_agents


def _on_axes(holding: Holding, stiffness: float, delay: tuple[float, float]) -> ConditionInArms:
    axes = axes_of(holding.held)
    abscissae = [
        float(spectrum.spectral_abscissa(holding.held, stiffness, delay, axis=axis.index)) for axis in axes
    ]
    unstable = tuple(axis.name for axis in axes if not axis.is_stable(stiffness, 0.5 * sum(delay)))
    worst = max(abscissae)
    return ConditionInArms(
        stiffness=stiffness,
        delay=delay,
        unstable_axes=unstable,
        spectral_abscissa=worst,
        least_abscissa=worst,
        independent_abscissa=worst,
        unstable_poses=None,
        worst_position=None,
        stable=not unstable,
        complete=True,
    )


def _in_poses(
    holding: Holding, poses: Poses, stiffness: float, delay: tuple[float, float]
) -> ConditionInArms:
    found = pose_stability(holding.held, holding.jointed, stiffness, delay, poses.places)
    x, y = found.worst_position.tolist()
    unstable = int(np.count_nonzero(found.spectral_abscissa >= 0.0))
    return ConditionInArms(
        stiffness=stiffness,
        delay=delay,
        unstable_axes=None,
        spectral_abscissa=found.worst_abscissa,
        least_abscissa=float(found.spectral_abscissa.min()),
        independent_abscissa=float(found.uncoupled_abscissa.max()),
        unstable_poses=unstable,
        worst_position=(x, y),
        stable=unstable == 0,
        complete=found.complete,
    )


def _both(delay: float | tuple[float, float]) -> tuple[float, float]:
    forward, backward = np.broadcast_to(delay, 2).tolist()
    return forward, backward


def _place(position: tuple[float, float]) -> str:
    x, y = (f"{1e3 * each + 0.0:.0f}" for each in position)
    return f"({x}, {y}) mm".replace("-0,", "0,").replace("-0)", "0)")


def _time(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"
