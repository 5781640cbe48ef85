"""Tracking errors of a dyad with both agents in the steady state, in closed form.

The target is one harmonic per axis, and the mean of the spots is Gaussian noise of known spectrum. A linear
dyad with a constant delay answers the first by one harmonic and the second by Gaussian noise, both through
the same transfer functions, in which the delay is exact. The mean distance from the target is then the mean
length of a Gaussian vector over one period. Friction, a dead band and a force limit enter by their
equivalent gains.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from telespring._types import ComplexArray, FloatArray
from telespring.model import Study
from telespring.paper.calibration.describing import friction_gains, saturation_gains
from telespring.paper.calibration.setting import Setting
from telespring.paper.calibration.transfer import Cases, Dynamics, Grid, Loop, Motion, deviation_of

__all__ = ["ClosedForm"]

#: Ends of the panels of the integral over the disturbance's spectrum, rad/s, and nodes in each. Above the
#: agents' resonance, at about 10 rad/s, the transfer function falls with the square of the frequency. The
#: finer grid is for conditions close to instability.
_PANELS = np.array([0.0, 3.0, 6.0, 9.0, 12.0, 20.0, 50.0])
_FINE_PANELS = np.concatenate([np.arange(0.0, 20.0, 0.5), np.arange(20.0, 51.0, 2.0)])
_PANEL_NODES = 8
#: Phases of half a period of the target, and nodes of the quadrature over the noise of each axis. With
#: these and the panels an error is within 0.02 mm near the published table, and within 0.2 mm where a
#: lifetime of 1 s doubles it.
_PHASES = 16
_NOISE_NODES = 10
#: Equivalent gains have settled when no step is longer. A step is this share of the way to the new value,
#: at first and later, when conditions close to instability remain; a spring lets a share of its gain go
#: while the dyad is unstable.
_SETTLED = 3e-5
_SHARES = (0.9, 0.3)
_FIRST_ROUNDS = 10
_YIELD = 0.1
_ROUNDS = 50


class ClosedForm:
    """The tracking errors of a study's robots, agents and task in some conditions, for any `Setting`.

    A sampled controller acts as a delay of half a period. Jitter, loss and the resolution of the encoders are
    left out.

    Parameters
    ----------
    study
        With two axes, the figure of eight, agent 1 skilled and agent 2 blurred.
    conditions
        Stiffness (N/m; None unconnected) and one-way delay (s).

    Examples
    --------
    >>> import telespring as ts
    >>> form = ClosedForm(ts.Study.paper(), [(None, 0.0), (36.0, 0.167)])
    >>> print((1e3 * form.errors(Setting(agent_stiffness=120.0, spot_lifetime=0.2))[0]).round(1))
    [[22.  24. ]
     [29.4 30.1]]
    """

    def __init__(self, study: Study, conditions: Sequence[tuple[float | None, float]]) -> None:
        experiment = study.experiment
        assert experiment is not None
        task = experiment.task
        assert task.amplitude is not None
        assert task.angular_frequency is not None
        self._conditions = tuple(conditions)
        self._dynamics = Dynamics(study)
        self._target: FloatArray = np.array(task.amplitude)
        harmonic = np.array([2.0, 1.0]) * task.angular_frequency
        self._harmonic = harmonic
        self._grid = Grid.over(_PANELS, _PANEL_NODES, harmonic)
        self._fine_grid = Grid.over(_FINE_PANELS, _PANEL_NODES, harmonic)
        phase = np.pi * (np.arange(2 * _PHASES) + 0.5) / _PHASES
        self._turn = np.exp(1j * np.outer([2.0, 1.0], phase))  # (axis, phase)
        self._normal, share = np.polynomial.hermite_e.hermegauss(_NOISE_NODES)
        self._normal_weights = np.outer(share, share).ravel() / share.sum() ** 2
        self._latest: tuple[Setting, FloatArray | None] | None = None  # a setting and its equivalent gains

    def errors(self, *settings: Setting) -> FloatArray:
        """Return the mean distance of both handles from the target, (setting, condition, robot), m.

        Infinite where the dyad is unstable, by its characteristic roots; with friction, a dead band or a
        force limit by those with the equivalent gains. The settings must agree in the placement of the delay.
        """
        return self._solve(settings)[0]

    def errors_near(self, setting: Setting, moved: Sequence[Setting]) -> FloatArray:
        """Return the same for settings that differ little from one, as `errors` does, (setting, ...), m.

        Their equivalent gains are sought from those of that setting, which takes a third of the time.
        """
        if all(each.is_linear for each in moved):
            return self._solve(moved)[0]
        if self._latest is None or self._latest[0] != setting:
            self._solve([setting])
        assert self._latest is not None
        gains = self._latest[1]
        return self._solve(moved, None if gains is None else np.concatenate([gains] * len(moved)))[0]

    def _solve(
        self, settings: Sequence[Setting], near: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray | None]:
        """Return the errors, and the equivalent gains unless all settings are linear."""
        cases = Cases.of(settings, self._conditions)
        loop = self._dynamics.loop(cases, self._grid)
        gains = None
        if not all(setting.is_linear for setting in settings):
            gains = self._settle(cases, loop, near)
        if len(settings) == 1:
            self._latest = (settings[0], gains)
        motion = loop.move(gains)
        stable = motion.stable.copy()
        mean = np.stack(motion.to_target, axis=1)[..., 0] * self._target - self._target
        deviation = _deviations(motion, loop)
        sharp = np.flatnonzero(motion.sharp)
        if len(sharp):
            finer = self._dynamics.loop(cases.cut(sharp), self._fine_grid)
            motion = finer.move(None if gains is None else gains[sharp])
            stable[sharp], deviation[sharp] = motion.stable, _deviations(motion, finer)
        errors = self._mean_distance(cases, mean, deviation)
        errors = np.where(stable[:, None], errors, np.inf)
        return errors.reshape(len(settings), len(self._conditions), 2), gains

    def _settle(self, cases: Cases, loop: Loop, near: FloatArray | None) -> FloatArray:
        """Find the equivalent gains that agree with the motion that they give, by damped substitution.

        Cases do not depend on each other: one whose gains have settled is left alone. The search begins at
        the gains `near`; without them where the handles would be on the target.
        """
        # (case, axis, robot, spring or friction, harmonic or noise)
        gains = np.zeros((len(cases.delay), 2, 2, 2, 2))
        gains[..., 0, :] = 1.0
        acts_on_spring = bool((cases.dead_band > 0.0).any() or np.isfinite(cases.force_limit).any())
        has_friction = bool((cases.coulomb > 0.0).any())
        if near is not None:
            gains = near.copy()
        elif has_friction:
            # as if both handles were on the target: of two possible motions the smaller one is found
            speed = np.broadcast_to(self._target * self._harmonic, gains.shape[:2])
            first = friction_gains(speed, np.zeros_like(speed), cases.coulomb[..., 0])
            gains[..., 1, :] = np.stack(first, axis=-1)[:, :, None]
        active = np.arange(len(cases.delay))
        for turn in range(_ROUNDS):
            share = _SHARES[turn >= _FIRST_ROUNDS]
            part, left = loop.cut(active), cases.cut(active)
            motion = part.move(gains[active])
            stable = motion.stable[:, None, None]
            away = np.zeros((len(active), 2, 2, 2, 2))
            for i in (0, 1):
                if acts_on_spring:
                    found, old = self._spring_gain(left, part, motion, i), gains[active, :, i, 0]
                    # a limit ends the growth of an unstable motion: less gain is the way to where it stops
                    away[:, :, i, 0] = np.where(stable, share * (found - old), -_YIELD * old)
                if has_friction:
                    found, old = self._friction_gain(left, part, motion, i), gains[active, :, i, 1]
                    away[:, :, i, 1] = np.where(stable, share * (found - old), 0.0)
            gains[active] += away
            active = active[np.max(np.abs(away), axis=(1, 2, 3, 4)) >= _SETTLED]
            if not len(active):
                break
        return gains

    def _spring_gain(self, cases: Cases, loop: Loop, motion: Motion, i: int) -> FloatArray:
        """Gains of robot i's spring, for the harmonic and the noise, by the distance of the handles."""
        harmonic, noise = loop.distances(motion, i)
        size, deviation = np.abs(harmonic) * self._target, deviation_of(noise, loop.spectrum)
        gain = np.ones((*size.shape, 2))
        band, limit = cases.dead_band[..., 0], cases.force_limit[..., 0]
        if (band > 0.0).any():
            # in units of the band, and of the limit below, which is another distance for every stiffness
            band = np.maximum(band, 1e-9)
            gain -= np.stack(saturation_gains(size / band, deviation / band), axis=-1)
        if np.isfinite(limit).any():
            limit = limit / np.maximum(cases.stiffness[..., 0], 1e-9)
            gain *= np.stack(saturation_gains(size / limit, deviation / limit), axis=-1)
        return gain

    def _friction_gain(self, cases: Cases, loop: Loop, motion: Motion, i: int) -> FloatArray:
        """Equivalent dampings of robot i's friction, for the harmonic and the noise, by its velocity."""
        speed = np.abs(motion.to_target[i][..., 0]) * self._target * self._harmonic
        deviation = deviation_of(motion.to_noise[i] * self._grid.frequency, loop.spectrum)
        return np.stack(friction_gains(speed, deviation, cases.coulomb[..., 0]), axis=-1)

    def _mean_distance(self, cases: Cases, phasor: ComplexArray, deviation: FloatArray) -> FloatArray:
        """Mean length over a period and the noise; phasors and deviations are (case, robot, axis)."""
        has_offset = bool(cases.target_offset.any())
        # without an offset the second half of a period mirrors the first
        turn = self._turn if has_offset else self._turn[:, :_PHASES]
        mean = np.imag(phasor[..., None] * turn)
        if has_offset:
            shared = cases.stiffness / (cases.agent_stiffness + 2.0 * cases.stiffness)
            offset = cases.target_offset
            mean = mean + (offset + shared * (offset[:, ::-1] - offset))[..., None]
        noise = deviation[..., None] * self._normal
        along = np.square(mean[..., None] + noise[..., None, :])  # (case, robot, axis, phase, node)
        length = along[:, :, 0, :, :, None] + along[:, :, 1, :, None, :]
        np.sqrt(length, out=length)
        over_noise = length.reshape(*length.shape[:3], -1) @ self._normal_weights
        return np.asarray(over_noise.mean(axis=-1))


def _deviations(motion: Motion, loop: Loop) -> FloatArray:
    """Return the standard deviations of both handles, (case, robot, axis)."""
    return np.stack([deviation_of(part, loop.spectrum) for part in motion.to_noise], axis=1)
