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

__all__ = [
    "CUTOFF_RULE",
    "Signals",
    "choose_cutoff",
    "filtered_signals",
    "largest_cutoff",
    "movement_bandwidth",
    "noise_after_filter",
    "noise_deviation",
]

#: How `choose_cutoff` finds the cut-off, for people.
CUTOFF_RULE = (
    "5 times the frequency below which 99.9 % of the power of the velocity lies, counted where the "
    "spectrum of the position stands above its noise, but no higher than where that noise makes up "
    "0.001 % of the acceleration's power"
)
_POWER_BELOW = 0.999
_TIMES_BANDWIDTH = 5.0
#: Odds that noise alone counts as movement anywhere in the spectrum.
_BY_CHANCE = 1e-3
#: Noise in the acceleration makes the mass too small by its share of the acceleration's power. At this share
#: that is a small part of any interval: a mass known within 0.02 % is shifted by a twentieth of that.
_NOISE_SHARE = 1e-5
#: No movement of a robot reaches this frequency, Hz, nor this share of the sample rate.
_NO_MOVEMENT, _NO_MOVEMENT_SHARE = 60.0, 1.0 / 32.0
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

#: The sign of the velocity is taken at up to so many times the cut-off and this share of the sample rate, as
#: long as the velocity's noise stays below this share of its root mean square.
_BRISK, _BRISK_SHARE, _BRISK_NOISE = 10.0, 0.2, 0.005
#: Below this share of its highest velocity an axis hardly moves, and may stick.
_SLOW = 0.02

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
        The sign of the velocity, passed through the same filter. The sign is that of a velocity at up to ten
        times the cut-off: at a reversal friction makes the acceleration jump, and a velocity as smooth as
        the other signals would change its sign too early or too late.
    standing
        1 where the axis hardly moves (below 2 % of its highest velocity), 0 elsewhere, passed through the
        same filter.
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
    standing: FloatArray
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
    frequency, power, floor = _spectrum(position, rate)
    # A periodogram's noise is exponentially distributed: so far above its mean no bin lies by chance.
    above = floor * math.log(frequency.size / _BY_CHANCE)
    velocity = np.where(power > above, power, 0.0) * frequency**2
    total = float(velocity.sum())
    if total == 0.0:
        return float(frequency[1])
    below = np.cumsum(velocity) / total
    return float(frequency[max(1, int(np.searchsorted(below, _POWER_BELOW)))])


def largest_cutoff(position: FloatArray, rate: float) -> float:
    """Find the cut-off, Hz, up to which noise of the position makes up 0.001 % of the acceleration's power.

    Noise in the regressor makes the mass too small, and however long the log is, no interval shows it. What
    noise there is grows with the fifth power of the cut-off, so that this is a sharp limit.

    Parameters
    ----------
    position
        m, shape (n,).
    rate
        Samples per second, Hz.

    Returns
    -------
    float
        Hz; the resolution of the spectrum where already the movement itself has more noise.

    Examples
    --------
    A tenth of a millimetre of noise, and a hundredth:

    >>> time = np.arange(20000) / 1000.0
    >>> noise = np.random.default_rng(1).normal(size=time.size)
    >>> movement = 0.1 * np.sin(2 * np.pi * 0.5 * time)
    >>> [round(largest_cutoff(movement + size * noise, 1000.0)) for size in (1e-4, 1e-5)]
    [4, 10]
    """
    frequency, power, floor = _spectrum(position, rate)
    noise = floor * np.cumsum(frequency**4)
    low = np.flatnonzero(noise[1:] <= _NOISE_SHARE * np.cumsum(power * frequency**4)[1:])
    return float(frequency[1 + low[-1]]) if low.size else float(frequency[1])


def noise_after_filter(position: FloatArray, rate: float, cutoff: float) -> tuple[float, float]:
    """Tell how much noise of the position is left in velocity and acceleration.

    Parameters
    ----------
    position
        m, shape (n,).
    rate
        Samples per second, Hz.
    cutoff
        Of the filter, Hz.

    Returns
    -------
    velocity, acceleration
        Variances, (m/s)² and (m/s²)².
    """
    frequency, _, floor = _spectrum(position, rate)
    # Twice through the filter: its power squared is what passes.
    passed = floor / (1.0 + (frequency / cutoff) ** (2 * _ORDER)) ** 2
    angular = 2.0 * np.pi * frequency
    return float((passed * angular**2).sum()), float((passed * angular**4).sum())


def noise_deviation(position: FloatArray, rate: float) -> float:
    """Tell the standard deviation of the noise on a position, m.

    Parameters
    ----------
    position
        m, shape (n,).
    rate
        Samples per second, Hz.
    """
    frequency, _, floor = _spectrum(position, rate)
    return math.sqrt(floor * frequency.size)


def _spectrum(position: FloatArray, rate: float) -> tuple[FloatArray, FloatArray, float]:
    """Give frequencies, Hz, the position's power in each bin, m², and the noise's share of a bin, m²."""
    from scipy import fft, signal

    samples = position.size
    length = fft.next_fast_len(samples, real=True)
    window = signal.get_window("hann", samples)
    power = np.abs(fft.rfft(signal.detrend(position) * window, length)) ** 2
    # The sum over the bins is the mean square of the position.
    power *= 2.0 / (length * float((window**2).sum()))
    frequency = np.asarray(fft.rfftfreq(length, 1.0 / rate))
    # The upper half of the spectrum of any movement that one would sample at this rate is noise. Its mean,
    # not its median: the noise of an encoder on a periodic movement is made of lines. Where a filter before
    # the recorder has emptied that half, the octaves below tell, down to where a movement may reach.
    lowest = max(_NO_MOVEMENT, _NO_MOVEMENT_SHARE * rate)
    top = frequency.size // 2
    floor = float(power[top:].mean())
    while frequency[top // 2] >= lowest:
        floor = max(floor, float(power[top // 2 : top].mean()))
        top //= 2
    return frequency, power, floor


def choose_cutoff(position: FloatArray, rate: float) -> float:
    """Choose the cut-off of the filter from the movement itself (`CUTOFF_RULE`).

    Parameters
    ----------
    position
        m, shape (n,), or (axes, n): then the axis that moves fastest decides, up to what the noisiest bears.
        (Too low a cut-off costs precision, too high a one truth.)
    rate
        Samples per second, Hz.

    Returns
    -------
    float
        Hz, at most 0.4 of the sample rate.
    """
    rows = np.atleast_2d(position)
    bearable = [largest_cutoff(row, rate) for row in rows]
    wanted = max(
        min(_TIMES_BANDWIDTH * movement_bandwidth(row, rate), limit)
        for row, limit in zip(rows, bearable, strict=True)
    )
    return min(wanted, *bearable, _LARGEST_SHARE * rate)


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
    brisk = _brisk_velocity(position, velocity, rate, cutoff)
    direction = low_pass(np.sign(brisk))
    slow = np.abs(brisk) < _SLOW * np.abs(brisk).max(axis=-1, keepdims=True)
    standing = low_pass(slow.astype(float))

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
        standing=kept(standing, _REACH),
        cutoff=cutoff,
        decimation=decimation,
    )


def _brisk_velocity(position: FloatArray, velocity: FloatArray, rate: float, cutoff: float) -> FloatArray:
    """Give the velocity at the highest cut-off that leaves it little noise, in m/s, as long as `velocity`."""
    from scipy import signal

    rows, slow = position.reshape(-1, position.shape[-1]), velocity.reshape(-1, velocity.shape[-1])
    found = np.empty_like(slow)
    highest = max(cutoff, min(_BRISK * cutoff, _BRISK_SHARE * rate))
    for i, row in enumerate(rows):
        noise = math.sqrt(noise_after_filter(row, rate, highest)[0])
        bearable = _BRISK_NOISE * float(np.sqrt((slow[i] ** 2).mean()))
        # The deviation of white noise after a difference grows with the power 3/2 of the cut-off.
        used = highest if noise <= bearable else max(cutoff, highest * (bearable / noise) ** (2.0 / 3.0))
        sections = signal.butter(_ORDER, used, fs=rate, output="sos")
        found[i] = _difference(np.asarray(signal.sosfiltfilt(sections, row)), _FIRST) * rate
    return found.reshape(velocity.shape)


def _difference(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weigh each sample's neighbours; the result is shorter by the reach at both ends."""
    length = values.shape[-1] - 2 * _REACH
    found = np.zeros((*values.shape[:-1], length))
    for i, weight in enumerate(weights):
        if weight:
            found += weight * values[..., i : i + length]
    return found
