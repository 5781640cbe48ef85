"""The paper's weighted least squares, and why it collapses (Appendix B).

The paper prints weights 1/(r² + ε). Each step reduces Σ log(r² + ε), and the fit collapses onto as many
samples as there are parameters. It is here for comparison.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._types import FloatArray
from telespring.identification.regression import Fit

__all__ = ["PAPER_EPSILON", "Reweighting", "paper_least_squares", "paper_reweightings"]

#: ε of the paper's weights 1/(r² + ε): the relative accuracy of floating-point numbers.
PAPER_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Reweighting:
    """One step of the paper's iteratively reweighted least squares.

    Attributes
    ----------
    iteration
        How often weights were taken from residuals; 0 is ordinary least squares.
    estimate
        Coefficients.
    half_width
        Half-widths of the 95 % intervals that weighted least squares claims.
    log_loss
        Σ log(r² + ε), which no step of the reweighting increases.
    effective_samples
        (Σw)²/Σw²: the number of samples that carry the weight.
    """

    iteration: int
    estimate: FloatArray
    half_width: FloatArray
    log_loss: float
    effective_samples: float

    def to_json(self) -> dict[str, Any]:
        """Return the numbers of one reweighting."""
        return {
            "iteration": self.iteration,
            "estimate": self.estimate.tolist(),
            "half_width": self.half_width.tolist(),
            "log_loss": self.log_loss,
            "effective_samples": self.effective_samples,
        }


def paper_least_squares(regressor: FloatArray, force: FloatArray, iterations: int = 1) -> Fit:
    """Fit by the paper's weighted least squares: weights 1/(r² + ε) from the residuals of the last fit.

    The first weights come from ordinary least squares; the paper prints one step and no number. The
    covariance is that of weighted least squares with known weights and independent residuals. Neither holds:
    see `paper_reweightings`.
    """
    return _reweighted_fits(regressor, force, {iterations})[0][1]


def paper_reweightings(
    regressor: FloatArray, force: FloatArray, iterations: tuple[int, ...] = (0, 1, 2, 5, 10, 30, 100)
) -> list[Reweighting]:
    """Iterate the paper's weights and show how the fit collapses onto a few samples.

    Weights 1/(r² + ε) are those of a majorisation of Σ log(r² + ε): no step makes that sum larger. It has a
    deep minimum, log ε for each sample met exactly, wherever the fit meets as many samples exactly as there
    are coefficients. The iteration falls into one of these: a fit through p samples out of n, with an
    interval as narrow as rounding that says nothing about the parameters.

    Parameters
    ----------
    regressor
        One row per sample, one column per coefficient.
    force
        N, one per sample.
    iterations
        The numbers of reweightings to report.

    Returns
    -------
    list of Reweighting
        One per requested number.
    """
    return [
        Reweighting(
            iteration=iteration,
            estimate=fit.estimate,
            half_width=fit.half_width(),
            log_loss=float(np.log(fit.residual**2 + PAPER_EPSILON).sum()),
            effective_samples=float(fit.weights.sum() ** 2 / (fit.weights**2).sum()),
        )
        for iteration, fit in _reweighted_fits(regressor, force, set(iterations))
    ]


def _reweighted_fits(regressor: FloatArray, force: FloatArray, iterations: set[int]) -> list[tuple[int, Fit]]:
    import statsmodels.api as sm

    weights = np.ones_like(force)
    fits = []
    for iteration in range(max(iterations) + 1):
        wls = sm.WLS(force, regressor, weights=weights).fit(method="qr")
        residual = force - regressor @ np.asarray(wls.params)
        if iteration in iterations:
            fit = Fit(
                estimate=np.asarray(wls.params),
                covariance=np.asarray(wls.cov_params()),
                residual=residual,
                weights=weights / weights.max(),
                degrees_of_freedom=np.full(regressor.shape[1], float(force.size - regressor.shape[1])),
                lags=None,
            )
            fits.append((iteration, fit))
        weights = 1.0 / (residual**2 + PAPER_EPSILON)
        if not math.isfinite(float(weights.sum())):
            break
    return fits
