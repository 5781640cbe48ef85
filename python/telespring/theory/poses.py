"""Stability of a dyad in jointed arms, pose by pose: such arms couple the axes, and change as they move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from telespring import _core
from telespring._arrays import as_numbers
from telespring._errors import InvalidInput
from telespring._types import Delay, FloatArray

if TYPE_CHECKING:
    from telespring.model import DelaySystem, Dyad

__all__ = ["SIGNIFICANT_CROSS_INERTIA", "PoseStability", "cross_inertia", "pose_stability", "pose_system"]

# A cross-axis inertia shifts the two principal masses by its square: at 5 % that is 0.25 % of a mass, less
# than any identification resolves.
SIGNIFICANT_CROSS_INERTIA = 0.05

Arm = Mapping[str, Any]
MASSLESS: Arm = {"kind": "massless"}


@dataclass(frozen=True, eq=False)
class PoseStability:
    """What a dyad's stability is in each pose of its arms.

    Attributes
    ----------
    position : ndarray, (pose, 2)
        Where both handles are, m.
    spectral_abscissa : ndarray, (pose,)
        The largest real part of the characteristic roots but s = 0 in each pose, 1/s.
    uncoupled_abscissa : ndarray, (pose,)
        The same with all that couples x and y left out: what treating the axes as independent would say.
    cross_inertia : ndarray, (pose, 2)
        For each robot, robot and arm together: |m_xy| over the geometric mean of m_xx and m_yy.
    complete : bool
        Whether the argument principle confirms for every pose that no root was missed.
    """

    position: FloatArray
    spectral_abscissa: FloatArray
    uncoupled_abscissa: FloatArray
    cross_inertia: FloatArray
    complete: bool

    @property
    def worst(self) -> int:
        """Index of the pose with the largest spectral abscissa."""
        return int(np.argmax(self.spectral_abscissa))

    @property
    def worst_abscissa(self) -> float:
        """The largest spectral abscissa, 1/s: below zero every frozen pose is stable."""
        return float(self.spectral_abscissa[self.worst])

    @property
    def worst_position(self) -> FloatArray:
        """Where both handles are in that pose, m."""
        place: FloatArray = self.position[self.worst]
        return place

    @property
    def axes_are_independent(self) -> bool:
        """Whether the cross-axis inertia is below 5 % in every pose and on both sides."""
        return bool((self.cross_inertia < SIGNIFICANT_CROSS_INERTIA).all())


def pose_stability(
    dyad: Dyad,
    arms: tuple[Arm | None, Arm | None],
    stiffness: float,
    delay: Delay,
    positions: ArrayLike,
    agent_stiffness: tuple[float, float] = (0.0, 0.0),
) -> PoseStability:
    """Find the pose along a path in which the coupled robots with their arms are least stable.

    Both handles are at the same position, where the agents' springs are at rest; torques are J(θ)ᵀ F, so
    that an agent's stiffness at the handle is the same in every pose. Each pose is frozen: what the
    motion from pose to pose adds is not in it, and the whole trial in the virtual laboratory shows that.

    Parameters
    ----------
    dyad : Dyad
        The robots, of two axes, with further operators and a coupling damper where it has any.
    arms : (mapping or None, mapping or None)
        The arm in each robot's handle, as a study file writes it: `kind` "massless", "lumped" (`mass`,
        `damping`) or "two-link" (`base`, `link_length`, ...); None is the massless arm.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    positions : array_like, (pose, 2)
        Positions of the handles, m, such as one period of the target.
    agent_stiffness : (float, float)
        Stiffness of each agent's spring to the target, N/m, on both axes.

    Returns
    -------
    PoseStability
        Every pose, the worst, and whether the axes may be treated as independent.

    Raises
    ------
    InvalidInput
        Where a value is out of its range, or a position out of the reach of an arm.

    Examples
    --------
    >>> import numpy as np, telespring as ts
    >>> from telespring.theory.poses import pose_stability
    >>> arm = {"kind": "two-link", "base": [0.0, -0.45], "elbow": "right", "link_length": 0.325,
    ...        "link_mass": [0.88, 0.40], "link_centre": [0.25, 0.16], "link_inertia": [0.010, 0.004]}
    >>> angle = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    >>> path = np.column_stack([0.05 * np.sin(2 * angle), 0.1 * np.sin(angle)])
    >>> found = pose_stability(ts.hman(), (arm, arm), 71.2, 0.15, path)
    >>> found.worst_abscissa > 0, found.axes_are_independent, found.complete
    (True, False, True)
    """
    places = _places(positions)
    sides = [_side(dyad, robot, arms[robot], agent_stiffness[robot], places) for robot in range(2)]
    abscissa, uncoupled = np.empty(len(places)), np.empty(len(places))
    complete = True
    for pose in range(len(places)):
        frozen = [_Frozen(mass[pose], damping[pose], ground) for mass, damping, ground in sides]
        for out, pair in ((abscissa, frozen), (uncoupled, [side.diagonal() for side in frozen])):
            system = _system(pair[0], pair[1], stiffness, dyad.coupling_damping, delay)
            roots = system.certified_roots(system.roots_at_zero + 1)
            out[pose] = roots.roots[roots.roots != 0][0].real
            complete &= roots.complete
    return PoseStability(places, abscissa, uncoupled, _cross([mass for mass, _, _ in sides]), complete)


def cross_inertia(dyad: Dyad, arms: tuple[Arm | None, Arm | None], positions: ArrayLike) -> FloatArray:
    """Find how strongly the arms' inertia couples x and y in each pose.

    Parameters
    ----------
    dyad : Dyad
        As `pose_stability` has it, and so are the other parameters.
    arms : (mapping or None, mapping or None)
        The arm in each robot's handle.
    positions : array_like, (pose, 2)
        Positions of the handles, m.

    Returns
    -------
    ndarray, (pose, 2)
        For each robot, robot and arm together: |m_xy| over the geometric mean of m_xx and m_yy.

    Raises
    ------
    InvalidInput
        As `pose_stability` does.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.theory.poses import cross_inertia
    >>> cross_inertia(ts.hman(), (None, {"kind": "lumped", "mass": 0.5}), [[0.0, 0.1]])
    array([[0., 0.]])
    """
    places = _places(positions)
    return _cross([_side(dyad, robot, arms[robot], 0.0, places)[0] for robot in range(2)])


def _cross(masses: list[FloatArray]) -> FloatArray:
    return np.column_stack(
        [np.abs(mass[:, 0, 1]) / np.sqrt(mass[:, 0, 0] * mass[:, 1, 1]) for mass in masses]
    )


def pose_system(
    dyad: Dyad,
    arms: tuple[Arm | None, Arm | None],
    stiffness: float,
    delay: Delay,
    position: ArrayLike,
    agent_stiffness: tuple[float, float] = (0.0, 0.0),
) -> DelaySystem:
    """Return one frozen pose as a linear system with delays.

    Parameters
    ----------
    dyad : Dyad
        As `pose_stability` has it, and so are the other parameters.
    arms : (mapping or None, mapping or None)
        The arm in each robot's handle.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    position : array_like, (2,)
        Position of both handles, m.
    agent_stiffness : (float, float)
        Stiffness of each agent's spring, N/m.

    Returns
    -------
    DelaySystem
        In the states x, y, x′, y′ of robot 1, counted from `position`, then those of robot 2.

    Raises
    ------
    InvalidInput
        As `pose_stability` does.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.theory.poses import pose_system
    >>> system = pose_system(ts.hman(), (None, None), 71.2, 0.16, [0.0, 0.0])
    >>> system.roots_at_zero  # free handles: both axes can be carried off
    2
    """
    places = _places(np.asarray(position)[np.newaxis])
    frozen = []
    for robot in range(2):
        mass, damping, ground = _side(dyad, robot, arms[robot], agent_stiffness[robot], places)
        frozen.append(_Frozen(mass[0], damping[0], ground))
    return _system(frozen[0], frozen[1], stiffness, dyad.coupling_damping, delay)


@dataclass(frozen=True)
class _Frozen:
    """One side in one pose: robot, operator, arm and agent together, over x and y."""

    mass: FloatArray
    damping: FloatArray
    ground: FloatArray

    def diagonal(self) -> _Frozen:
        return _Frozen(np.diag(np.diag(self.mass)), np.diag(np.diag(self.damping)), self.ground)


def _places(positions: ArrayLike) -> FloatArray:
    places = as_numbers("positions", positions)
    if places.ndim != 2 or places.shape[1] != 2 or not len(places):
        raise InvalidInput(
            "positions",
            f"an array of shape {places.shape}",
            "one row of two numbers, x and y, for every pose is needed",
            "Give an array of shape (n, 2), n at least 1.",
        )
    return places


def _side(
    dyad: Dyad, robot: int, arm: Arm | None, agent_stiffness: float, places: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass and damping of one side in every pose, and the stiffness that ties it to the ground."""
    if len(dyad.axes) != 2:
        raise InvalidInput(
            f"robot{robot + 1}",
            f"axes {dyad.axes}",
            "an arm holds a robot of two axes, x and y",
            "Give both robots two masses and two dampings.",
        )
    if not 0.0 <= agent_stiffness <= 1e7:
        raise InvalidInput(
            f"agent_stiffness[{robot}]",
            str(agent_stiffness),
            "an agent's stiffness must be a number from 0 to 1e7 N/m",
            "Check the sign and the unit: N/m is expected.",
        )
    try:
        mass, damping = _core.arm_operator(dict(arm or MASSLESS), places)
    except InvalidInput as refused:
        raise refused.at(refused.field.replace("arm", f"arm{robot + 1}", 1)) from None
    body, operator = dyad.robots[robot], dyad.operators[robot]
    both = np.ones(2)
    return (
        mass + np.diag(body.mass + operator.mass * both),
        damping + np.diag(body.damping + operator.damping * both),
        np.diag(operator.stiffness * both + agent_stiffness),
    )


def _system(first: _Frozen, second: _Frozen, stiffness: float, damper: float, delay: Delay) -> DelaySystem:
    k, c = _core.Coupling(stiffness).stiffness, damper
    forward, backward = _core.Network(delay).delay
    now, to_first, to_second = np.zeros((8, 8)), np.zeros((8, 8)), np.zeros((8, 8))
    one = np.eye(2)
    for start, side in ((0, first), (4, second)):
        place, speed = slice(start, start + 2), slice(start + 2, start + 4)
        now[place, speed] = one
        now[speed, place] = -np.linalg.solve(side.mass, side.ground + k * one)
        now[speed, speed] = -np.linalg.solve(side.mass, side.damping + c * one)
    pull = np.hstack([k * one, c * one])
    to_first[2:4, 4:8] = np.linalg.solve(first.mass, pull)
    to_second[6:8, 0:4] = np.linalg.solve(second.mass, pull)
    return _core.DelaySystem(now, [(backward, to_first), (forward, to_second)])
