"""How the errors of identified robots carry over to the stability margins and the verdict.

Mass and damping of each robot on each axis are jointly normal, with the standard deviations and the
correlation that identification gave; robots and axes are independent. Unphysical draws (a mass not above 0, a
damping below 0) are rejected. The seed is fixed: the same input gives the same output.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from telespring._types import FloatArray
from telespring.model import Dyad
from telespring.theory import criteria
from telespring.theory.criteria import unstable_root_count

__all__ = [
    "LIGHTEST",
    "AxisUncertainty",
    "MarginUncertainty",
    "Probability",
    "RobotUncertainty",
    "delta_method",
    "margin_uncertainty",
    "sample_parameters",
    "stable_probability",
]

#: Draws from the parameters' distribution, and the seed they come from.
DRAWS = 20_000
SEED = 20251121
#: kg; a lighter draw is no robot.
LIGHTEST = 1e-4


class RobotUncertainty(Protocol):
    """Standard deviations of one robot's mass and damping per axis, and their correlation.

    `telespring.Study.uncertainty` gives one per robot.
    """

    @property
    def mass_sd(self) -> Sequence[float] | FloatArray:
        """Per axis, kg."""

    @property
    def damping_sd(self) -> Sequence[float] | FloatArray:
        """Per axis, N·s/m."""

    @property
    def correlation(self) -> Sequence[float] | FloatArray:
        """Per axis, between the errors of mass and damping."""


@dataclass(frozen=True)
class Probability:
    """A probability estimated by Monte Carlo.

    Attributes
    ----------
    value
        Share of the draws.
    standard_error
        Of that share, with one more draw of either kind added (Wilson's midpoint), so that it is not 0
        where all draws agree.
    draws
        Number of draws.
    """

    value: float
    standard_error: float
    draws: int

    @classmethod
    def of(cls, stable: np.ndarray[Any, np.dtype[np.bool_]]) -> Probability:
        """Estimate the probability of stability by the share of stable draws."""
        draws = int(stable.size)
        count = int(np.count_nonzero(stable))
        share = (count + 1) / (draws + 2)
        return cls(count / draws, math.sqrt(share * (1.0 - share) / (draws + 2)), draws)


@dataclass(frozen=True)
class AxisUncertainty:
    """Uncertainty of the margins of one axis, or of the worst one.

    Attributes
    ----------
    axis
        Its name; None for the worst over all axes.
    critical_stiffness
        95 % interval, N/m.
    maximum_delay
        95 % interval, s; an end is infinite if no delay destabilises.
    delay_unbounded
        Share of the draws in which no delay destabilises.
    """

    axis: str | None
    critical_stiffness: tuple[float, float]
    maximum_delay: tuple[float, float]
    delay_unbounded: float


@dataclass(frozen=True)
class MarginUncertainty:
    """Uncertainty of the margins and probability of stability, given the errors of the robots.

    Attributes
    ----------
    axes
        One entry per axis.
    worst
        The worst over all axes, draw by draw.
    stable
        Probability that the delay is stable on all axes.
    """

    axes: tuple[AxisUncertainty, ...]
    worst: AxisUncertainty
    stable: Probability


def sample_parameters(
    dyad: Dyad,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None],
    *,
    draws: int = DRAWS,
    seed: int = SEED,
) -> FloatArray:
    """Draw masses and dampings of both robots, operators added.

    Returns m1, b1, m2, b2 in kg and N·s/m, shape (4, axes, draws). A draw with a robot's mass below 0.0001 kg
    or damping below 0 is rejected and replaced.
    """
    random = np.random.default_rng(seed)
    parameters = np.empty((4, len(dyad.axes), draws))
    for robot in range(2):
        mass, damping = dyad.robots[robot].mass, dyad.robots[robot].damping
        known = uncertainty[robot]
        for i in range(len(dyad.axes)):
            # Drawn even where nothing is uncertain, so that one robot's draws do not depend on the other's.
            own = np.random.default_rng(random.integers(2**63))
            drawn = _draw_parameters(own, float(mass[i]), float(damping[i]), _parameter_sds(known, i), draws)
            parameters[2 * robot, i] = drawn[0] + dyad.operators[robot].mass[i]
            parameters[2 * robot + 1, i] = drawn[1] + dyad.operators[robot].damping[i]
    return parameters


def _parameter_sds(known: RobotUncertainty | None, axis: int) -> tuple[float, float, float]:
    if known is None:
        return 0.0, 0.0, 0.0
    return float(known.mass_sd[axis]), float(known.damping_sd[axis]), float(known.correlation[axis])


def _draw_parameters(
    random: np.random.Generator,
    mass: float,
    damping: float,
    deviations: tuple[float, float, float],
    draws: int,
) -> FloatArray:
    """Draw from the truncated normal by rejection."""
    mass_sd, damping_sd, correlation = deviations
    kept = np.empty((2, 0))
    while kept.shape[1] < draws:
        first, second = random.normal(size=(2, draws))
        second = correlation * first + math.sqrt(max(0.0, 1.0 - correlation**2)) * second
        both = np.stack([mass + mass_sd * first, damping + damping_sd * second])
        physical = (both[0] >= LIGHTEST) & (both[1] >= 0.0)
        kept = np.concatenate([kept, both[:, physical]], axis=1)
    return kept[:, :draws]


def stable_probability(
    dyad: Dyad,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None],
    stiffness: float,
    delay: float | tuple[float, float],
    *,
    draws: int = DRAWS,
    seed: int = SEED,
    sampling: tuple[float, float] = (0.0, 0.0),
) -> Probability:
    """Estimate the probability that a stiffness and a constant delay are stable on all axes.

    `uncertainty` is None for a robot that is known exactly. Of the one-way delays (s) only the mean matters.
    `sampling` is as in `margin_uncertainty`.

    Examples
    --------
    Table III's robots, known within 1 %, at the boundary itself:

    >>> from types import SimpleNamespace
    >>> import telespring as ts
    >>> known = SimpleNamespace(mass_sd=[0.01, 0.01], damping_sd=[0.08, 0.1], correlation=[0.0, 0.0])
    >>> probability = stable_probability(ts.hman(), (known, known), 71.231976, 0.16718632)
    >>> 0.45 < probability.value < 0.55
    True
    """
    parameters = sample_parameters(dyad, uncertainty, draws=draws, seed=seed)
    return Probability.of(_stable_draws(parameters, dyad, stiffness, float(np.mean(delay)), sampling))


def _stable_draws(
    parameters: FloatArray,
    dyad: Dyad,
    stiffness: float,
    delay: float,
    sampling: tuple[float, float] = (0.0, 0.0),
) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Judge every draw; sampled controllers to first order in their period.

    A force that is held for a period and computed in some time lags by half the period plus that time. The
    partner's position is then older by this lag, and the own one, older too, takes stiffness times lag from
    the damping.
    """
    period, computing = sampling
    lag = 0.5 * period + computing
    stable = np.ones(parameters.shape[2], dtype=bool)
    for axis in dyad:
        m1, b1, m2, b2 = parameters[:, axis.index]
        b1, b2 = b1 - stiffness * lag, b2 - stiffness * lag
        damped = (b1 >= 0.0) & (b2 >= 0.0)
        b1, b2 = np.maximum(b1, 0.0), np.maximum(b2, 0.0)
        count = unstable_root_count(m1, b1, m2, b2, stiffness, delay + lag, **axis.keywords)
        stable &= damped & (np.asarray(count) == 0)
    return stable


def margin_uncertainty(
    dyad: Dyad,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None],
    stiffness: float,
    delay: float | tuple[float, float],
    *,
    draws: int = DRAWS,
    seed: int = SEED,
    sampling: tuple[float, float] = (0.0, 0.0),
) -> MarginUncertainty:
    """Propagate the errors of the parameters to critical stiffness, maximum delay and the verdict.

    The stiffness is that of the maximum delay and the verdict; other arguments are as in
    `stable_probability`. The 95 % intervals are from the 2.5 % and 97.5 % quantiles of the draws. `sampling`
    is the controllers' sample period and computing time, s, which the verdict accounts for to first order;
    the margins are those of continuous controllers.
    """
    parameters = sample_parameters(dyad, uncertainty, draws=draws, seed=seed)
    critical, delays = [], []
    for axis in dyad:
        m1, b1, m2, b2 = parameters[:, axis.index]
        critical.append(np.asarray(criteria.critical_stiffness(m1, b1, m2, b2, **axis.keywords)))
        delays.append(np.asarray(criteria.maximum_delay(m1, b1, m2, b2, stiffness, **axis.keywords)))
    names = [str(name) for name in dyad.axes]
    return MarginUncertainty(
        axes=tuple(_margin_intervals(name, k, d) for name, k, d in zip(names, critical, delays, strict=True)),
        worst=_margin_intervals(None, np.min(critical, axis=0), np.min(delays, axis=0)),
        stable=Probability.of(_stable_draws(parameters, dyad, stiffness, float(np.mean(delay)), sampling)),
    )


def _margin_intervals(axis: str | None, critical: FloatArray, delay: FloatArray) -> AxisUncertainty:
    def interval(values: FloatArray) -> tuple[float, float]:
        # Without interpolation: some of the delays may be infinite.
        low, high = np.quantile(values, [0.025, 0.975], method="closest_observation")
        return float(low), float(high)

    return AxisUncertainty(axis, interval(critical), interval(delay), float(np.isinf(delay).mean()))


def delta_method(
    dyad: Dyad,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None],
    stiffness: float,
    axis: int = 0,
) -> tuple[float, float]:
    """Return the standard deviations of critical stiffness (N/m) and maximum delay (s) to first order.

    The derivatives are central differences of the exact criteria. This is accurate where the errors are small
    and the margins smooth; the Monte Carlo of `margin_uncertainty` needs neither. The second is NaN if the
    maximum delay is infinite.
    """
    judged = dyad.axis(axis)
    middle = np.array(judged.parameters)
    covariance = np.zeros((4, 4))
    for robot, known in enumerate(uncertainty):
        mass_sd, damping_sd, correlation = _parameter_sds(known, axis)
        block = np.array(
            [
                [mass_sd**2, correlation * mass_sd * damping_sd],
                [correlation * mass_sd * damping_sd, damping_sd**2],
            ]
        )
        covariance[2 * robot : 2 * robot + 2, 2 * robot : 2 * robot + 2] = block
    step = 1e-6 * middle
    m1, b1, m2, b2 = (middle + np.concatenate([np.diag(step), -np.diag(step)])).T
    critical = np.asarray(criteria.critical_stiffness(m1, b1, m2, b2, **judged.keywords))
    delays = np.asarray(criteria.maximum_delay(m1, b1, m2, b2, stiffness, **judged.keywords))
    deviations = []
    for values in (critical, delays):
        if not np.isfinite(values).all():
            deviations.append(math.nan)
            continue
        gradient = (values[:4] - values[4:]) / (2.0 * step)
        deviations.append(math.sqrt(float(gradient @ covariance @ gradient)))
    return deviations[0], deviations[1]
