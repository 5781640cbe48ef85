"""Equivalent gains of a saturation and of Coulomb friction for a sine and Gaussian noise together.

The gains of the random-input describing function: a nonlinear element is replaced by one gain for the sine
and one for the noise, those that minimise the mean square of what is left out (Gelb and Vander Velde,
*Multiple-Input Describing Functions and Nonlinear System Design*, McGraw-Hill 1968, chapters 5 and 6).
"""

from __future__ import annotations

import numpy as np

from telespring._types import FloatArray

__all__ = ["friction_gains", "saturation_gains"]

#: Phases of the sine at which the mean over the noise is taken, over a quarter of a period: the elements
#: are odd.
_PHASES = (np.arange(16) + 0.5) * (np.pi / 32)
_SINE: FloatArray = np.sin(_PHASES)
#: Less noise than this share of the limit or of the speed counts as this share: nothing is divided by 0.
_LEAST_NOISE = 1e-3


def saturation_gains(amplitude: FloatArray, deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the gains of a unit slope that ends at ±1, for the sine and for the noise.

    A dead band has 1 less these gains.

    Examples
    --------
    >>> [round(float(gain[0]), 3) for gain in saturation_gains(np.array([0.0]), np.array([1.0]))]
    [0.683, 0.683]
    """
    from scipy.special import ndtr

    amplitude = np.asarray(amplitude)
    deviation = np.maximum(np.asarray(deviation)[..., None], _LEAST_NOISE)
    mean = amplitude[..., None] * _SINE
    above, below = (1.0 - mean) / deviation, (-1.0 - mean) / deviation
    up_to_top, up_to_bottom = ndtr(above), ndtr(below)
    inside = up_to_top - up_to_bottom
    # E[sat(m + r)]: m inside the limits, the limits outside, and the slope's share of the tails
    output = (
        mean * inside
        + (1.0 - up_to_top - up_to_bottom)
        + deviation * (_normal_density(below) - _normal_density(above))
    )
    noise = inside.mean(axis=-1)
    sine = 2.0 * (output @ _SINE) / len(_SINE) / np.maximum(amplitude, _LEAST_NOISE)
    return np.where(amplitude > _LEAST_NOISE, sine, noise), np.asarray(noise)


def friction_gains(
    amplitude: FloatArray, deviation: FloatArray, force: FloatArray | float
) -> tuple[FloatArray, FloatArray]:
    """Return the equivalent dampings of Coulomb friction `force`, N, at a sine and noise of velocity, m/s.

    Examples
    --------
    >>> round(float(friction_gains(np.array([0.0]), np.array([0.5]), 1.0)[1][0]), 3)  # √(2/π)/0.5
    1.596
    """
    from scipy.special import erf

    amplitude, deviation = np.asarray(amplitude), np.asarray(deviation)
    least = _LEAST_NOISE * np.maximum(np.hypot(amplitude, deviation), 1e-9)
    amplitude, deviation = np.maximum(amplitude, least), np.maximum(deviation, least)
    mean = (amplitude / deviation)[..., None] * _SINE
    sine = 2.0 * (erf(mean / np.sqrt(2.0)) @ _SINE) / len(_SINE) / amplitude
    noise = 2.0 * _normal_density(mean).mean(axis=-1) / deviation
    return np.asarray(force * sine), np.asarray(force * noise)


def _normal_density(value: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-0.5 * value**2) / np.sqrt(2.0 * np.pi))
