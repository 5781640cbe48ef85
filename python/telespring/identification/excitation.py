"""Periodic movements that excite a robot for identification: the paper's, and designed ones.

A movement is a Fourier series of the velocity. Position and acceleration follow in closed form, so no command
is differentiated or integrated numerically.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from telespring._arrays import as_number, as_numbers, as_vector
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.regression import regressor_matrix

__all__ = [
    "PAPER_AMPLITUDES",
    "PAPER_ANGULAR_FREQUENCY",
    "Excitation",
    "Extremes",
    "design_excitation",
    "paper_excitation",
]

#: Appendix B: A and B of the five harmonics, m/s.
PAPER_AMPLITUDES = (0.01, 0.02, 0.05, 0.1, 0.15)

#: Base frequency, rad/s (0.2 Hz). The paper prints none. With its A and B the position reaches at most
#: 0.1249 m/ω for ω in rad/s; 0.2 Hz is the lowest tenth of a hertz at which that stays within ±0.1 m, the
#: amplitude B of Eq. 12 that the paper's robots are known to travel. Lower frequencies leave this range,
#: higher ones travel less and need more acceleration.
PAPER_ANGULAR_FREQUENCY = 0.4 * math.pi

#: Points over a period at which extremes and regressors are evaluated, per harmonic.
_POINTS_PER_HARMONIC = 64


class Extremes(NamedTuple):
    """Peak magnitudes of a movement over one period.

    Attributes
    ----------
    position : float
        m, from the mean over a period.
    velocity : float
        m/s.
    acceleration : float
        m/s².
    """

    position: float
    velocity: float
    acceleration: float


@dataclass(frozen=True)
class Excitation:
    """A periodic excitation movement, given by the Fourier series of its velocity.

    v(t) = Σ A_i cos(iωt) + B_i sin(iωt), as in Appendix B of the paper, after Swevers et al. [1]_.

    Parameters
    ----------
    cosine, sine
        A_i and B_i of the harmonics i = 1 … N, m/s.
    angular_frequency
        ω, rad/s; the movement repeats every 2π/ω.

    References
    ----------
    .. [1] J. Swevers et al., "Optimal robot excitation and identification", IEEE Transactions on Robotics
       and Automation 13 (1997) 730-740.

    Examples
    --------
    >>> movement = Excitation([0.1], [0.0], angular_frequency=2.0)
    >>> float(movement.position(0.0)), float(movement.acceleration(0.0))
    (0.0, 0.0)
    >>> movement.extremes().position  # 0.1/2 m
    0.05
    """

    cosine: tuple[float, ...]
    sine: tuple[float, ...]
    angular_frequency: float

    def __init__(
        self, cosine: ArrayLike, sine: ArrayLike, angular_frequency: float = PAPER_ANGULAR_FREQUENCY
    ) -> None:
        a, b = as_vector("cosine", cosine), as_vector("sine", sine)
        if a.size != b.size or a.size == 0 or not (np.isfinite(a).all() and np.isfinite(b).all()):
            raise InvalidInput(
                "cosine, sine",
                f"{a.size} and {b.size} values",
                "cosines and sines need the same number of finite amplitudes, in m/s",
                "Give one of each per harmonic, and 0 for a missing term.",
            )
        frequency = as_number("angular_frequency", angular_frequency)
        if not 0.0 < frequency < math.inf:
            raise InvalidInput(
                "angular_frequency",
                f"{frequency:g}",
                "the base frequency must be above 0 rad/s",
                "Omit it for 1.257 rad/s (0.2 Hz).",
            )
        object.__setattr__(self, "cosine", tuple(a.tolist()))
        object.__setattr__(self, "sine", tuple(b.tolist()))
        object.__setattr__(self, "angular_frequency", frequency)

    @property
    def period(self) -> float:
        """2π/ω, s."""
        return 2.0 * math.pi / self.angular_frequency

    @property
    def highest_frequency(self) -> float:
        """Frequency of the highest harmonic with an amplitude above 0, Hz."""
        present = [i + 1 for i in range(len(self.cosine)) if self.cosine[i] or self.sine[i]]
        return max(present, default=1) / self.period

    def position(self, time: ArrayLike) -> FloatArray:
        """Return the position at each time (s), m; its mean over a period is 0."""
        return self._series(time, -1)

    def velocity(self, time: ArrayLike) -> FloatArray:
        """Return the velocity at each time (s), m/s."""
        return self._series(time, 0)

    def acceleration(self, time: ArrayLike) -> FloatArray:
        """Return the acceleration at each time (s), m/s²."""
        return self._series(time, 1)

    def _series(self, time: ArrayLike, order: int) -> FloatArray:
        """Return the derivative of this order of the velocity; order −1 is the position."""
        t = as_numbers("time", time)
        # One complex sum: A cos + B sin is the real part of (A − jB) e^(jiωt).
        frequency = self.angular_frequency * np.arange(1, len(self.cosine) + 1)
        amplitude = (np.array(self.cosine) - 1j * np.array(self.sine)) * (1j * frequency) ** order
        series = np.exp(1j * np.multiply.outer(t, frequency)) @ amplitude
        return np.asarray(series).real.astype(np.float64)

    def extremes(self) -> Extremes:
        """Return the peak magnitudes of position, velocity and acceleration."""
        time = self._grid(64 * _POINTS_PER_HARMONIC)
        return Extremes(
            *(
                float(np.abs(values).max())
                for values in (self.position(time), self.velocity(time), self.acceleration(time))
            )
        )

    def regressor(self, *, coulomb: bool = False, offset: bool = False) -> FloatArray:
        """Return the columns [a, v, sign v, 1] over one period in SI units, the last two optionally."""
        time = self._grid(_POINTS_PER_HARMONIC * len(self.cosine))
        velocity = self.velocity(time)
        direction = np.sign(velocity) if coulomb else None
        return regressor_matrix(self.acceleration(time), velocity, direction, offset=offset)

    def condition_number(
        self,
        *,
        coulomb: bool = False,
        offset: bool = False,
        velocity_scale: float = 1.0,
        acceleration_scale: float = 1.0,
    ) -> float:
        """Return the condition number of the regressor over one period.

        Parameters
        ----------
        coulomb, offset
            Whether it has the columns sign v and 1.
        velocity_scale, acceleration_scale
            Units of v (in m/s) and a (in m/s²); by default SI units.
        """
        columns = self.regressor(coulomb=coulomb, offset=offset)
        columns[:, 0] /= acceleration_scale
        columns[:, 1] /= velocity_scale
        return float(np.linalg.cond(columns))

    def _grid(self, points: int) -> FloatArray:
        return np.arange(points, dtype=np.float64) * (self.period / points)

    def _scaled(self, factor: float) -> Excitation:
        return Excitation(
            factor * np.array(self.cosine), factor * np.array(self.sine), self.angular_frequency
        )


def paper_excitation(angular_frequency: float = PAPER_ANGULAR_FREQUENCY) -> Excitation:
    """Return the paper's velocity command (Appendix B): five harmonics with equal A and B.

    Parameters
    ----------
    angular_frequency : float
        ω, rad/s. The paper prints none; at the default, 0.2 Hz, the movement just fits into ±0.1 m, the
        travel of the paper's task.

    Returns
    -------
    Excitation
        The movement of one axis.

    Examples
    --------
    >>> position, velocity, acceleration = paper_excitation().extremes()
    >>> f"{position:.4f} m, {velocity:.4f} m/s, {acceleration:.4f} m/s²"
    '0.0994 m, 0.4578 m/s, 2.3725 m/s²'
    """
    return Excitation(PAPER_AMPLITUDES, PAPER_AMPLITUDES, angular_frequency)


def design_excitation(
    position_limit: float = 0.1,
    velocity_limit: float = 0.5,
    acceleration_limit: float = 2.5,
    *,
    harmonics: int = 5,
    angular_frequency: float = PAPER_ANGULAR_FREQUENCY,
    coulomb: bool = True,
    offset: bool = True,
    starts: int = 6,
    seed: int = 1,
) -> Excitation:
    """Design a movement within limits whose regressor has the smallest condition number.

    The objective is the condition number of [a, v, sign v, 1] with a and v in units of their limits: in SI
    units it would depend on the choice of units, and for [a, v] alone it would favour slow movements. The
    movement is as large as the limits allow, which is best for the precision. With five harmonics or more its
    condition number in SI units, too, does not exceed that of the paper's movement scaled to the same limits;
    with fewer harmonics it may.

    Parameters
    ----------
    position_limit : float
        Largest distance from the centre, m.
    velocity_limit : float
        Largest velocity, m/s.
    acceleration_limit : float
        Largest acceleration, m/s².
    harmonics : int
        Number N of harmonics, 1 to 20; the paper's movement has 5.
    angular_frequency : float
        Base frequency ω, rad/s.
    coulomb : bool
        Whether Coulomb friction will be estimated (column sign v).
    offset : bool
        Whether an offset will be estimated (column 1).
    starts : int
        Number of random starts of the search, besides the paper's movement.
    seed : int
        Seed of the random starts: the same seed gives the same movement.

    Returns
    -------
    Excitation
        The best movement found.

    Raises
    ------
    telespring.InvalidInput
        If a limit is not positive.

    Examples
    --------
    >>> better = design_excitation(starts=1)
    >>> paper = paper_excitation()
    >>> kinds = {"coulomb": True, "offset": True}
    >>> better.condition_number(**kinds) < paper.condition_number(**kinds)
    True
    """
    from scipy.optimize import minimize

    limits = Extremes(
        _positive_movement_limit("position_limit", position_limit, "m"),
        _positive_movement_limit("velocity_limit", velocity_limit, "m/s"),
        _positive_movement_limit("acceleration_limit", acceleration_limit, "m/s²"),
    )
    if not 1 <= harmonics <= 20:
        raise InvalidInput("harmonics", str(harmonics), "1 to 20 harmonics are allowed", "Omit it for 5.")
    problem = _ExcitationDesignProblem(limits, harmonics, angular_frequency, coulomb, offset)
    first = np.zeros((2, harmonics))
    # With fewer harmonics than the paper's, start from its highest amplitudes, which dominate the movement.
    count = min(harmonics, len(PAPER_AMPLITUDES))
    first[:, :count] = PAPER_AMPLITUDES[-count:]
    random = np.random.default_rng(seed)
    order = np.tile(np.arange(1, harmonics + 1), 2)
    initial = [first.ravel(), *(random.normal(size=2 * harmonics) / order for _ in range(starts))]
    candidates = [first.ravel()]
    for start in initial:
        # Without derivatives: the sign of the velocity makes the objective piecewise constant in places.
        optimum = minimize(
            problem.objective,
            start / np.linalg.norm(start),
            method="Powell",
            options={"maxiter": 12, "xtol": 1e-3},
        )
        candidates.append(np.asarray(optimum.x))
    best = min(candidates, key=problem.objective)
    cosine, sine = best.reshape(2, harmonics)
    return _scale_movement_to_limits(Excitation(cosine, sine, angular_frequency), limits)


def _scale_movement_to_limits(movement: Excitation, limits: Extremes) -> Excitation:
    """Scale a movement until it reaches the first of the limits."""
    size = max(peak / limit for peak, limit in zip(movement.extremes(), limits, strict=True))
    # Between the points of a grid the peak may be this little larger.
    return movement._scaled((1.0 - 1e-5) / size)


def _positive_movement_limit(name: str, value: float, unit: str) -> float:
    number = as_number(name, value)
    if not 0.0 < number < math.inf:
        raise InvalidInput(
            name, f"{number:g}", f"a limit must be above 0 {unit}", "Set it to what the robot can do safely."
        )
    return number


class _ExcitationDesignProblem:
    """Condition number of a movement as a function of its amplitudes, which are scaled to the limits."""

    def __init__(
        self, limits: Extremes, harmonics: int, angular_frequency: float, coulomb: bool, offset: bool
    ) -> None:
        self.limits = limits
        self.coulomb, self.offset = coulomb, offset
        paper = _scale_movement_to_limits(paper_excitation(angular_frequency), limits)
        self.paper_condition = paper.condition_number(coulomb=coulomb, offset=offset)
        order = np.arange(1, harmonics + 1)
        points = 48 * harmonics
        angle = np.multiply.outer(2.0 * np.pi * np.arange(points) / points, order)
        frequency = angular_frequency * order
        cosine, sine = np.cos(angle), np.sin(angle)
        self._velocity = np.hstack([cosine, sine])
        self._position = np.hstack([sine / frequency, -cosine / frequency])
        self._acceleration = np.hstack([-sine * frequency, cosine * frequency])

    def objective(self, amplitudes: FloatArray) -> float:
        p, v, a = (matrix @ amplitudes for matrix in (self._position, self._velocity, self._acceleration))
        size = max(
            float(np.abs(values).max()) / limit for values, limit in zip((p, v, a), self.limits, strict=True)
        )
        if not 0.0 < size < math.inf:
            return math.inf
        columns = regressor_matrix(
            a / size, v / size, np.sign(v / size) if self.coulomb else None, offset=self.offset
        )
        condition_si = _condition_by_gram_matrix(columns)
        columns[:, 0] /= self.limits.acceleration
        columns[:, 1] /= self.limits.velocity
        # A movement with a larger condition number in SI units than the paper's is penalised heavily.
        penalty = 1.0 + 100.0 * max(0.0, condition_si / self.paper_condition - 1.0)
        return _condition_by_gram_matrix(columns) * penalty


def _condition_by_gram_matrix(columns: FloatArray) -> float:
    # Ten times as fast as from the columns themselves, and exact enough for comparisons.
    eigenvalues = np.linalg.eigvalsh(columns.T @ columns)
    return math.sqrt(float(eigenvalues[-1]) / max(float(eigenvalues[0]), 1e-30))
