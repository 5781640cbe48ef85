"""Transfer functions of the dyad with both agents, on a grid of frequencies and for many settings at once.

Arrays are (case, axis, frequency): a case is one setting in one condition. The first frequency is the
target's harmonic on that axis, the others are nodes of an integral over the spectrum of the disturbance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import ComplexArray, FloatArray
from telespring.model import Study
from telespring.paper.calibration.setting import DelayPlacement, Setting

__all__ = ["Cases", "Dynamics", "Grid", "Loop", "Motion", "deviation_of"]

Cut = NDArray[np.intp]

#: Scale of the frequency for the count of unstable roots, rad/s. Any positive one gives the same count;
#: with this one the argument is within a right angle of its limit at the last node.
_TURNING = 15.0
#: A longer step of the argument between two nodes, rad, means a root nearer to the axis than the nodes are
#: to each other: neither the count nor the integral can be trusted on that grid.
_LONGEST_STEP = 1.0


@dataclass(frozen=True)
class Grid:
    """Gauss-Legendre nodes and weights over panels of frequency, rad/s, behind the target's harmonics."""

    s: ComplexArray
    frequency: FloatArray
    weights: FloatArray

    @classmethod
    def over(cls, ends: FloatArray, nodes: int, harmonic: FloatArray) -> Grid:
        """Return the grid with this many nodes in each of the panels between the ends."""
        place, weight = np.polynomial.legendre.leggauss(nodes)
        half = np.diff(ends)[:, None] / 2.0
        frequency = (ends[:-1, None] + half * (place + 1.0)).ravel()
        s = 1j * np.column_stack([harmonic, np.tile(frequency, (len(harmonic), 1))])
        return cls(np.asarray(s, dtype=np.complex128), frequency, (half * weight).ravel())


@dataclass(frozen=True)
class Cases:
    """Settings in conditions, every number (case, 1, 1), offsets (case, robot, axis)."""

    connected: NDArray[np.bool_]
    stiffness: FloatArray
    delay: FloatArray
    agent_stiffness: FloatArray
    spot_lifetime: FloatArray
    arm_mass: FloatArray
    arm_damping: FloatArray
    coulomb: FloatArray
    coupling_lag: FloatArray
    dead_band: FloatArray
    force_limit: FloatArray
    delay_factor: FloatArray
    command_lag: FloatArray
    target_offset: FloatArray
    delay_placement: DelayPlacement

    @classmethod
    def of(cls, settings: Sequence[Setting], conditions: Sequence[tuple[float | None, float]]) -> Cases:
        """Return every setting in every condition; the settings must agree in the placement of the delay."""
        count = len(conditions)

        def spread(name: str) -> FloatArray:
            values = np.array([getattr(setting, name) for setting in settings], dtype=float)
            return np.repeat(values, count)[:, None, None]

        def tile(values: list[float]) -> FloatArray:
            return np.tile(np.array(values, dtype=float), len(settings))[:, None, None]

        offsets = [(setting.target_offset_1, setting.target_offset_2) for setting in settings]
        (placement,) = {setting.delay_placement for setting in settings}
        numbers = {each.name for each in fields(cls)} & {each.name for each in fields(Setting)}
        return cls(
            connected=tile([stiffness is not None for stiffness, _ in conditions]) > 0.0,
            stiffness=tile([stiffness or 0.0 for stiffness, _ in conditions]),
            delay=tile([delay for _, delay in conditions]),
            target_offset=np.repeat(np.array(offsets, dtype=float), count, axis=0),
            delay_placement=placement,
            **{name: spread(name) for name in numbers - {"delay_placement"}},
        )

    def cut(self, cases: Cut) -> Cases:
        """Return some of the cases."""
        arrays: dict[str, Any] = {
            each.name: getattr(self, each.name)[cases]
            for each in fields(self)
            if each.name != "delay_placement"
        }
        return replace(self, **arrays)


@dataclass(frozen=True)
class Motion:
    """Responses of both handles to the target and to the noise of agent 2, and whether they are stable.

    `stable` is whether no characteristic root lies in the right half-plane, `sharp` whether one is so close
    to the imaginary axis that a finer grid must say so.
    """

    to_target: tuple[ComplexArray, ComplexArray]
    to_noise: tuple[ComplexArray, ComplexArray]
    stable: NDArray[np.bool_]
    sharp: NDArray[np.bool_]


@dataclass(frozen=True)
class Loop:
    """Parts of the characteristic equation, by robot.

    `plant` is the robot with its arm and agent, `pull` the agent's force per displacement of its target,
    `law` the coupling force per distance. `late` is the lateness of the partner's position at robot 1 and 2
    and of the own one. `mass` is the product of the moving masses, `spectrum` (case, node) that of the
    noise times the weights.
    """

    s: ComplexArray
    plant: tuple[ComplexArray, ComplexArray]
    pull: tuple[ComplexArray, ComplexArray]
    law: ComplexArray
    late: tuple[ComplexArray, ComplexArray, ComplexArray]
    mass: FloatArray
    spectrum: FloatArray

    def cut(self, cases: Cut) -> Loop:
        """Return some of the cases."""
        return Loop(
            s=self.s,
            plant=(self.plant[0][cases], self.plant[1][cases]),
            pull=(self.pull[0][cases], self.pull[1][cases]),
            law=self.law[cases],
            late=(self.late[0][cases], self.late[1][cases], self.late[2][cases]),
            mass=self.mass[cases],
            spectrum=self.spectrum[cases],
        )

    def move(self, gains: FloatArray | None = None) -> Motion:
        """Solve for the steady state.

        `gains` are equivalent gains (case, axis, robot, spring or friction, harmonic or noise); without
        them the spring is as it is and there is no friction.
        """
        if gains is None:
            diagonal = [plant + self.law * self.late[2] for plant in self.plant]
            across = [self.law * self.late[i] for i in (0, 1)]
        else:
            kinds = np.minimum(np.arange(self.s.shape[1]), 1)
            spring, friction = (gains[:, :, :, kind, kinds] for kind in (0, 1))
            laws = [spring[:, :, i] * self.law for i in (0, 1)]
            diagonal = [self.plant[i] + laws[i] * self.late[2] + friction[:, :, i] * self.s for i in (0, 1)]
            across = [laws[i] * self.late[i] for i in (0, 1)]
        determinant = diagonal[0] * diagonal[1] - across[0] * across[1]
        pull = [each[..., :1] for each in self.pull]
        first = [each[..., :1] for each in (*diagonal, *across)]
        noise = self.pull[1][..., 1:] / determinant[..., 1:]
        stable, sharp = self._count_unstable_roots(determinant)
        return Motion(
            to_target=(
                (first[1] * pull[0] + first[2] * pull[1]) / determinant[..., :1],
                (first[0] * pull[1] + first[3] * pull[0]) / determinant[..., :1],
            ),
            to_noise=(across[0][..., 1:] * noise, diagonal[0][..., 1:] * noise),
            stable=stable,
            sharp=sharp,
        )

    def distances(self, motion: Motion, i: int) -> tuple[ComplexArray, ComplexArray]:
        """Return the partner's position in use at robot i less its own: harmonic and noise."""
        partner, own = self.late[i], self.late[2]
        return (
            partner[..., 0] * motion.to_target[1 - i][..., 0] - own[..., 0] * motion.to_target[i][..., 0],
            partner[..., 1:] * motion.to_noise[1 - i] - own[..., 1:] * motion.to_noise[i],
        )

    def _count_unstable_roots(self, determinant: ComplexArray) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether no characteristic root lies in the right half-plane, and if the nodes are too far apart.

        The characteristic function, of degree 4, over its leading coefficient and (s + a)⁴ tends to 1.
        Along the positive imaginary axis its argument falls by π for every root in the right half-plane.
        """
        # the factors one by one: a complex power takes ten times as long
        leading = np.square(np.square(self.s[:, 1:] + _TURNING))
        ratio = determinant[..., 1:] / (self.mass * leading)
        turns = np.angle(ratio[..., 1:] * ratio[..., :-1].conj())
        stable = np.all(np.abs(turns.sum(axis=-1)) < np.pi / 2, axis=-1)
        sharp = np.max(np.abs(turns), axis=(1, 2)) > _LONGEST_STEP
        return np.asarray(stable), np.asarray(sharp)


class Dynamics:
    """What a study's robots, agents and controllers contribute to the transfer functions."""

    def __init__(self, study: Study) -> None:
        experiment = study.experiment
        assert experiment is not None
        robots, agents = study.dyad.robots, experiment.agents
        assert agents[1].spots is not None
        assert agents[1].spot_velocity is not None
        self._mass = np.array([robot.mass for robot in robots])[..., None]  # (robot, axis, 1)
        self._damping = np.array([robot.damping for robot in robots])[..., None]
        self._agent_damping = agents[0].damping or 0.0
        self._noise_scale = agents[1].spot_velocity ** 2 / agents[1].spots
        # a force is held for a period, half a period on average, and may come a period late
        self._hold = experiment.sample_period * (1.5 if experiment.settings.computing_tick else 0.5)
        self._actuator_lag = experiment.settings.actuator_lag
        self._coupling_damping = experiment.coupling_damping

    def loop(self, cases: Cases, grid: Grid) -> Loop:
        """Return the parts of the characteristic equation of these cases."""
        s = grid.s
        hold = np.exp(-s * self._hold)
        command = hold / (1.0 + s * cases.command_lag)
        pull = (
            command * (cases.agent_stiffness + self._agent_damping * s),
            command * cases.agent_stiffness,
        )
        mass = [robot + cases.arm_mass for robot in self._mass]
        plant = [mass[i] * s * s + (self._damping[i] + cases.arm_damping) * s + pull[i] for i in (0, 1)]
        law = (cases.stiffness + cases.connected * self._coupling_damping * s) * hold
        late = np.exp(-s * (cases.delay_factor * cases.delay))
        now, placement = np.ones_like(late), cases.delay_placement
        return Loop(
            s=s,
            plant=(plant[0], plant[1]),
            pull=pull,
            law=law / ((1.0 + s * cases.coupling_lag) * (1.0 + s * self._actuator_lag)),
            late=(
                now if placement == "at robot 2" else late,
                now if placement == "at robot 1" else late,
                late if placement == "both" else now,
            ),
            mass=mass[0] * mass[1],
            spectrum=self._spectrum(cases.spot_lifetime[..., 0], grid),
        )

    def _spectrum(self, lifetime: FloatArray, grid: Grid) -> FloatArray:
        """Spectrum of the mean of all spots, with the weights of its integral over ω/π, m².

        A spot contributes ramps of random slope, each for its lifetime.
        """
        turn = 1j * grid.frequency * lifetime
        ramp = ((1.0 + turn) * np.exp(-turn) - 1.0) / grid.frequency**2
        density = self._noise_scale / lifetime * np.abs(ramp) ** 2 / np.pi
        return np.asarray(density * grid.weights)


def deviation_of(response: ComplexArray, spectrum: FloatArray) -> FloatArray:
    """Return the standard deviation (case, axis) of a response to the noise."""
    power = response.real**2 + response.imag**2
    return np.asarray(np.sqrt(np.einsum("caf,cf->ca", power, spectrum)))
