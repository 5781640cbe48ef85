"""Whether what was identified can be right: noise in the regressor, the choice of the cut-off, other units.

Least squares takes velocity and acceleration as exact. Noise in them makes mass and damping too small, by the
noise's share of their power (attenuation, Fuller 1987 [1]_), and the intervals, which see the residuals only,
become the narrower the wronger they are.

References
----------
.. [1] W. A. Fuller, "Measurement Error Models", Wiley (1987), section 1.1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.filtering import Signals, filtered_signals, largest_cutoff, noise_after_filter

if TYPE_CHECKING:
    from telespring.identification.estimation import AxisIdentification, Estimate

__all__ = ["cutoff_warnings", "implausible", "noise_shift"]

#: In half-widths of the interval: a shift by noise of more than the first is told, of more than the second
#: refused, unless it is too little to matter (share of the value).
_TOLD, _REFUSED, _MATTERS = 0.5, 3.0, 0.005
#: At half of the cut-off an estimate may differ by so many half-widths of both intervals together.
_MOVED = 2.0
#: Nobody holds a robot that moves faster, m/s and m/s², or is lighter or heavier, kg.
_FASTEST, _HARDEST, _LIGHTEST, _HEAVIEST = 4.0, 100.0, 0.05, 200.0


def noise_shift(axis: AxisIdentification, signals: Signals, position: FloatArray, rate: float) -> FloatArray:
    """Estimate by how much noise of the position shifts mass and damping, to first order.

    Parameters
    ----------
    axis
        What was identified.
    signals
        The signals it came from.
    position
        The axis' position before the filter, m.
    rate
        Samples per second, Hz.

    Returns
    -------
    ndarray
        kg and N·s/m; below 0 where they are found too small.
    """
    velocity, acceleration = noise_after_filter(position, rate, signals.cutoff)
    regressor = np.stack(
        [signals.acceleration[axis.signals_index], signals.velocity[axis.signals_index]], axis=-1
    )
    noise = np.diag([acceleration, velocity])
    # Of the movement alone, without the noise, but never less than a tenth of what was seen.
    seen = regressor.T @ regressor / len(regressor)
    clean = seen - noise
    if np.linalg.eigvalsh(clean)[0] <= 0.0 or (np.diag(clean) < 0.1 * np.diag(seen)).any():
        clean = np.diag(0.1 * np.diag(seen))
    estimate = np.array([axis.mass.value, axis.damping.value])
    # seen @ estimate is what the force says; without noise it would be clean @ truth.
    return np.asarray(estimate - np.linalg.solve(clean, seen @ estimate))


def cutoff_warnings(
    found: Sequence[AxisIdentification],
    signals: Signals,
    positions: FloatArray,
    rate: float,
    again: Callable[[Signals], Sequence[AxisIdentification]],
    times_and_forces: tuple[FloatArray, FloatArray],
) -> list[str]:
    """Tell where the estimates hang on the cut-off; refuse where noise makes them wrong.

    Parameters
    ----------
    found, signals
        What was identified, and from what.
    positions
        m, shape (axes, n), before the filter.
    rate
        Samples per second, Hz.
    again
        Identifies every axis from other signals.
    times_and_forces
        s, shape (n,), and N, shape (axes, n).

    Returns
    -------
    list of str
        Sentences.

    Raises
    ------
    telespring.InvalidInput
        Where noise of the position shifts an estimate by three half-widths of its interval or more.
    """
    told = []
    good = min(largest_cutoff(row, rate) for row in positions)
    for axis, position in zip(found, positions, strict=True):
        shifts = noise_shift(axis, signals, position, rate)
        for name, shift in zip(("mass", "damping"), shifts, strict=True):
            estimate = axis.estimates[name]
            by = abs(float(shift))
            # The interval of the paper's method means nothing.
            half = _half_width(estimate) if axis.fit.lags is not None else 0.01 * abs(estimate.value)
            if by <= max(_TOLD * half, 1e-12):
                continue
            unit = "kg" if name == "mass" else "N·s/m"
            if by > _REFUSED * half and by > _MATTERS * abs(estimate.value):
                raise InvalidInput(
                    f"cutoff (axis {axis.axis})",
                    f"{signals.cutoff:.4g} Hz",
                    f"at this cut-off the position's noise shifts the {name} by about {by:.2g} {unit}, "
                    f"{by / half:.0f} times what its interval says",
                    f"Give at most {good:.3g} Hz, leave --cutoff away, or move the robot further and faster.",
                )
            told.append(
                f"Axis {axis.axis}: at a cut-off of {signals.cutoff:.3g} Hz the position's noise makes the "
                f"{name} about {by:.2g} {unit} too small, {by / half:.1g} of its interval's half-width. "
                f"Give a --cutoff of {good:.3g} Hz or less."
            )
    return told or _moved(found, signals, positions, rate, again, times_and_forces)


def _moved(
    found: Sequence[AxisIdentification],
    signals: Signals,
    positions: FloatArray,
    rate: float,
    again: Callable[[Signals], Sequence[AxisIdentification]],
    times_and_forces: tuple[FloatArray, FloatArray],
) -> list[str]:
    """Identify at half of the cut-off and compare: where the model holds, the filter changes nothing."""
    times, forces = times_and_forces
    half = 0.5 * signals.cutoff
    if any(axis.fit.lags is None for axis in found):
        return []
    try:
        lower = again(filtered_signals(times, positions, forces, rate=rate, cutoff=half))
    except InvalidInput:
        # The log is too short for it, or what is left of the movement says too little.
        return []
    told = []
    for one, other in zip(found, lower, strict=True):
        for name in ("mass", "damping"):
            mine, theirs = one.estimates[name], other.estimates[name]
            by = abs(mine.value - theirs.value)
            widths = np.hypot(_half_width(mine), _half_width(theirs))
            if by > max(_MOVED * widths, 0.01 * abs(mine.value)):
                unit = "kg" if name == "mass" else "N·s/m"
                told.append(
                    f"Axis {one.axis}: the {name} hangs on the cut-off: {mine.value:.3g} {unit} at "
                    f"{signals.cutoff:.3g} Hz and {theirs.value:.3g} {unit} at {half:.3g} Hz, further apart "
                    "than their intervals say. Look whether the position jumps, whether friction is "
                    "missing, and at the residuals."
                )
    return told


def _half_width(estimate: Estimate) -> float:
    return 0.5 * (estimate.interval[1] - estimate.interval[0])


def implausible(found: Sequence[AxisIdentification], signals: Signals) -> list[str]:
    """Tell what no robot that a person holds does or is: probably other units.

    Parameters
    ----------
    found, signals
        What was identified, and from what.

    Returns
    -------
    list of str
        Sentences.
    """
    told = []
    for axis in found:
        speed = float(np.abs(signals.velocity[axis.signals_index]).max())
        hard = float(np.abs(signals.acceleration[axis.signals_index]).max())
        if speed > _FASTEST or hard > _HARDEST:
            told.append(
                f"Axis {axis.axis} moves at {speed:.3g} m/s and {hard:.3g} m/s², more than a robot that a "
                "person holds. Is the time in s (--time-scale 60 for minutes) and the position in m "
                "(--position-scale 0.001 for mm, 0.01 for cm)?"
            )
        if abs(axis.mass.value) < _LIGHTEST:
            told.append(
                f"Axis {axis.axis}: {axis.mass.value:.2g} kg is lighter than any robot that a person holds. "
                "Are time, position and force in s, m and N (--time-scale, --position-scale, --force-scale)?"
            )
        if abs(axis.mass.value) > _HEAVIEST:
            told.append(
                f"Axis {axis.axis}: {axis.mass.value:.3g} kg is heavier than any robot that a person holds. "
                "Are time, position and force in s, m and N (--force-scale 0.001 for mN)?"
            )
    return told
