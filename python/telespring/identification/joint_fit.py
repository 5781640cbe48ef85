"""All axes of a log fitted together: one regression per axis, and the lag of the force that they share.

The force's samples may be late: what was measured at time t + τ acted at time t. Then F(t + τ) = X(t) β on
every axis. τ is estimated with the coefficients, since a lag looks like mass: it shifts the mass by τ b. The
covariance is that of all parameters together, so that the intervals include what the lag leaves open.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.identification.covariance import estimate_covariance
from telespring.identification.filtering import Signals
from telespring.identification.regression import Fit, estimate_robustly
from telespring.identification.reweighting import paper_least_squares

__all__ = ["SEPARABLE", "JointFit", "Lag", "fit_axes", "orthogonal_share"]

#: A column is not estimated where a smaller share of its length is orthogonal to the others.
SEPARABLE = 0.05
#: The longest lag, s, and the largest number of steps to it.
_LONGEST_LAG, _STEPS = 0.2, 12
#: The weights of the robust fit are settled after so many steps.
_WEIGHINGS = 3


@dataclass(frozen=True)
class Lag:
    """The lag of the force behind the position, s.

    Attributes
    ----------
    value, standard_error, half_width
        s; the last is that of the 95 % interval.
    estimated
        False where it was given, or cannot be told from the other terms.
    """

    value: float
    standard_error: float = 0.0
    half_width: float = 0.0
    estimated: bool = False


@dataclass(frozen=True)
class JointFit:
    """The regressions of all axes, and their lags.

    Attributes
    ----------
    fits
        One per axis; the covariance of its coefficients includes what the lag leaves open.
    force, slope
        N and N/s, shape (axes, n): the force with its lag corrected, and its derivative.
    lags
        One per axis, the same for all that share it.
    """

    fits: tuple[Fit, ...]
    force: FloatArray
    slope: FloatArray
    lags: tuple[Lag, ...]


def fit_axes(
    regressors: Sequence[FloatArray],
    slopes: Sequence[FloatArray],
    signals: Signals,
    *,
    method: str = "robust",
    iterations: int = 1,
    lag: float | None = None,
    shared: bool = True,
) -> JointFit:
    """Fit the force of every axis to its regressor and, unless it is given, one lag (s) for all or each.

    `slopes` are the derivatives of the regressors by the time. They, and not the measured force, say how the
    force changes with a lag: the derivative of its noise would make the lag seem better known than it is.
    """
    count, used = len(regressors), signals.used
    if method == "paper":
        return _fit_as_printed(regressors, signals, iterations, lag or 0.0)
    values = np.full(count, 0.0 if lag is None else lag)
    group = [0] * count if shared else list(range(count))
    force = signals.force_after(values)
    slope = _predicted_slopes(
        [
            np.linalg.lstsq(x[used], row[used], rcond=None)[0]
            for x, row in zip(regressors, force, strict=True)
        ],
        slopes,
    )
    if lag is None:
        open_groups = {
            g
            for g in set(group)
            if any(
                orthogonal_share(slope[i, used], regressors[i][used]) > SEPARABLE
                for i in range(count)
                if group[i] == g
            )
        }
    else:
        open_groups = set()
    numbers = {g: k for k, g in enumerate(sorted(open_groups))}
    weighed: list[_Weighing] = []
    steps = 0
    while True:
        augmented = [
            np.column_stack([x, -slope[i]]) if group[i] in numbers else x for i, x in enumerate(regressors)
        ]
        if steps < _WEIGHINGS:
            starts = [known.estimate for known in weighed] or [None] * count
            weighed = [_weigh(a, force[i], used, method, starts[i]) for i, a in enumerate(augmented)]
        system = _System(augmented, regressors, force, weighed, group, numbers)
        solution = system.solve()
        shift = np.array([solution[system.lag_index[g]] if g in numbers else 0.0 for g in group])
        steps += 1
        if not numbers or np.abs(shift).max() < 1e-7 or steps == _STEPS:
            break
        values = np.clip(values + shift, -_LONGEST_LAG, _LONGEST_LAG)
        force = signals.force_after(values)
        slope = _predicted_slopes([solution[own] for own in system.own], slopes)
    return system.finish(solution, values + shift, signals, slope)


def _predicted_slopes(estimates: Sequence[FloatArray], slopes: Sequence[FloatArray]) -> FloatArray:
    """Return the derivative of the force (N/s) that the model of every axis gives."""
    return np.stack([matrix @ estimate for matrix, estimate in zip(slopes, estimates, strict=True)])


@dataclass(frozen=True)
class _Weighing:
    """How the samples of one axis count: weights, the derivative of ψ, and the scale of the residuals, N."""

    weights: FloatArray
    slope: FloatArray
    scale: float
    converged: bool
    estimate: FloatArray | None


def _weigh(
    regressor: FloatArray,
    force: FloatArray,
    used: NDArray[np.bool_],
    method: str,
    start: FloatArray | None,
) -> _Weighing:
    whole = used.astype(float)
    residual = np.zeros_like(force)
    weights, slope, converged, estimate = whole.copy(), whole.copy(), True, None
    if method == "robust":
        fit = estimate_robustly(regressor[used], force[used], start)
        weights[used], slope[used], residual[used] = fit.weights, fit.slope, fit.residual
        converged, estimate = fit.converged, fit.estimate
    else:
        residual[used] = force[used] - regressor[used] @ np.linalg.lstsq(regressor[used], force[used])[0]
    least = 1e-9 * float(np.sqrt((force[used] ** 2).mean()))
    scale = float(np.sqrt((weights * residual**2).sum() / weights.sum()))
    return _Weighing(weights, slope, max(scale, least, 1e-300), converged, estimate)


class _System:
    """The weighted normal equations of all axes: the coefficients axis by axis, then the lags."""

    def __init__(
        self,
        augmented: Sequence[FloatArray],
        regressors: Sequence[FloatArray],
        force: FloatArray,
        weighings: Sequence[_Weighing],
        group: Sequence[int],
        numbers: dict[int, int],
    ) -> None:
        self.force, self.weighings, self.group, self.augmented = force, weighings, group, augmented
        sizes = [x.shape[1] for x in regressors]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        self.lag_index = {g: int(starts[-1]) + k for g, k in numbers.items()}
        self.size = int(starts[-1]) + len(numbers)
        self.own = [slice(int(a), int(b)) for a, b in itertools.pairwise(starts)]
        self.index = [
            np.concatenate([np.arange(s.start, s.stop), [self.lag_index[g]] if g in numbers else []]).astype(
                int
            )
            for s, g in zip(self.own, group, strict=True)
        ]

    def _normal(self, weights: Sequence[FloatArray]) -> FloatArray:
        matrix = np.zeros((self.size, self.size))
        for index, columns, weight, w in zip(
            self.index, self.augmented, weights, self.weighings, strict=True
        ):
            matrix[np.ix_(index, index)] += columns.T @ (weight[:, None] * columns) / w.scale**2
        return matrix

    def solve(self) -> FloatArray:
        right = np.zeros(self.size)
        for i, (index, columns, w) in enumerate(zip(self.index, self.augmented, self.weighings, strict=True)):
            right[index] += columns.T @ (w.weights * self.force[i]) / w.scale**2
        matrix = self._normal([w.weights for w in self.weighings])
        size = np.sqrt(np.diag(matrix))
        return np.asarray(np.linalg.solve(matrix / np.outer(size, size), right / size) / size)

    def finish(
        self, solution: FloatArray, values: FloatArray, signals: Signals, slope: FloatArray
    ) -> JointFit:
        from scipy import stats

        # The last step of the lag is too short to fit again: the force moves by it along its slope.
        residual = np.stack(
            [
                self.force[i] - c @ solution[k]
                for i, (c, k) in enumerate(zip(self.augmented, self.index, strict=True))
            ]
        )
        columns = np.zeros((*self.force.shape, self.size))
        for i, (index, own, w) in enumerate(zip(self.index, self.augmented, self.weighings, strict=True)):
            columns[i][:, index] = own / w.scale
        scales = np.array([[w.scale] for w in self.weighings])
        covariance = estimate_covariance(
            columns,
            np.stack([w.weights for w in self.weighings]) * residual / scales,
            np.stack([w.slope for w in self.weighings]),
            signals.stretch,
        )
        errors = np.sqrt(np.diag(covariance.matrix))
        fits = tuple(
            Fit(
                estimate=solution[own],
                covariance=covariance.matrix[own, own],
                residual=residual[i],
                weights=w.weights,
                degrees_of_freedom=covariance.degrees_of_freedom[own],
                lags=covariance.lags,
                converged=w.converged,
            )
            for i, (own, w) in enumerate(zip(self.own, self.weighings, strict=True))
        )
        found = []
        for g, value in zip(self.group, values.tolist(), strict=True):
            if g not in self.lag_index:
                found.append(Lag(value))
                continue
            place = self.lag_index[g]
            quantile = float(stats.t.ppf(0.975, covariance.degrees_of_freedom[place]))
            error = float(errors[place])
            found.append(Lag(value, error, quantile * error, estimated=True))
        return JointFit(fits, self.force, slope, tuple(found))


def _fit_as_printed(
    regressors: Sequence[FloatArray], signals: Signals, iterations: int, lag: float
) -> JointFit:
    """Fit by the paper's reweighting, which knows no lag."""
    force = signals.force_after(np.full(len(regressors), lag))
    used, fits = signals.used, []
    for x, row in zip(regressors, force, strict=True):
        fit = paper_least_squares(x[used], row[used], iterations)
        weights = np.zeros_like(row)
        weights[used] = fit.weights
        fits.append(
            Fit(fit.estimate, fit.covariance, row - x @ fit.estimate, weights, fit.degrees_of_freedom, None)
        )
    return JointFit(tuple(fits), force, np.zeros_like(force), tuple(Lag(lag) for _ in fits))


def orthogonal_share(column: FloatArray, others: FloatArray) -> float:
    """Return the share of a column's length that is orthogonal to all other columns."""
    length = float(np.linalg.norm(column))
    if length == 0.0:
        return 0.0
    size = np.linalg.norm(others, axis=0)
    unit = others / np.where(size > 0.0, size, 1.0)
    remainder = column - unit @ np.linalg.lstsq(unit, column, rcond=None)[0]
    return float(np.linalg.norm(remainder)) / length
