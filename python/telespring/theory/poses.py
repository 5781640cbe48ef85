"""Stability of a dyad in jointed arms, pose by pose: such arms couple the axes, and change as they move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import telespring._core as core
from telespring._arrays import as_numbers, unmasked
from telespring._errors import InvalidInput
from telespring._types import Delay, FloatArray
from telespring.model import Arm, DelaySystem, Dyad

__all__ = ["SIGNIFICANT_CROSS_INERTIA", "PoseStability", "cross_inertia", "pose_stability", "pose_system"]

# A cross-axis inertia shifts the two principal masses by its square: at 5 % that is 0.25 % of a mass, less
# than any identification resolves.
SIGNIFICANT_CROSS_INERTIA = 0.05

ArmKeys = Arm | Mapping[str, Any] | None


@dataclass(frozen=True, eq=False)
class PoseStability:
    """Stability of a dyad in each pose of its arms.

    Attributes
    ----------
    position : ndarray, (pose, 2)
        Position of both handles, m.
    spectral_abscissa : ndarray, (pose,)
        The largest real part of the characteristic roots other than s = 0 in each pose, 1/s.
    uncoupled_abscissa : ndarray, (pose,)
        The same without the terms that couple x and y: the result if the axes were independent.
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
        """Position of both handles in that pose, m."""
        place: FloatArray = self.position[self.worst]
        return place

    @property
    def axes_are_independent(self) -> bool:
        """Whether the cross-axis inertia is below 5 % in every pose and on both sides."""
        return bool((self.cross_inertia < SIGNIFICANT_CROSS_INERTIA).all())


def pose_stability(
    dyad: Dyad,
    arms: tuple[ArmKeys, ArmKeys],
    stiffness: float,
    delay: Delay,
    positions: ArrayLike,
    agent_stiffness: tuple[float, float] = (0.0, 0.0),
) -> PoseStability:
    """Compute the stability of the coupled robots with their arms in each pose along a path.

    Both handles are at the same position, where the agents' springs are at rest; torques are J(θ)ᵀ F, so
    that an agent's stiffness at the handle is the same in every pose. Each pose is frozen: the effect of
    moving from pose to pose is not included; a trial in the virtual laboratory shows it.

    Parameters
    ----------
    dyad : Dyad
        The robots, with two axes, and with operators and a coupling damper if it has any.
    arms : (Arm, mapping or None, Arm, mapping or None)
        The arm in each robot's handle: an `Arm`, or its keys as in a study file (`kind` "massless",
        "lumped" with `mass` and `damping`, or "two-link" with `base`, `link_length`, ...); None is the
        massless arm.
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
        If a value is out of its range, or a position out of the reach of an arm.

    Examples
    --------
    >>> import numpy as np, telespring as ts
    >>> from telespring.theory.poses import pose_stability
    >>> arm = {"kind": "two-link", "base": [0.0, -0.45], "elbow": "right", "link_length": 0.325,
    ...        "link_mass": [0.88, 0.40], "link_centre": [0.25, 0.16], "link_inertia": [0.010, 0.004]}
    >>> angle = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    >>> path = np.column_stack([0.05 * np.sin(2 * angle), 0.1 * np.sin(angle)])
    >>> poses = pose_stability(ts.hman(), (arm, arm), 71.2, 0.15, path)
    >>> poses.worst_abscissa > 0, poses.axes_are_independent, poses.complete
    (True, False, True)
    """
    places = _pose_positions(positions)
    abscissa, uncoupled, complete = core.pose_stability(dyad, arms, stiffness, delay, places, agent_stiffness)
    return PoseStability(places, abscissa, uncoupled, core.cross_inertia(dyad, arms, places), complete)


def cross_inertia(dyad: Dyad, arms: tuple[ArmKeys, ArmKeys], positions: ArrayLike) -> FloatArray:
    """Compute how strongly the arms' inertia couples x and y in each pose.

    Parameters
    ----------
    dyad, arms, positions
        As in `pose_stability`.

    Returns
    -------
    ndarray, (pose, 2)
        For each robot, robot and arm together: |m_xy| over the geometric mean of m_xx and m_yy.

    Raises
    ------
    InvalidInput
        As in `pose_stability`.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.theory.poses import cross_inertia
    >>> cross_inertia(ts.hman(), (None, {"kind": "lumped", "mass": 0.5}), [[0.0, 0.1]])
    array([[0., 0.]])
    """
    return core.cross_inertia(dyad, arms, _pose_positions(positions))


def pose_system(
    dyad: Dyad,
    arms: tuple[ArmKeys, ArmKeys],
    stiffness: float,
    delay: Delay,
    position: ArrayLike,
    agent_stiffness: tuple[float, float] = (0.0, 0.0),
) -> DelaySystem:
    """Return one frozen pose as a linear system with delays.

    Parameters
    ----------
    dyad, arms, stiffness, delay, agent_stiffness
        As in `pose_stability`.
    position : array_like, (2,)
        Position of both handles, m.

    Returns
    -------
    DelaySystem
        In the states x, y, x′, y′ of robot 1, counted from `position`, then those of robot 2.

    Raises
    ------
    InvalidInput
        As in `pose_stability`.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.theory.poses import pose_system
    >>> system = pose_system(ts.hman(), (None, None), 71.2, 0.16, [0.0, 0.0])
    >>> system.roots_at_zero  # free handles: both axes have a rigid-body mode
    2
    """
    (place,) = _pose_positions(np.asarray(unmasked(position))[np.newaxis])
    return core.pose_system(dyad, arms, stiffness, delay, place, agent_stiffness)


def _pose_positions(positions: ArrayLike) -> FloatArray:
    places = as_numbers("positions", positions)
    if places.ndim != 2 or places.shape[1] != 2 or not len(places):
        raise InvalidInput(
            "positions",
            f"an array of shape {places.shape}",
            "one row of two numbers, x and y, for every pose is required",
            "Give an array of shape (n, 2) with at least one row.",
        )
    return places
