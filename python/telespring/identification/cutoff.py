"""The filter's cut-off, chosen from the position's spectrum: bandwidth of the movement and noise floor."""

from __future__ import annotations

import math

import numpy as np

from telespring._types import FloatArray

__all__ = [
    "CUTOFF_RULE",
    "FILTER_ORDER",
    "LARGEST_CUTOFF_SHARE",
    "choose_cutoff",
    "filtered_noise",
    "largest_cutoff",
    "movement_bandwidth",
    "noise_deviation",
]

#: What `choose_cutoff` does, for screens and records.
CUTOFF_RULE = (
    "5 times the bandwidth with 99.9 % of the velocity's power above the noise floor, but no higher than "
    "where position noise makes up 0.001 % of the acceleration's power"
)
FILTER_ORDER = 4
#: A cut-off above this share of the sample rate leaves nothing to filter.
LARGEST_CUTOFF_SHARE = 0.4

_BANDWIDTH_POWER = 0.999
_TIMES_BANDWIDTH = 5.0
#: Probability that noise alone counts as movement anywhere in the spectrum.
_FALSE_ALARM = 1e-3
#: Noise in the acceleration makes the mass too small by its share of the acceleration's power. This share is
#: a small part of any interval: it biases a mass known within 0.02 % by a twentieth of that.
_NOISE_SHARE = 1e-5
#: No movement of a robot reaches this frequency, Hz, nor this share of the sample rate.
_NO_MOVEMENT, _NO_MOVEMENT_SHARE = 60.0, 1.0 / 32.0


def choose_cutoff(position: FloatArray, rate: float) -> float:
    """Choose the cut-off of the filter, Hz, from the movement (`CUTOFF_RULE`).

    Of several rows of positions (m) the axis that moves fastest decides, up to what the noisiest axis
    tolerates. (Too low a cut-off costs precision, too high a cut-off causes bias.)
    """
    rows = np.atleast_2d(position)
    limits = [largest_cutoff(row, rate) for row in rows]
    desired = max(
        min(_TIMES_BANDWIDTH * movement_bandwidth(row, rate), limit)
        for row, limit in zip(rows, limits, strict=True)
    )
    return min(desired, *limits, LARGEST_CUTOFF_SHARE * rate)


def movement_bandwidth(position: FloatArray, rate: float) -> float:
    """Return the frequency, Hz, below which 99.9 % of the velocity's power lies, noise excluded.

    If nothing moves it is the resolution of the spectrum.

    Examples
    --------
    >>> time = np.arange(5000) / 1000.0
    >>> 1.9 < movement_bandwidth(0.1 * np.sin(2 * np.pi * 2.0 * time), 1000.0) < 2.7
    True
    """
    frequency, power, floor = _position_spectrum(position, rate)
    # A periodogram's noise is exponentially distributed: no bin exceeds this by chance.
    threshold = floor * math.log(frequency.size / _FALSE_ALARM)
    velocity = np.where(power > threshold, power, 0.0) * frequency**2
    total = float(velocity.sum())
    if total == 0.0:
        return float(frequency[1])
    below = np.cumsum(velocity) / total
    return float(frequency[max(1, int(np.searchsorted(below, _BANDWIDTH_POWER)))])


def largest_cutoff(position: FloatArray, rate: float) -> float:
    """Return the cut-off, Hz, at which position noise makes up 0.001 % of the acceleration's power.

    Noise in the regressor makes the mass too small, and however long the log is, no interval shows it. The
    noise grows with the fifth power of the cut-off, so this is a sharp limit. Where the movement itself has
    more noise, it is the resolution of the spectrum.

    Examples
    --------
    A tenth of a millimetre of noise, and a hundredth:

    >>> time = np.arange(20000) / 1000.0
    >>> noise = np.random.default_rng(1).normal(size=time.size)
    >>> movement = 0.1 * np.sin(2 * np.pi * 0.5 * time)
    >>> [round(largest_cutoff(movement + size * noise, 1000.0)) for size in (1e-4, 1e-5)]
    [4, 10]
    """
    frequency, power, floor = _position_spectrum(position, rate)
    noise = floor * np.cumsum(frequency**4)
    low = np.flatnonzero(noise[1:] <= _NOISE_SHARE * np.cumsum(power * frequency**4)[1:])
    return float(frequency[1 + low[-1]]) if low.size else float(frequency[1])


def filtered_noise(position: FloatArray, rate: float, cutoff: float) -> tuple[float, float]:
    """Return the variances of position noise in the filtered velocity, (m/s)², and acceleration, (m/s²)²."""
    frequency, _, floor = _position_spectrum(position, rate)
    # Forwards and backwards: the filter's gain is applied twice.
    passed = floor / (1.0 + (frequency / cutoff) ** (2 * FILTER_ORDER)) ** 2
    angular = 2.0 * np.pi * frequency
    return float((passed * angular**2).sum()), float((passed * angular**4).sum())


def noise_deviation(position: FloatArray, rate: float) -> float:
    """Return the standard deviation of a position's noise, m."""
    frequency, _, floor = _position_spectrum(position, rate)
    return math.sqrt(floor * frequency.size)


def _position_spectrum(position: FloatArray, rate: float) -> tuple[FloatArray, FloatArray, float]:
    """Return frequencies, Hz, the position's power per bin, m², and the noise floor per bin, m²."""
    from scipy import fft, signal

    samples = position.size
    length = fft.next_fast_len(samples, real=True)
    window = signal.get_window("hann", samples)
    power = np.abs(fft.rfft(signal.detrend(position) * window, length)) ** 2
    # Scaled so that the sum over the bins is the mean square of the position.
    power *= 2.0 / (length * float((window**2).sum()))
    frequency = np.asarray(fft.rfftfreq(length, 1.0 / rate))
    # The upper half of the spectrum is noise for any movement that one would sample at this rate. Its mean,
    # not its median: the noise of an encoder on a periodic movement consists of lines. Where a filter before
    # the recorder has emptied that half, look at the octaves below, down to where a movement may reach.
    lowest = max(_NO_MOVEMENT, _NO_MOVEMENT_SHARE * rate)
    top = frequency.size // 2
    floor = float(power[top:].mean())
    while frequency[top // 2] >= lowest:
        floor = max(floor, float(power[top // 2 : top].mean()))
        top //= 2
    return frequency, power, floor
