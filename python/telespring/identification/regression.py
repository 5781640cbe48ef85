"""Linear regression with confidence intervals that account for autocorrelated residuals (`covariance`)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.identification.covariance import estimate_covariance

__all__ = ["Fit", "RobustEstimate", "estimate_robustly", "least_squares", "regressor_matrix"]

#: A robust fit that has not converged after so many steps is reported as such.
_MAXIMUM_STEPS = 200

#: In robust standard deviations: up to the first a sample has full weight, from the last on none.
_HAMPEL = (4.0, 6.0, 9.0)


@dataclass(frozen=True)
class Fit:
    """Coefficients of a linear regression with their covariance.

    Attributes
    ----------
    estimate
        One coefficient per column of the regressor.
    covariance
        Of the coefficients.
    residual
        Measured minus estimated force, N.
    weights
        Weights of the samples, 1 for full weight.
    degrees_of_freedom
        Per coefficient, for the quantile of Student's t.
    lags
        Newey-West bandwidth in samples; None if the covariance assumes independent residuals.
    converged
        False if the iteration stopped before it converged.
    """

    estimate: FloatArray
    covariance: FloatArray
    residual: FloatArray
    weights: FloatArray
    degrees_of_freedom: FloatArray
    lags: int | None
    converged: bool = True

    @property
    def standard_error(self) -> FloatArray:
        """Standard errors of the coefficients."""
        return np.sqrt(np.diag(self.covariance))

    def half_width(self) -> FloatArray:
        """Return the half-widths of the coefficients' 95 % confidence intervals."""
        from scipy import stats

        return np.asarray(stats.t.ppf(0.975, self.degrees_of_freedom) * self.standard_error)


def regressor_matrix(
    acceleration: FloatArray, velocity: FloatArray, direction: FloatArray | None, *, offset: bool
) -> FloatArray:
    """Stack the columns [a, v, sign v, 1]; the third is omitted without a direction, the last by choice."""
    columns = [acceleration, velocity]
    if direction is not None:
        columns.append(direction)
    if offset:
        columns.append(np.ones_like(velocity))
    return np.stack(columns, axis=-1)


def least_squares(
    regressor: FloatArray,
    force: FloatArray,
    weights: FloatArray | None = None,
    stretch: NDArray[np.int_] | None = None,
) -> Fit:
    """Fit by ordinary or weighted least squares, with a Newey-West covariance.

    The rows of the regressor and the forces (N) are samples, and a weight of 1 is full weight. `stretch`
    numbers the stretch that a sample is from; the covariance does not reach across stretches.
    """
    weights = np.ones_like(force) if weights is None else weights
    root = np.sqrt(weights)
    estimate = _solve(regressor * root[:, None], force * root)
    residual = force - regressor @ estimate
    covariance = estimate_covariance(regressor[None], (weights * residual)[None], weights[None], stretch)
    return Fit(
        estimate=estimate,
        covariance=covariance.matrix,
        residual=residual,
        weights=weights,
        degrees_of_freedom=covariance.degrees_of_freedom,
        lags=covariance.lags,
    )


def _solve(regressor: FloatArray, force: FloatArray) -> FloatArray:
    # Scaled columns: mass and offset may differ by orders of magnitude.
    size = np.sqrt((regressor**2).mean(axis=0))
    size = np.where(size > 0.0, size, 1.0)
    return np.asarray(np.linalg.lstsq(regressor / size, force, rcond=None)[0], dtype=float) / size


@dataclass(frozen=True)
class RobustEstimate:
    """An M-estimate: coefficients, residuals (N), weights (1 for full weight), and the derivative of ψ."""

    estimate: FloatArray
    residual: FloatArray
    weights: FloatArray
    slope: FloatArray
    converged: bool = True


def estimate_robustly(
    regressor: FloatArray, force: FloatArray, start: FloatArray | None = None
) -> RobustEstimate:
    """Fit by Hampel's three-part M-estimator, started from Huber's.

    Both are statsmodels' RLM. Huber's problem is convex, so its solution does not depend on a start. Hampel's
    function then gives every sample up to 4 robust standard deviations full weight and rejects those beyond
    9: a glitch has no influence, while what the model omits still counts as in least squares. (The usual
    tunings weigh that down too, and estimate something else: on the axis of Janot et al. they shift the
    damping by 3 %.) The loss is bounded and the scale is the median absolute residual of all samples, so
    the fit cannot collapse onto a few of them as it does under the paper's weights.

    If no residual is large, the fit is that of ordinary least squares. `start` takes the place of Huber's
    solution, where a fit of nearly the same forces is known.
    """
    import statsmodels.api as sm

    ordinary = _solve(regressor, force)
    residual = force - regressor @ ordinary
    scale = float(sm.robust.scale.mad(residual, center=0))
    # Residuals from rounding alone have no scale; and where none is large, this is Hampel's solution already.
    if scale <= 1e-12 * float(np.abs(force).max()) or np.abs(residual).max() <= _HAMPEL[0] * scale:
        return RobustEstimate(ordinary, residual, np.ones_like(force), np.ones_like(force))
    with warnings.catch_warnings():
        # The result says whether it converged.
        warnings.simplefilter("ignore")
        if start is None:
            start = sm.RLM(force, regressor, M=sm.robust.norms.HuberT()).fit().params
        norm = sm.robust.norms.Hampel(*_HAMPEL)
        hampel = sm.RLM(force, regressor, M=norm).fit(start_params=start, maxiter=_MAXIMUM_STEPS)
    residual = np.asarray(hampel.resid)
    return RobustEstimate(
        np.asarray(hampel.params),
        residual,
        np.asarray(hampel.weights),
        np.asarray(norm.psi_deriv(residual / hampel.scale)),
        hampel.fit_history["iteration"] < _MAXIMUM_STEPS,
    )
