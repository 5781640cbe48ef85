"""Zero-phase filtering of positions and forces, and the derivatives of the positions.

Position and force pass the same filter. Since the filter is linear, mass, damping and friction relate the
filtered signals exactly as the raw ones, and the filter brings no bias: parallel filtering, as in robot
identification (Gautier 1997, Swevers et al. 1997).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._quantities import format_count, format_number, format_time
from telespring._types import FloatArray
from telespring.identification.cutoff import FILTER_ORDER, LARGEST_CUTOFF_SHARE, filtered_noise
from telespring.identification.stretches import Stretch

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = ["STRIBECK_VELOCITIES", "Signals", "filter_stretches", "join_signals"]

#: Velocities, m/s, within which stiction decays to Coulomb friction: a factor of two from one to the next.
STRIBECK_VELOCITIES = (0.005, 0.01, 0.02, 0.04, 0.08)

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
#: A sample is left out where interpolated values contribute more than this share to it.
_MISSING_SHARE = 0.1
#: Below this share of its peak velocity an axis counts as at rest and may stick.
_REST_VELOCITY = 0.02

# Central differences of sixth order: at a tenth of the sample rate the first errs by 0.04 %.
_FIRST_DERIVATIVE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_SECOND_DERIVATIVE = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
_STENCIL_REACH = 3


@dataclass(frozen=True)
class Signals:
    """Filtered stretches of a log, decimated to the rate that their bandwidth needs.

    Attributes
    ----------
    time
        s, shape (n,).
    position, velocity, acceleration, jerk
        m, m/s, m/s² and m/s³, shape (axes, n).
    force
        N, of the same shape.
    direction
        The sign of the velocity, passed through the same filter. The sign is that of a velocity at up to ten
        times the cut-off: at a reversal friction makes the acceleration jump, and a velocity as smooth as
        the other signals would change its sign too early or too late.
    drag
        The velocity times its magnitude, m²/s², filtered alike.
    stiction
        sign v · exp(−(v/v_s)²) for each velocity v_s of `STRIBECK_VELOCITIES`, filtered alike; shape
        (velocities, axes, n).
    breakaway
        Near rest the sign of the velocity after it, elsewhere 0, filtered alike: the friction of an axis that
        sticks, less its Coulomb friction.
    reversal
        Derivative of the direction, 1/s.
    stretch
        Number of the stretch that a sample is from, shape (n,).
    used
        Shape (n,): False where a sample depends on values that were interpolated and not measured.
    cutoff
        Cut-off of the low-pass filter, Hz.
    decimation
        One of so many samples was kept.
    force_curves
        The filtered force of each stretch as a function of time.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray
    force: FloatArray
    direction: FloatArray
    drag: FloatArray
    stiction: FloatArray
    breakaway: FloatArray
    reversal: FloatArray
    stretch: NDArray[np.int_]
    used: NDArray[np.bool_]
    cutoff: float
    decimation: int
    force_curves: tuple[CubicSpline, ...]

    def force_after(self, lags: FloatArray) -> FloatArray:
        """Return the force (N) a lag (s) per axis after each sample, shape (axes, n)."""
        force = np.empty_like(self.force)
        for number, curve in enumerate(self.force_curves):
            inside = self.stretch == number
            for axis, lag in enumerate(lags):
                times = np.clip(self.time[inside] + lag, curve.x[0], curve.x[-1])
                force[axis, inside] = curve(times)[axis]
        return force


def filter_stretches(stretches: Sequence[Stretch], cutoff: float) -> Signals:
    """Filter position and force of every stretch alike, differentiate, trim the ends and decimate.

    At the cut-off (Hz) a fourth-order Butterworth filter, run forwards and backwards, passes half of the
    amplitude. Stretches that are too short for it are left out. InvalidInput where the cut-off does not suit
    the sample rate, or all stretches are too short.
    """
    long_enough = [stretch for stretch in stretches if stretch.time.size > _ends(stretch.rate, cutoff)]
    parts = [_filter_stretch(stretch, cutoff) for stretch in long_enough]
    kept = sum(int(part.used.sum()) for part in parts)
    if kept < _MINIMUM_KEPT:
        _refuse_short_log(stretches, cutoff)
    return join_signals(parts)


def join_signals(parts: Sequence[Signals]) -> Signals:
    """Join signals one after the other; the stretches of each count on from those before."""
    counts = np.cumsum([0, *(len(part.force_curves) for part in parts)])
    arrays: dict[str, Any] = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts], axis=-1)
        for field in fields(Signals)
        if field.name not in ("cutoff", "decimation", "force_curves", "stretch")
    }
    return replace(
        parts[0],
        **arrays,
        stretch=np.concatenate(
            [part.stretch + start for part, start in zip(parts, counts[:-1], strict=True)]
        ),
        force_curves=tuple(curve for part in parts for curve in part.force_curves),
    )


def _ends(rate: float, cutoff: float) -> int:
    """Return how many samples of a stretch the filter's transients at both ends cost."""
    return 2 * math.ceil(_TRANSIENT_PERIODS * rate / cutoff)


def _decimation(rate: float, cutoff: float) -> int:
    """Return of how many samples one is kept."""
    return max(1, int(rate / (_KEPT_PER_PERIOD * cutoff)))


def _refuse_short_log(stretches: Sequence[Stretch], cutoff: float) -> None:
    longest = max(stretches, key=lambda stretch: stretch.time.size)
    decimation = _decimation(longest.rate, cutoff)
    minimum = _ends(longest.rate, cutoff) + _MINIMUM_KEPT * decimation
    samples = format_count(longest.time.size, "sample")
    lost = "" if longest.time.size < minimum else ", most of which depend on missing samples"
    raise InvalidInput(
        "time",
        f"{samples}, {format_time(longest.time.size / longest.rate, 3)}{lost}",
        f"a cut-off of {format_number(cutoff, 3)} Hz needs a log of at least "
        f"{format_time(minimum / longest.rate, 3)} without a gap",
        "Record longer, move faster, or set a higher cut-off.",
    )


def _filter_stretch(stretch: Stretch, cutoff: float) -> Signals:
    from scipy import signal
    from scipy.interpolate import CubicSpline

    rate, position = stretch.rate, stretch.position
    if not 0.0 < cutoff <= LARGEST_CUTOFF_SHARE * rate:
        raise InvalidInput(
            "cutoff",
            f"{format_number(cutoff, 6)} Hz",
            f"the cut-off must be above 0 and at most {LARGEST_CUTOFF_SHARE:g} of the sample rate, here "
            f"{format_number(LARGEST_CUTOFF_SHARE * rate, 6)} Hz",
            "Omit it to have it chosen from the movement.",
        )
    trimmed = _ends(rate, cutoff) // 2
    decimation = _decimation(rate, cutoff)
    sections = signal.butter(FILTER_ORDER, cutoff, fs=rate, output="sos")

    def low_pass(values: FloatArray) -> FloatArray:
        return np.asarray(signal.sosfiltfilt(sections, values, axis=-1))

    smooth = low_pass(position)
    velocity = _apply_stencil(smooth, _FIRST_DERIVATIVE) * rate
    acceleration = _apply_stencil(smooth, _SECOND_DERIVATIVE) * rate**2
    wideband = _wideband_velocity(position, velocity, rate, cutoff)
    is_slow = np.abs(wideband) < _REST_VELOCITY * np.abs(wideband).max(axis=-1, keepdims=True)
    direction = np.sign(wideband)
    stiction = direction * np.stack([np.exp(-((wideband / speed) ** 2)) for speed in STRIBECK_VELOCITIES])
    force = low_pass(stretch.force)
    missing = low_pass((~stretch.usable).astype(float))

    def keep(values: FloatArray, lost: int = _STENCIL_REACH) -> FloatArray:
        """Trim the filter's transients from values that stencils made shorter by `lost` at each end."""
        start = trimmed - lost
        return values[..., start : values.shape[-1] - start : decimation]

    time = keep(stretch.time, 0)
    return Signals(
        time=time,
        position=keep(smooth, 0),
        velocity=keep(velocity),
        acceleration=keep(acceleration),
        jerk=keep(_apply_stencil(acceleration, _FIRST_DERIVATIVE) * rate, 2 * _STENCIL_REACH),
        force=keep(force, 0),
        direction=keep(low_pass(direction)),
        drag=keep(low_pass(wideband * np.abs(wideband))),
        stiction=keep(low_pass(stiction)),
        breakaway=keep(low_pass(_next_direction(wideband, is_slow))),
        reversal=keep(_apply_stencil(low_pass(direction), _FIRST_DERIVATIVE) * rate, 2 * _STENCIL_REACH),
        stretch=np.zeros(time.size, dtype=int),
        used=keep(np.abs(missing), 0) < _MISSING_SHARE,
        cutoff=cutoff,
        decimation=decimation,
        force_curves=(CubicSpline(stretch.time, force, axis=-1),),
    )


def _next_direction(velocity: FloatArray, is_slow: NDArray[np.bool_]) -> FloatArray:
    """Return, near rest, the sign of the velocity after it, and 0 elsewhere."""
    samples = np.arange(velocity.shape[-1])
    rows = []
    for row, slow in zip(np.sign(velocity), is_slow, strict=True):
        moving = np.flatnonzero(~slow)
        following = moving[np.minimum(np.searchsorted(moving, samples), moving.size - 1)]
        rows.append(np.where(slow, row[following], 0.0))
    return np.stack(rows)


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
