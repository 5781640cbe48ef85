"""Covariance of regression coefficients whose residuals are autocorrelated, and the intervals that follow.

The covariance is that of Newey and West [1]_. It is too small for two reasons: a fit takes a part of the
noise out of the residuals, and the Bartlett kernel mixes the noise at the frequencies of the movement with
that at others, where there may be less. Both are corrected as Bell and McCaffrey do [2]_: by the factor by
which the estimator is too small under a working model of the noise, here an autoregression of first order,
which also chooses the bandwidth. The estimator itself scatters, the more the wider the bandwidth. The
quantile is that of Student's t with as many degrees of freedom as its mean and variance say (Satterthwaite),
per coefficient [3]_.

References
----------
.. [1] W. K. Newey, K. D. West, "A simple, positive semi-definite, heteroskedasticity and autocorrelation
   consistent covariance matrix", Econometrica 55 (1987) 703-708.
.. [2] R. M. Bell, D. F. McCaffrey, "Bias reduction in standard errors for linear regression with multi-stage
   samples", Survey Methodology 28 (2002) 169-181.
.. [3] G. W. Imbens, M. Kolesár, "Robust standard errors in small samples: some practical advice", Review of
   Economics and Statistics 98 (2016) 701-712.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray

__all__ = ["NORMAL_HALF_WIDTH", "Covariance", "estimate_covariance", "newey_west_lags"]

#: Half-width of a normal distribution's 95 % interval in standard deviations.
NORMAL_HALF_WIDTH = 1.959963984540054

#: The largest correlation of neighbouring residuals that is told from a drift.
_LARGEST_CORRELATION = 0.97
#: Where the estimator shows a smaller share of the variance, there are too few samples to correct it.
_LEAST_SHARE = 0.05


@dataclass(frozen=True)
class Covariance:
    """Of the coefficients of a regression.

    Attributes
    ----------
    matrix
        Shape (p, p).
    degrees_of_freedom
        Of the variance of every coefficient, for Student's t; shape (p,).
    lags
        Bandwidth in samples.
    """

    matrix: FloatArray
    degrees_of_freedom: FloatArray
    lags: int


def newey_west_lags(residual: FloatArray) -> int:
    """Choose the bandwidth of the Newey-West covariance, in samples, from evenly spaced residuals.

    The larger of the usual 4 (n/100)^(2/9) and Andrews' choice [1]_ for residuals that resemble an
    autoregression of first order, 1.1447 (4 ρ² n/(1 − ρ²)²)^(1/3), rounded down; half of the samples at most.

    References
    ----------
    .. [1] D. W. K. Andrews, "Heteroskedasticity and autocorrelation consistent covariance matrix estimation",
       Econometrica 59 (1991) 817-858.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(size=190)
    >>> newey_west_lags(noise)
    4
    >>> newey_west_lags(np.cumsum(noise)) > 20
    True
    """
    samples = residual.size
    correlation = abs(_neighbours_correlation(residual))
    usual = 4.0 * (samples / 100.0) ** (2.0 / 9.0)
    andrews = 1.1447 * (4.0 * correlation**2 * samples / (1.0 - correlation**2) ** 2) ** (1.0 / 3.0)
    return min(int(max(usual, andrews)), samples // 2)


def _neighbours_correlation(residual: FloatArray) -> float:
    power = float(residual @ residual)
    if power == 0.0:
        return 0.0
    correlation = float(residual[1:] @ residual[:-1]) / power
    return float(np.clip(correlation, -_LARGEST_CORRELATION, _LARGEST_CORRELATION))


def estimate_covariance(
    columns: FloatArray,
    score: FloatArray,
    slope: FloatArray,
    stretch: NDArray[np.int_] | None = None,
) -> Covariance:
    """Return the covariance of an M-estimate of all coefficients from one or more axes.

    Parameters
    ----------
    columns
        Regressors, shape (axes, n, p), each axis divided by the scale of its residuals. The axes share
        their samples' times; a coefficient of one axis has a column of zeros on the others.
    score, slope
        ψ of each residual over its axis' scale, and the derivative of ψ, of shape (axes, n).
    stretch
        Number of the stretch that a sample is from; nothing reaches across stretches.
    """
    starts = _stretch_starts(columns.shape[1], stretch)
    # Scaled columns: mass and offset may differ by orders of magnitude.
    size = np.sqrt((columns**2).mean(axis=(0, 1)))
    size = np.where(size > 0.0, size, 1.0)
    scaled = columns / size
    inverse = np.linalg.inv(np.einsum("atp,at,atq->pq", scaled, slope, scaled, optimize=True))
    lags = max(newey_west_lags(row) for row in score)
    matrix = inverse @ _kernel_sum(np.einsum("atp,at->tp", scaled, score), lags, starts) @ inverse
    # Where samples have less weight, as many of them count.
    weighted = scaled * np.sqrt(np.clip(slope, 0.0, None))[..., None]
    correlations = [max(0.0, _neighbours_correlation(row)) for row in score]
    shares, freedom = _expected(weighted, inverse, lags, correlations, starts)
    widening = np.sqrt(np.outer(shares, shares)) * np.outer(size, size)
    return Covariance(np.asarray(matrix / widening), freedom, lags)


def _kernel_sum(scores: FloatArray, lags: int, starts: NDArray[np.int_]) -> FloatArray:
    """Return the Newey-West covariance of the sum of all scores, one row per sample.

    Samples of different stretches, which begin at 0 and at `starts`, are taken as uncorrelated.
    """
    return np.asarray(scores.T @ _by_stretch(scores, starts, lambda part: _bartlett(part, lags)))


def _stretch_starts(samples: int, stretch: NDArray[np.int_] | None) -> NDArray[np.int_]:
    """Return the first sample of every stretch but the first."""
    if stretch is None:
        return np.zeros(0, dtype=int)
    assert stretch.size == samples
    return np.flatnonzero(np.diff(stretch)) + 1


def _by_stretch(
    values: FloatArray, starts: NDArray[np.int_], apply: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Apply a filter along the first dimension to every stretch by itself."""
    if not starts.size:
        return apply(values)
    return np.concatenate([apply(part) for part in np.split(values, starts)])


def _bartlett(values: FloatArray, lags: int) -> FloatArray:
    """Sum each sample's neighbours with the weights 1 − |d|/(lags + 1) of the Bartlett kernel."""
    # Twice a moving sum of lags + 1 samples: the triangle is the square box with itself.
    width = lags + 1
    padded = np.zeros((values.shape[0] + 2 * width - 1, *values.shape[1:]))
    padded[width : width + values.shape[0]] = values
    sums = np.cumsum(padded, axis=0)
    boxes = sums[width:] - sums[:-width]
    sums = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), boxes]), axis=0)
    return np.asarray((sums[width:] - sums[:-width]) / width)


def _autoregressive(values: FloatArray, correlation: float) -> FloatArray:
    """Sum each sample's neighbours with the weights ρ^|d|."""
    from scipy import signal

    if correlation == 0.0:
        return values
    before = signal.lfilter([1.0], [1.0, -correlation], values, axis=0)
    after = signal.lfilter([1.0], [1.0, -correlation], values[::-1], axis=0)[::-1]
    return np.asarray(before + after - values)


def _expected(
    columns: FloatArray,
    inverse: FloatArray,
    lags: int,
    correlations: list[float],
    starts: NDArray[np.int_],
) -> tuple[FloatArray, FloatArray]:
    """Return, per coefficient, what share of its variance the estimator shows, and its degrees of freedom.

    Written for residuals r = A e of noise e with the correlation matrix Ω, where A = I − H projects the model
    out: the estimator is r'G r with G = z z' times the kernel, z being the influence of each sample. Its mean
    is tr(G A Ω A); its variance under white noise is 2 tr(G A G A).
    """
    axes, _, count = columns.shape

    def kernel(values: FloatArray) -> FloatArray:
        return _by_stretch(values, starts, lambda part: _bartlett(part, lags))

    def correlated(axis: int, values: FloatArray) -> FloatArray:
        return _by_stretch(values, starts, lambda part: _autoregressive(part, correlations[axis]))

    coloured = np.stack([correlated(a, columns[a]) for a in range(axes)])
    noise = np.einsum("atp,atq->pq", columns, coloured, optimize=True)
    influences, coloured_influences = columns @ inverse, coloured @ inverse
    shares, freedom = np.ones(count), np.ones(count)
    for c in range(count):
        z = influences[..., c]
        weighed = np.einsum("at,atp->tp", z, columns)
        smooth = kernel(weighed)
        projected = z[..., None] * smooth
        crossed = inverse @ weighed.T @ smooth
        own = sum(_decaying_sum(z[a], lags, correlations[a], starts) for a in range(axes))
        mean = (
            own
            - 2.0 * float((coloured_influences * projected).sum())
            + float(np.trace(crossed @ inverse @ noise))
        )
        truth = float(sum(z[a] @ correlated(a, z[a]) for a in range(axes)))
        if not truth > 0.0:
            continue
        shares[c] = max(mean / truth, _LEAST_SHARE)
        white = float((z**2).sum()) - float((influences * projected).sum())
        squares = (
            _squared_kernel_sum((z**2).sum(axis=0), lags, starts)
            - 2.0 * float(((projected @ inverse) * projected).sum())
            + float(np.trace(crossed @ crossed))
        )
        freedom[c] = max(1.0, white**2 / squares) if squares > 0.0 else 1.0
    return shares, freedom


def _decaying_sum(values: FloatArray, lags: int, correlation: float, starts: NDArray[np.int_]) -> float:
    """Return Σ z_s z_t ρ^|s − t| (1 − |s − t|/(lags + 1))."""
    total = 0.0
    for part in np.split(values, starts):
        total += float(part @ part)
        for d in range(1, min(lags, part.size - 1) + 1 if correlation > 0.0 else 1):
            total += 2.0 * (1.0 - d / (lags + 1)) * correlation**d * float(part[d:] @ part[:-d])
    return total


def _squared_kernel_sum(squares: FloatArray, lags: int, starts: NDArray[np.int_]) -> float:
    """Return Σ z_s² z_t² (1 − |s − t|/(lags + 1))²."""
    total = 0.0
    for part in np.split(squares, starts):
        total += float(part @ part)
        for d in range(1, min(lags, part.size - 1) + 1):
            total += 2.0 * (1.0 - d / (lags + 1)) ** 2 * float(part[d:] @ part[:-d])
    return total
