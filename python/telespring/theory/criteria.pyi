from typing import TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from telespring._core import Crossing, Dyad, DyadAxis, NoiseFit
from telespring._types import FloatArray, Method, PredictorChoice

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

# numbers give a number; arrays, which broadcast, an array
_N: TypeAlias = float
_A: TypeAlias = ArrayLike

@overload
def critical_stiffness(
    m1: _N, b1: _N, m2: _N, b2: _N, method: Method = "exact", *, kh1: _N = 0.0, kh2: _N = 0.0, c: _N = 0.0
) -> float: ...
@overload
def critical_stiffness(
    m1: _A, b1: _A, m2: _A, b2: _A, method: Method = "exact", *, kh1: _A = 0.0, kh2: _A = 0.0, c: _A = 0.0
) -> float | FloatArray: ...
@overload
def critical_stiffness(m1: Dyad | DyadAxis, method: Method = "exact") -> float: ...
@overload
def maximum_delay(
    m1: _N,
    b1: _N,
    m2: _N,
    b2: _N,
    k: _N,
    method: Method = "exact",
    *,
    kh1: _N = 0.0,
    kh2: _N = 0.0,
    c: _N = 0.0,
    predictor: PredictorChoice = "hold",
) -> float: ...
@overload
def maximum_delay(
    m1: _A,
    b1: _A,
    m2: _A,
    b2: _A,
    k: _A,
    method: Method = "exact",
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> float | FloatArray: ...
@overload
def maximum_delay(
    m1: Dyad | DyadAxis, k: _N, method: Method = "exact", *, predictor: PredictorChoice = "hold"
) -> float: ...
@overload
def maximum_delay(
    m1: Dyad | DyadAxis, k: _A, method: Method = "exact", *, predictor: PredictorChoice = "hold"
) -> float | FloatArray: ...
@overload
def maximum_stiffness(
    m1: _N,
    b1: _N,
    m2: _N,
    b2: _N,
    delay: _N,
    *,
    kh1: _N = 0.0,
    kh2: _N = 0.0,
    c: _N = 0.0,
    predictor: PredictorChoice = "hold",
) -> float: ...
@overload
def maximum_stiffness(
    m1: _A,
    b1: _A,
    m2: _A,
    b2: _A,
    delay: _A,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> float | FloatArray: ...
@overload
def maximum_stiffness(m1: Dyad | DyadAxis, delay: _N, *, predictor: PredictorChoice = "hold") -> float: ...
@overload
def maximum_stiffness(
    m1: Dyad | DyadAxis, delay: _A, *, predictor: PredictorChoice = "hold"
) -> float | FloatArray: ...
@overload
def minimum_damping(
    m1: _N, b1: _N, m2: _N, b2: _N, k: _N, delay: _N, *, kh1: _N = 0.0, kh2: _N = 0.0, c: _N = 0.0
) -> float: ...
@overload
def minimum_damping(
    m1: _A, b1: _A, m2: _A, b2: _A, k: _A, delay: _A, *, kh1: _A = 0.0, kh2: _A = 0.0, c: _A = 0.0
) -> float | FloatArray: ...
@overload
def minimum_damping(m1: Dyad | DyadAxis, k: _N, delay: _N) -> float: ...
@overload
def minimum_damping(m1: Dyad | DyadAxis, k: _A, delay: _A) -> float | FloatArray: ...
@overload
def unstable_root_count(
    m1: _N,
    b1: _N,
    m2: _N,
    b2: _N,
    k: _N,
    delay: _N,
    *,
    kh1: _N = 0.0,
    kh2: _N = 0.0,
    c: _N = 0.0,
    predictor: PredictorChoice = "hold",
) -> int: ...
@overload
def unstable_root_count(
    m1: _A,
    b1: _A,
    m2: _A,
    b2: _A,
    k: _A,
    delay: _A,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> int | NDArray[np.int64]: ...
@overload
def unstable_root_count(
    m1: Dyad | DyadAxis, k: _N, delay: _N, *, predictor: PredictorChoice = "hold"
) -> int: ...
@overload
def unstable_root_count(
    m1: Dyad | DyadAxis, k: _A, delay: _A, *, predictor: PredictorChoice = "hold"
) -> int | NDArray[np.int64]: ...
@overload
def stability_map(
    m1: _N,
    b1: _N,
    m2: _N,
    b2: _N,
    k: _A,
    delay: _A,
    *,
    kh1: _N = 0.0,
    kh2: _N = 0.0,
    c: _N = 0.0,
    predictor: PredictorChoice = "hold",
) -> NDArray[np.bool_]: ...
@overload
def stability_map(
    m1: Dyad | DyadAxis, k: _A, delay: _A, *, predictor: PredictorChoice = "hold"
) -> NDArray[np.bool_]: ...
@overload
def crossings(
    m1: _N, b1: _N, m2: _N, b2: _N, k: _N, *, kh1: _N = 0.0, kh2: _N = 0.0, c: _N = 0.0
) -> list[Crossing]: ...
@overload
def crossings(m1: Dyad | DyadAxis, k: _N) -> list[Crossing]: ...
@overload
def stable_delays(
    m1: _N, b1: _N, m2: _N, b2: _N, k: _N, horizon: _N = 100.0, *, kh1: _N = 0.0, kh2: _N = 0.0, c: _N = 0.0
) -> list[tuple[float, float]]: ...
@overload
def stable_delays(m1: Dyad | DyadAxis, k: _N, horizon: _N = 100.0) -> list[tuple[float, float]]: ...
@overload
def decay_stiffness(
    m1: _N, b1: _N, m2: _N, b2: _N, delay: _N, decay_rate: _N, *, kh1: _N = 0.0, kh2: _N = 0.0, c: _N = 0.0
) -> list[tuple[float, float]]: ...
@overload
def decay_stiffness(m1: Dyad | DyadAxis, delay: _N, decay_rate: _N) -> list[tuple[float, float]]: ...
def fit_noise(times: _A, positions: _A, model: str = "constant-acceleration") -> NoiseFit: ...
