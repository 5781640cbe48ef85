"""Maximum-likelihood fit of the unknowns to the fitted cells, with profiles, intervals and correlations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.likelihood import Likelihood, threshold
from telespring.paper.calibration.minimise import minimise
from telespring.paper.calibration.surrogate import Surrogate
from telespring.paper.calibration.unknowns import HIGH, NAMES, UNKNOWNS, Variant, free_unknowns

__all__ = ["Fit", "PairMap", "Profile", "fit", "optimum"]

#: The laboratory's own mean errors (condition, robot), m, at a point in units of the upper bounds.
Confirm = Callable[[FloatArray], FloatArray]

_PROFILE_POINTS = 25
_PAIR_POINTS = 15
#: How often the surrogate is corrected by the laboratory's own errors at its optimum, at most.
_CONFIRMATIONS = 4


@dataclass(frozen=True)
class Profile:
    """Rise of the deviance above its minimum along one unknown, the others free."""

    name: str
    values: FloatArray
    rise: FloatArray
    interval: tuple[float, float]
    open_below: bool
    open_above: bool

    def numbers(self) -> dict[str, Any]:
        """Profile of one unknown for JSON."""
        return {
            "values": self.values.tolist(),
            "deviance_rise": self.rise.tolist(),
            "interval": list(self.interval),
            "open_below": self.open_below,
            "open_above": self.open_above,
        }


@dataclass(frozen=True)
class PairMap:
    """Rise of the deviance over two unknowns, the others free; `rise` is (second, first)."""

    names: tuple[str, str]
    first: FloatArray
    second: FloatArray
    rise: FloatArray


@dataclass(frozen=True)
class Fit:
    """One variant fitted to the cells.

    Attributes
    ----------
    variant
        Whether the arm's inertia is inside Table III or on top of it.
    values
        The unknowns at the optimum, SI units, without the arm's mass if the motion does not depend on it.
    point
        All four in units of their upper bounds, as simulated.
    profiles, pairs
        Along each unknown and each pair of unknowns.
    threshold
        Rise of the deviance up to which a value is inside the interval.
    correlation
        Of the unknowns, from the Gauss-Newton Hessian at the optimum, in the order of `values`.
    deviance
        At the optimum.
    misfit
        Root-mean-square residual of a condition's mean error, and of half the difference of both, m.
    correction
        Largest correction, m, of the surrogate by the last run of the laboratory at the optimum.
    """

    variant: Variant
    values: dict[str, float]
    point: FloatArray
    profiles: dict[str, Profile]
    pairs: tuple[PairMap, ...]
    threshold: float
    correlation: FloatArray
    deviance: float
    misfit: tuple[float, float]
    correction: float

    def numbers(self) -> dict[str, Any]:
        """Fitted unknowns, their profiles and correlations for JSON, SI units."""
        unknowns = {unknown.name: unknown for unknown in UNKNOWNS}
        return {
            "variant": self.variant,
            "unknowns": {
                name: {
                    "value": value,
                    "unit": unknowns[name].unit,
                    "upper_bound": unknowns[name].high,
                    **self.profiles[name].numbers(),
                }
                for name, value in self.values.items()
            },
            "without_effect": [name for name in NAMES if name not in self.values],
            "interval_threshold": self.threshold,
            "correlation": {"unknowns": list(self.values), "matrix": self.correlation.tolist()},
            "deviance": self.deviance,
            "misfit_of_mean": self.misfit[0],
            "misfit_of_half_difference": self.misfit[1],
            "surrogate_correction_at_optimum": self.correction,
        }


def optimum(surrogate: Surrogate, likelihood: Likelihood, free: tuple[int, ...]) -> tuple[FloatArray, float]:
    """Compute the most likely unknowns, in units of their upper bounds, and their deviance."""
    points, values = minimise(
        lambda points: likelihood.deviance(surrogate(points)),
        np.zeros((1, len(NAMES))),
        free,
        first=4096,
        further=512,
        rounds=11,
    )
    return points[0], float(values[0])


def fit(surrogate: Surrogate, likelihood: Likelihood, variant: Variant, confirm: Confirm) -> Fit:
    """Fit one variant's unknowns on the surrogate; `confirm`, a laboratory run, corrects the optimum."""
    free = free_unknowns(variant)
    point, value = optimum(surrogate, likelihood, free)
    correction = float("nan")
    for _ in range(_CONFIRMATIONS):
        simulated = confirm(point)
        correction = float(
            np.max(np.abs(np.where(np.isfinite(simulated), simulated, np.inf) - surrogate(point)))
        )
        surrogate = surrogate.through(point, simulated)
        before = point
        point, value = optimum(surrogate, likelihood, free)
        if np.max(np.abs(point - before)) < 0.005:
            break
    limit = threshold(len(likelihood.mean), len(free))
    profiles = _profile_likelihoods(surrogate, likelihood, free, point, value, limit)
    return Fit(
        variant=variant,
        values={NAMES[i]: float(point[i] * HIGH[i]) for i in free},
        point=point,
        profiles=profiles,
        pairs=_pair_deviance_maps(surrogate, likelihood, free, point, value),
        threshold=limit,
        correlation=_correlation_of_unknowns(surrogate, likelihood, free, point),
        deviance=value,
        misfit=_misfit_of_cells(likelihood, surrogate(point)),
        correction=correction,
    )


def _misfit_of_cells(likelihood: Likelihood, simulated: FloatArray) -> tuple[float, float]:
    common, difference = likelihood.components(simulated)
    return float(np.sqrt(np.mean(common**2))), float(np.sqrt(np.mean(difference**2)))


def _profile_likelihoods(
    surrogate: Surrogate,
    likelihood: Likelihood,
    free: tuple[int, ...],
    point: FloatArray,
    value: float,
    limit: float,
) -> dict[str, Profile]:
    profiles = {}
    for i in free:
        grid = np.unique(np.append(np.linspace(0.0, 1.0, _PROFILE_POINTS), point[i]))
        start = np.repeat(point[None], len(grid), axis=0)
        start[:, i] = grid
        _, deviance = minimise(
            lambda points: likelihood.deviance(surrogate(points)),
            start,
            [j for j in free if j != i],
            first=256,
            further=64,
            rounds=8,
        )
        rise = np.maximum(deviance - value, 0.0)
        low, high = _profile_interval(grid, rise, float(point[i]), limit)
        profiles[NAMES[i]] = Profile(
            name=NAMES[i],
            values=grid * HIGH[i],
            rise=rise,
            interval=(float(low * HIGH[i]), float(high * HIGH[i])),
            open_below=bool(rise[0] <= limit),
            open_above=bool(rise[-1] <= limit),
        )
    return profiles


def _profile_interval(grid: FloatArray, rise: FloatArray, best: float, limit: float) -> tuple[float, float]:
    """Outermost values inside the limit, by linear interpolation between points of the grid."""
    inside = np.flatnonzero(rise <= limit)
    first, last = int(inside[0]), int(inside[-1])
    low, high = min(float(grid[first]), best), max(float(grid[last]), best)
    if first > 0:
        low = float(np.interp(-limit, -rise[first - 1 : first + 1], grid[first - 1 : first + 1]))
    if last + 1 < len(grid):
        high = float(np.interp(limit, rise[last : last + 2], grid[last : last + 2]))
    return low, high


def _pair_deviance_maps(
    surrogate: Surrogate, likelihood: Likelihood, free: tuple[int, ...], point: FloatArray, value: float
) -> tuple[PairMap, ...]:
    grid = np.linspace(0.0, 1.0, _PAIR_POINTS)
    maps = []
    for i, j in combinations(free, 2):
        one, two = np.meshgrid(grid, grid)
        start = np.repeat(point[None], one.size, axis=0)
        start[:, i], start[:, j] = one.ravel(), two.ravel()
        _, deviance = minimise(
            lambda points: likelihood.deviance(surrogate(points)),
            start,
            [k for k in free if k not in (i, j)],
            first=64,
            further=16,
            rounds=5,
        )
        rise = np.maximum(deviance - value, 0.0).reshape(one.shape)
        maps.append(PairMap((NAMES[i], NAMES[j]), grid * HIGH[i], grid * HIGH[j], rise))
    return tuple(maps)


def _correlation_of_unknowns(
    surrogate: Surrogate, likelihood: Likelihood, free: tuple[int, ...], point: FloatArray
) -> FloatArray:
    """Correlation from the inverse of J' V⁻¹ J, with J by central differences, one-sided at a bound."""
    step, rows = 0.02, []
    for i in free:
        low, high = point.copy(), point.copy()
        low[i], high[i] = max(point[i] - step, 0.0), min(point[i] + step, 1.0)
        change = (surrogate(high) - surrogate(low)) / (high[i] - low[i])
        rows.append([(change[:, 0] + change[:, 1]) / 2, (change[:, 1] - change[:, 0]) / 2])
    variance = np.array(likelihood.variances(surrogate(point)))
    jacobian = (np.array(rows) / np.sqrt(variance)[None, :, None]).reshape(len(free), -1)
    covariance = np.linalg.pinv(jacobian @ jacobian.T, hermitian=True)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return np.asarray(np.clip(covariance / np.outer(deviation, deviation), -1.0, 1.0))
