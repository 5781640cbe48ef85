"""How faithfully the partner is felt: the delivered force beside that of the spring without delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray

__all__ = ["ForceResponse", "force_fidelity", "force_frequencies", "force_response", "intended_force"]

#: Hz; no hand moves faster, and what a spring over a network does to it is slower still.
_HIGHEST_FREQUENCY = 20.0


@dataclass(frozen=True, eq=False)
class ForceResponse:
    """The delivered force over the intended one, as a function of the frequency.

    Attributes
    ----------
    frequency
        Hz, without 0.
    gain
        1 where the force is delivered in full.
    phase
        rad, from −π to π; negative where the force comes late.
    coherence
        Share of the delivered force's power that follows the intended one linearly, 0 to 1. Where it is low,
        gain and phase mean little.
    """

    frequency: FloatArray
    gain: FloatArray
    phase: FloatArray
    coherence: FloatArray


def intended_force(
    position: FloatArray, velocity: FloatArray, stiffness: float, damping: float = 0.0
) -> FloatArray:
    """Compute what the coupling would deliver without delay, N.

    Parameters
    ----------
    position, velocity
        Of both handles, (…, robot, axis), m and m/s.
    stiffness, damping
        Of the coupling, N/m and N·s/m.

    Examples
    --------
    >>> still = np.zeros((2, 2))
    >>> intended_force(np.array([[0.0, 0.0], [0.02, 0.0]]), still, 100.0).tolist()
    [[2.0, 0.0], [-2.0, 0.0]]
    """
    force = stiffness * (position[..., ::-1, :] - position)
    if damping:
        force = force + damping * (velocity[..., ::-1, :] - velocity)
    return np.asarray(force)


def force_fidelity(intended: FloatArray, delivered: FloatArray) -> FloatArray:
    """Return the share of the intended force that is accounted for, 1 − Σ|F_intended − F|²/Σ|F_intended|².

    It is 1 for the intended force, 0 for none, and negative for a force that is worse than none. Both axes
    count together. NaN if no force was intended, or if a value is missing.

    Parameters
    ----------
    intended, delivered
        Forces over (…, time, robot, axis), N.

    Returns
    -------
    numpy.ndarray
        Over (…, robot).

    Examples
    --------
    Half of a force leaves a quarter of its power out.

    >>> force = np.sin(np.arange(8.0)).reshape(4, 1, 2)
    >>> force_fidelity(force, 0.5 * force).tolist()
    [0.75]
    """
    wanted = (intended**2).sum(axis=(-3, -1))
    missed = ((intended - delivered) ** 2).sum(axis=(-3, -1))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(wanted > 0.0, 1.0 - missed / wanted, np.nan))


def force_frequencies(samples: int, sample_period: float) -> FloatArray:
    """Return the frequencies of `force_response` for records of so many samples, Hz."""
    frequency = np.fft.rfftfreq(_segment_length(samples), sample_period)[1:]
    return np.asarray(frequency[frequency <= _HIGHEST_FREQUENCY])


def force_response(intended: FloatArray, delivered: FloatArray, sample_period: float) -> ForceResponse:
    """Estimate the delivered over the intended force by Welch's method.

    Parameters
    ----------
    intended, delivered
        Forces of at least one trial over (trial, time, robot, axis), N.
    sample_period
        s.

    Returns
    -------
    ForceResponse
        Of all trials, robots and axes together. NaN at frequencies at which no force was intended.

    Notes
    -----
    The segments are half a record long and overlap by half, under a Hann window and without their mean. Their
    spectra are averaged over trials, robots and axes before the quotient is taken (the H1 estimate of
    J. S. Bendat, A. G. Piersol, Random Data, 4th ed., Wiley 2010, section 6.1). A delay of δ shifts a
    segment of T out of its window: the gain of a random force is low by the factor 1 − (2π²/3)(δ/T)².

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> force = rng.normal(size=(3, 1000, 2, 2))
    >>> half = force_response(force, 0.5 * force, 0.01)
    >>> half.gain.round(6).min(), half.gain.round(6).max(), abs(half.phase).max() < 1e-9
    (np.float64(0.5), np.float64(0.5), np.True_)
    """
    from scipy.signal import csd

    frequency = force_frequencies(intended.shape[1], sample_period)
    chosen = slice(1, 1 + len(frequency))
    length = _segment_length(intended.shape[1])

    def spectrum(one: FloatArray, other: FloatArray) -> FloatArray:
        if not len(frequency):
            return np.empty(0)
        values = csd(one, other, fs=1.0 / sample_period, nperseg=length, axis=1)[1]
        return np.asarray(values[:, chosen].mean(axis=(0, 2, 3)))

    cross = spectrum(intended, delivered)
    wanted, given = (np.real(spectrum(force, force)) for force in (intended, delivered))
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(wanted > 0.0, cross / wanted, np.nan)
        coherence = np.where((wanted > 0.0) & (given > 0.0), np.abs(cross) ** 2 / (wanted * given), np.nan)
    phase = np.where(np.isnan(ratio), np.nan, np.angle(ratio))
    return ForceResponse(frequency, np.abs(ratio), phase, coherence)


def _segment_length(samples: int) -> int:
    return max(1, samples // 2)
