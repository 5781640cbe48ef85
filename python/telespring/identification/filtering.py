"""Zero-phase filtering of positions and forces, and the derivatives of the positions.

Position and force pass the same filter. Since the filter is linear, mass, damping and friction relate the
filtered signals exactly as the raw ones, and the filter brings no bias: parallel filtering, as in robot
identification (Gautier 1997, Swevers et al. 1997).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.cutoff import FILTER_ORDER, LARGEST_CUTOFF_SHARE, filtered_noise

__all__ = ["Signals", "filter_signals"]

#: The filter's transient at the ends of a log decays within this many periods of the cut-off frequency: the
#: slowest pole decays by exp(−2.4 n) over n of them.
_TRANSIENT_PERIODS = 3.0
#: Samples kept per period of the cut-off frequency, a little above the Nyquist rate of 2.
_KEPT_PER_PERIOD = 2.5
#: Below this number of samples the intervals would be guesses.
_MINIMUM_KEPT = 50

#: The sign of the velocity is taken at a cut-off of up to so many times the filter's and up to this share of
#: the sample rate, as long as the noise stays below this share of the velocity's root mean square.
_WIDEBAND_FACTOR, _WIDEBAND_SHARE, _WIDEBAND_NOISE = 10.0, 0.2, 0.005
#: Below this share of its peak velocity an axis counts as at rest and may stick.
_REST_VELOCITY = 0.02

# Central differences of sixth order: at a tenth of the sample rate the first errs by 0.04 %.
_FIRST_DERIVATIVE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_SECOND_DERIVATIVE = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
_STENCIL_REACH = 3


@dataclass(frozen=True)
class Signals:
    """A filtered log, decimated to the rate that its bandwidth needs.

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
    rest
        1 where the axis hardly moves (below 2 % of its peak velocity), 0 elsewhere, passed through the same
        filter.
    cutoff
        Cut-off of the low-pass filter, Hz.
    decimation
        One of so many samples was kept.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray
    force: FloatArray
    direction: FloatArray
    rest: FloatArray
    cutoff: float
    decimation: int


def filter_signals(
    time: FloatArray, position: FloatArray, force: FloatArray, *, rate: float, cutoff: float
) -> Signals:
    """Filter position and force alike, differentiate the position, trim the ends and decimate.

    Parameters
    ----------
    time
        s, shape (n,), evenly spaced.
    position, force
        m and N, time last: shape (..., n). All rows are filtered at once.
    rate
        Samples per second, Hz.
    cutoff
        Cut-off frequency, Hz: there a fourth-order Butterworth filter, run forwards and backwards, passes
        half of the amplitude.

    Raises
    ------
    telespring.InvalidInput
        If the cut-off does not suit the sample rate, or the log is too short for it.
    """
    from scipy import signal

    if not 0.0 < cutoff <= LARGEST_CUTOFF_SHARE * rate:
        raise InvalidInput(
            "cutoff",
            f"{cutoff:g} Hz",
            f"the cut-off must be above 0 and at most {LARGEST_CUTOFF_SHARE:g} of the sample rate, here "
            f"{LARGEST_CUTOFF_SHARE * rate:g} Hz",
            "Omit it to have it chosen from the movement.",
        )
    trimmed = math.ceil(_TRANSIENT_PERIODS * rate / cutoff)
    decimation = max(1, int(rate / (_KEPT_PER_PERIOD * cutoff)))
    minimum = 2 * trimmed + _MINIMUM_KEPT * decimation
    if time.size < minimum:
        raise InvalidInput(
            "time",
            f"{time.size} samples, {time.size / rate:.3g} s",
            f"a cut-off of {cutoff:.3g} Hz needs a log of at least {minimum / rate:.3g} s",
            "Record longer, move faster, or set a higher cut-off.",
        )
    sections = signal.butter(FILTER_ORDER, cutoff, fs=rate, output="sos")

    def low_pass(values: FloatArray) -> FloatArray:
        return np.asarray(signal.sosfiltfilt(sections, values, axis=-1))

    smooth = low_pass(position)
    velocity = _apply_stencil(smooth, _FIRST_DERIVATIVE) * rate
    acceleration = _apply_stencil(smooth, _SECOND_DERIVATIVE) * rate**2
    jerk = _apply_stencil(acceleration, _FIRST_DERIVATIVE) * rate
    wideband = _wideband_velocity(position, velocity, rate, cutoff)
    direction = low_pass(np.sign(wideband))
    is_slow = np.abs(wideband) < _REST_VELOCITY * np.abs(wideband).max(axis=-1, keepdims=True)
    rest = low_pass(is_slow.astype(float))

    def keep(values: FloatArray, lost: int = 0) -> FloatArray:
        """Trim the filter's transients from values that stencils made shorter by `lost` at each end."""
        start = trimmed - lost
        return values[..., start : values.shape[-1] - start : decimation]

    return Signals(
        time=keep(time),
        position=keep(smooth),
        velocity=keep(velocity, _STENCIL_REACH),
        acceleration=keep(acceleration, _STENCIL_REACH),
        jerk=keep(jerk, 2 * _STENCIL_REACH),
        force=keep(low_pass(force)),
        direction=keep(direction, _STENCIL_REACH),
        rest=keep(rest, _STENCIL_REACH),
        cutoff=cutoff,
        decimation=decimation,
    )


def _wideband_velocity(position: FloatArray, velocity: FloatArray, rate: float, cutoff: float) -> FloatArray:
    """Return the velocity (m/s) at the highest cut-off that keeps its noise small, shaped as `velocity`."""
    from scipy import signal

    rows, smooth = position.reshape(-1, position.shape[-1]), velocity.reshape(-1, velocity.shape[-1])
    wideband = np.empty_like(smooth)
    highest = max(cutoff, min(_WIDEBAND_FACTOR * cutoff, _WIDEBAND_SHARE * rate))
    for i, row in enumerate(rows):
        noise = math.sqrt(filtered_noise(row, rate, highest)[0])
        tolerable = _WIDEBAND_NOISE * float(np.sqrt((smooth[i] ** 2).mean()))
        # The deviation of differentiated white noise grows with the power 3/2 of the cut-off.
        used = highest if noise <= tolerable else max(cutoff, highest * (tolerable / noise) ** (2.0 / 3.0))
        sections = signal.butter(FILTER_ORDER, used, fs=rate, output="sos")
        wideband[i] = _apply_stencil(np.asarray(signal.sosfiltfilt(sections, row)), _FIRST_DERIVATIVE) * rate
    return wideband.reshape(velocity.shape)


def _apply_stencil(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Apply a finite-difference stencil along the time; the result is shorter by its reach at both ends."""
    length = values.shape[-1] - 2 * _STENCIL_REACH
    # In this order of summation: twice differentiated, rounding reaches the ninth digit of a lag.
    return np.asarray(sum(w * values[..., i : i + length] for i, w in enumerate(weights) if w))
