"""Stability criteria of one axis, or of all axes of a dyad.

Every function takes the axis as numbers in SI units: masses `m1`, `m2` (kg) and viscous dampings `b1`, `b2`
(N·s/m) of robot and operator together, and as keywords what ties the handles to the ground, `kh1` and `kh2`
(N/m), and a damper in parallel with the virtual spring, `c` (N·s/m). A `Dyad` or a `DyadAxis` as the first
argument replaces these seven numbers. Delays are one-way, the mean if both ways differ. Functions that return
one number per axis broadcast over arrays.
"""

from telespring._core import (
    Crossing,
    NoiseFit,
    critical_stiffness,
    crossings,
    decay_stiffness,
    fit_noise,
    maximum_delay,
    maximum_stiffness,
    minimum_damping,
    stability_map,
    stable_delays,
    unstable_root_count,
)

__all__ = [
    "Crossing",
    "NoiseFit",
    "critical_stiffness",
    "crossings",
    "decay_stiffness",
    "fit_noise",
    "maximum_delay",
    "maximum_stiffness",
    "minimum_damping",
    "stability_map",
    "stable_delays",
    "unstable_root_count",
]
