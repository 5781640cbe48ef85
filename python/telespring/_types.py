"""What passes between the public functions and the compiled core."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]
Method: TypeAlias = Literal["exact", "paper"]
GridStatus: TypeAlias = Literal["resolved", "poles on the axis", "too many points"]
NyquistStatus: TypeAlias = Literal["counted", "on the axis", "not counted"]
SimulationStatus: TypeAlias = Literal["completed", "diverged", "not resolved"]
SolverStatus: TypeAlias = Literal[
    "completed", "step too small", "too many steps", "not finite", "invalid delay", "stopped"
]
TraceFormat: TypeAlias = Literal["table", "irtt", "ping"]
TraceDoubt: TypeAlias = Literal["short", "slow", "delays below 1 ms"]
Tier: TypeAlias = Literal[
    "any network", "bounded varying delay", "age in a range", "any constant delay", "constant delay"
]
# "marginal" is stable without the reserve; "not proven" is stable as far as was examined, where something
# that was not examined may decide
Status: TypeAlias = Literal["stable", "marginal", "not proven", "unstable"]
Assumption: TypeAlias = Literal["met", "met behind playout buffer", "not met"]
Unavailable: TypeAlias = Literal[
    "coupling damping with grounded operator",
    "coupling damping with computing time",
    "coupling damping",
    "coupling damping with sampled controllers",
    "not proven over the range",
]
SampledCertificate: TypeAlias = Literal["complete", "upper bound", "incomplete"]
# the word of a predictor, or its settings
PredictorChoice: TypeAlias = str | Mapping[str, Any]
PerAxis: TypeAlias = float | Sequence[float] | FloatArray
# one-way, s: the same each way, or forward and backward, a row of two
Delay: TypeAlias = float | Sequence[float] | FloatArray
# a number, or a function and whether it takes the state as well as the time
DelayValue: TypeAlias = float | tuple[Callable[..., float], bool]


class OptionValues(TypedDict):
    """Tolerances and limits of the adaptive solver."""

    rtol: float | list[float]
    atol: float | list[float]
    max_steps: int
    initial_step: float | None
    max_step: float | None
    breakpoints: list[tuple[float, int]]
