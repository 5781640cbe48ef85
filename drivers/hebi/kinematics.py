"""Where the handle is, and which joint efforts make a force on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

Pair = tuple[float, float]
Matrix = tuple[Pair, Pair]  # rows: x, y; columns: joints


class Chain(Protocol):
    """Two joints that move a handle in a plane."""

    def position(self, angles: Pair) -> Pair:
        """Return the place of the handle, m; an angle is in rad, or in m for a linear joint."""

    def jacobian(self, angles: Pair) -> Matrix:
        """Return the change of the place per change of the joints, m/rad (1 for a linear joint in m)."""


@dataclass(frozen=True)
class TwoLink:
    """Two links in a plane, stretched along x at zero angles; the second angle counts from the first link."""

    lengths: Pair  # m

    def position(self, angles: Pair) -> Pair:
        """Return the place of the handle, m, from the first joint."""
        (first, second), (one, both) = self.lengths, (angles[0], angles[0] + angles[1])
        return (
            first * math.cos(one) + second * math.cos(both),
            first * math.sin(one) + second * math.sin(both),
        )

    def jacobian(self, angles: Pair) -> Matrix:
        """Return the change of the place per radian, m."""
        second, both = self.lengths[1], angles[0] + angles[1]
        x, y = self.position(angles)
        return ((-y, -second * math.sin(both)), (x, second * math.cos(both)))


@dataclass(frozen=True)
class Axes:
    """Two axes at right angles, each with a drive of its own: linear, or rotary with a belt or a rack."""

    scale: Pair  # m per rad of a rotary drive: the radius; 1 for a linear one

    def position(self, angles: Pair) -> Pair:
        """Return the place of the handle, m, from the zeros of the drives."""
        return (self.scale[0] * angles[0], self.scale[1] * angles[1])

    def jacobian(self, angles: Pair) -> Matrix:  # noqa: ARG002 (the same everywhere)
        """Return the change of the place per change of the drives."""
        return ((self.scale[0], 0.0), (0.0, self.scale[1]))


@dataclass(frozen=True)
class Arm:
    """A chain with its joints as they are built in, at its place in the axes of the study."""

    chain: Chain
    zero: Pair = (0.0, 0.0)  # what the joints report where the chain's angles are zero, rad or m
    direction: Pair = (1.0, 1.0)  # 1, or -1 for a joint that counts the other way round
    base: Pair = (0.0, 0.0)  # the chain's origin in the axes of the study, m
    turn: float = 0.0  # from the study's x to the chain's, anticlockwise, rad

    def _angles(self, joints: Sequence[float]) -> Pair:
        return (
            self.direction[0] * (joints[0] - self.zero[0]),
            self.direction[1] * (joints[1] - self.zero[1]),
        )

    def _turned(self, vector: Pair) -> Pair:
        cosine, sine = math.cos(self.turn), math.sin(self.turn)
        return (cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1])

    def position(self, joints: Sequence[float]) -> Pair:
        """Return the place of the handle in the axes of the study, m."""
        x, y = self._turned(self.chain.position(self._angles(joints)))
        return (self.base[0] + x, self.base[1] + y)

    def jacobian(self, joints: Sequence[float]) -> Matrix:
        """Return the change of the place in the axes of the study per change of what the joints report."""
        (a, b), (c, d) = self.chain.jacobian(self._angles(joints))
        first, second = self._turned((a, c)), self._turned((b, d))
        return (
            (first[0] * self.direction[0], second[0] * self.direction[1]),
            (first[1] * self.direction[0], second[1] * self.direction[1]),
        )


def velocity(jacobian: Matrix, rates: Sequence[float]) -> Pair:
    """Return the velocity of the handle, m/s: J times the rates of the joints."""
    (a, b), (c, d) = jacobian
    return (a * rates[0] + b * rates[1], c * rates[0] + d * rates[1])


def efforts(jacobian: Matrix, force: Pair) -> Pair:
    """Return the efforts of the joints that make a force on the handle: J transposed times the force."""
    (a, b), (c, d) = jacobian
    return (a * force[0] + c * force[1], b * force[0] + d * force[1])


def force(jacobian: Matrix, joint_efforts: Sequence[float]) -> Pair | None:
    """Return the force on the handle, N, that joint efforts make at rest; None where the arm is singular."""
    if is_singular(jacobian):
        return None
    (a, b), (c, d) = jacobian
    determinant = a * d - b * c
    one, two = joint_efforts[0], joint_efforts[1]
    return ((d * one - c * two) / determinant, (a * two - b * one) / determinant)


def is_singular(jacobian: Matrix) -> bool:
    """Return whether the joints move the handle 100 times less in one direction than in another, or worse."""
    (a, b), (c, d) = jacobian
    # with s and S the singular values: det = s S, and the sum of the squares is s² + S²
    return not abs(a * d - b * c) > 0.01 * (a * a + b * b + c * c + d * d)
