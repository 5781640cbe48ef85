"""Stability of two people who each hold a robot, joined by a virtual spring over a network.

Everything public is listed here. All numbers are in SI units: m, s, N, kg, N/m, N·s/m, rad/s.
"""

from telespring._errors import InvalidInput
from telespring.criteria import (
    Crossing,
    critical_stiffness,
    crossings,
    decay_stiffness,
    maximum_delay,
    maximum_stiffness,
    minimum_damping,
    stable_delays,
)
from telespring.dde import DelaySolution, solve_dde
from telespring.model import Dyad, Operator, Robot, hman
from telespring.simulation import Sampled, Signal, Sine, Trajectory, simulate, simulate_array
from telespring.spectrum import (
    CertificateWarning,
    Spectrum,
    certified_roots,
    characteristic_roots,
    spectral_abscissa,
)

__all__ = [
    "CertificateWarning",
    "Crossing",
    "DelaySolution",
    "Dyad",
    "InvalidInput",
    "Operator",
    "Robot",
    "Sampled",
    "Signal",
    "Sine",
    "Spectrum",
    "Trajectory",
    "certified_roots",
    "characteristic_roots",
    "critical_stiffness",
    "crossings",
    "decay_stiffness",
    "hman",
    "maximum_delay",
    "maximum_stiffness",
    "minimum_damping",
    "simulate",
    "simulate_array",
    "solve_dde",
    "spectral_abscissa",
    "stable_delays",
]
