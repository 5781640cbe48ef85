"""Velocity and acceleration from measured positions, without shifting or shrinking them against the force.

Position and force pass the same zero-phase low-pass filter. Mass, damping and friction act on the filtered
signals exactly as on the raw ones (the filter is linear and the same for all), so that the filter brings no
bias: parallel filtering, as in the identification of robots (Gautier 1997, Swevers et al. 1997).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray

__all__ = ["CUTOFF_RULE", "Signals", "choose_cutoff", "filtered_signals", "movement_bandwidth"]

#: How `choose_cutoff` finds the cut-off, for people.
CUTOFF_RULE = (
    "5 times the frequency below which 99.9 % of the power of the velocity lies, counted where the "
    "spectrum of the position stands above its noise"
)
_POWER_BELOW = 0.999
_TIMES_BANDWIDTH = 5.0
#: The spectrum counts where it stands this many times above its own floor.
_ABOVE_NOISE = 10.0
#: A cut-off of more than this share of the sample rate leaves nothing to filter.
_LARGEST_SHARE = 0.4
_ORDER = 4
#: What the ends of a log do to the filtered signals has died away after this many periods of the cut-off
#: frequency: the slowest pole of the filter decays by exp(−2.4 n) over n of them.
_END_PERIODS = 3.0
#: Samples kept per period of the cut-off frequency: a little more than the two that lose nothing.
_KEPT_PER_PERIOD = 2.5
#: With fewer samples left, intervals would be guesses.
_LEAST_KEPT = 50

# Central differences of sixth order: at a tenth of the sample rate the first errs by 0.04 %.
_FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
_REACH = 3


@dataclass(frozen=True)
class Signals:
    """What a log says after filtering, at a rate that keeps no redundant samples.

    Attributes
    ----------
    time
        s, shape (n,).
    position, velocity, acceleration, jerk
        m, m/s, m/s² and m/s³; time comes last: shape (..., n).
    force
        N, of the same shape.
    direction
        The sign of the velocity, passed through the same filter.
    cutoff
        Cut-off of the low-pass filter, Hz.
    decimation
        Every how manieth sample was kept.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray
    force: FloatArray
    direction: FloatArray
    cutoff: float
    decimation: int


def movement_bandwidth(position: FloatArray, rate: float) -> float:
    """Find the frequency, Hz, below which nearly all of a movement's velocity lies.

    Parameters
    ----------
    position
        m, shape (n,).
    rate
        Samples per second, Hz.

    Returns
    -------
    float
        The frequency with 99.9 % of the velocity's power below it, noise left out; the resolution of the
        spectrum where nothing moves.

    Examples
    --------
    >>> time = np.arange(5000) / 1000.0
    >>> 1.9 < movement_bandwidth(0.1 * np.sin(2 * np.pi * 2.0 * time), 1000.0) < 2.7
    True
    """
    from scipy import fft, signal

    samples = position.size
    length = fft.next_fast_len(samples, real=True)
    windowed = signal.detrend(position) * signal.get_window("hann", samples)
    # Only ratios count, so the spectrum may have any scale.
    power = np.abs(fft.rfft(windowed, length)) ** 2
    frequency = np.asarray(fft.rfftfreq(length, 1.0 / rate))
    # The upper half of the spectrum of any movement that one would sample at this rate is noise. Its
    # median is ln 2 times the mean of a periodogram's exponential distribution.
    floor = float(np.median(power[power.size // 2 :])) / math.log(2.0)
    velocity = np.where(power > _ABOVE_NOISE * floor, power, 0.0) * frequency**2
    total = float(velocity.sum())
    if total == 0.0:
        return float(frequency[1])
    below = np.cumsum(velocity) / total
    return float(frequency[max(1, int(np.searchsorted(below, _POWER_BELOW)))])


def choose_cutoff(position: FloatArray, rate: float) -> float:
    """Choose the cut-off of the filter from the movement itself (`CUTOFF_RULE`).

    Parameters
    ----------
    position
        m, shape (n,), or (axes, n): then the axis that moves fastest decides.
    rate
        Samples per second, Hz.

    Returns
    -------
    float
        Hz, at most 0.4 of the sample rate.
    """
    rows = np.atleast_2d(position)
    widest = max(movement_bandwidth(row, rate) for row in rows)
    return min(_TIMES_BANDWIDTH * widest, _LARGEST_SHARE * rate)


def filtered_signals(
    time: FloatArray, position: FloatArray, force: FloatArray, *, rate: float, cutoff: float
) -> Signals:
    """Filter position and force alike, differentiate, cut off the ends and thin out.

    Parameters
    ----------
    time
        s, shape (n,), evenly spaced.
    position, force
        m and N, time last: shape (..., n). All rows are filtered at once.
    rate
        Samples per second, Hz.
    cutoff
        Cut-off frequency, Hz: there a fourth-order Butterworth filter, run forwards and backwards, lets
        half of the amplitude pass.

    Returns
    -------
    Signals
        The filtered signals.

    Raises
    ------
    telespring.InvalidInput
        Where the cut-off does not suit the sample rate, or the log is too short for it.
    """
    from scipy import signal

    if not 0.0 < cutoff <= _LARGEST_SHARE * rate:
        raise InvalidInput(
            "cutoff",
            f"{cutoff:g} Hz",
            f"a cut-off above 0 and up to {_LARGEST_SHARE:g} of the sample rate is needed, here "
            f"{_LARGEST_SHARE * rate:g} Hz",
            "Leave it away to have it chosen from the movement.",
        )
    ends = math.ceil(_END_PERIODS * rate / cutoff)
    decimation = max(1, int(rate / (_KEPT_PER_PERIOD * cutoff)))
    least = 2 * ends + _LEAST_KEPT * decimation
    if time.size < least:
        raise InvalidInput(
            "time",
            f"{time.size} samples, {time.size / rate:.3g} s",
            f"with a cut-off of {cutoff:.3g} Hz at least {least / rate:.3g} s are needed",
            "Record longer, move faster, or give a higher cut-off.",
        )
    sections = signal.butter(_ORDER, cutoff, fs=rate, output="sos")

    def low_pass(values: FloatArray) -> FloatArray:
        return np.asarray(signal.sosfiltfilt(sections, values, axis=-1))

    smooth = low_pass(position)
    velocity = _difference(smooth, _FIRST) * rate
    acceleration = _difference(smooth, _SECOND) * rate**2
    jerk = _difference(acceleration, _FIRST) * rate
    direction = low_pass(np.sign(velocity))

    def kept(values: FloatArray, lost: int = 0) -> FloatArray:
        """Cut off the ends, which the filter had to guess, of what differences made shorter by `lost`."""
        start = ends - lost
        return values[..., start : values.shape[-1] - start : decimation]

    return Signals(
        time=kept(time),
        position=kept(smooth),
        velocity=kept(velocity, _REACH),
        acceleration=kept(acceleration, _REACH),
        jerk=kept(jerk, 2 * _REACH),
        force=kept(low_pass(force)),
        direction=kept(direction, _REACH),
        cutoff=cutoff,
        decimation=decimation,
    )


def _difference(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weigh each sample's neighbours; the result is shorter by the reach at both ends."""
    length = values.shape[-1] - 2 * _REACH
    found = np.zeros((*values.shape[:-1], length))
    for i, weight in enumerate(weights):
        if weight:
            found += weight * values[..., i : i + length]
    return found
