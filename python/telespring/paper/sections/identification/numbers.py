"""Identification as a study shows it: both robots on the simulated rig, and what it does to the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._json import finite_or_none
from telespring.decision.uncertainty import delta_method, margin_uncertainty, stable_probability
from telespring.identification.estimation import Identification, identify
from telespring.identification.excitation import Excitation, design_excitation, paper_excitation
from telespring.identification.regression import paper_reweightings
from telespring.identification.simulated_logs import ARM, Noise, RigLog, rig_log
from telespring.model import Dyad, Robot, Study, Uncertainty
from telespring.paper.reference import Reference, reference_of

if TYPE_CHECKING:
    from telespring._types import FloatArray

__all__ = ["IdentificationStudy", "study_identification"]

#: Of the logs' noise; fixed, so that the same study gives the same numbers.
_SEED = 20251122

#: In multiples of K_xy and Δ_xy: the paper's 16 conditions.
_STIFFNESS_FACTORS = (0.5, 1.0, 2.0, 4.0)
_DELAY_FACTORS = (0.0, 0.5, 1.0, 2.0)

#: Of the Monte Carlo behind each probability.
_DRAWS = 5000

#: After so many reweightings of the paper's method one looks; it prints one step and no number.
_REWEIGHTINGS = (0, 1, 5, 30, 100)

#: An estimate below it, kg or N·s/m, is no robot's: it is too light or too little damped for the sensors.
_LEAST = 1e-4


@dataclass(frozen=True)
class IdentificationStudy:
    """Numbers of an identification, and what its figures are drawn from.

    Attributes
    ----------
    numbers
        Plain values in SI units, as JSON has them: ``excitation``, ``noise``, ``arm``, ``axes`` (per robot
        and axis, measured at the handle, beside what the robot is), ``methods``, ``reweightings``,
        ``axes_independent``, ``seed`` and ``verdict``.
    movements
        Name and movement: the paper's command and the designed one (Fig. 9).
    robots
        Identification at the handle of both robots (Fig. 10).
    """

    numbers: dict[str, Any]
    movements: tuple[tuple[str, Excitation], ...]
    robots: tuple[Identification, Identification]


def study_identification(study: Study | None = None, seed: int = _SEED) -> IdentificationStudy:
    """Identify a study's bare robots from noisy logs of the simulated rig and carry the errors on.

    Parameters
    ----------
    study
        The robots, friction included; the paper's unless given.
    seed
        Of the sensors' noise.

    Returns
    -------
    IdentificationStudy
        Numbers, movements and identifications. The same input gives the same output.
    """
    source = Study.paper() if study is None else study
    dyad = source.dyad
    movement, designed = paper_excitation(), _designed()
    log = rig_log(source, movement)
    random = np.random.default_rng(seed)
    measured = {at: log.measured(random, at=at) for at in ("handle", "joints")}
    friction = source.coulomb

    def estimate(at: str, method: Any) -> tuple[Identification, Identification]:
        one, other = (
            _estimate(log, measured[at], robot, list(dyad.axes), method, coulomb=bool(friction.any()))
            for robot in (0, 1)
        )
        return one, other

    robots = estimate("handle", "robust")
    compared = (
        ("robust", "handle", robots),
        ("least squares", "handle", estimate("handle", "ols")),
        ("the paper's", "handle", estimate("handle", "paper")),
        ("robust", "joints", estimate("joints", "robust")),
    )
    numbers = {
        "excitation": {
            "harmonics": len(movement.cosine),
            "base_frequency": movement.angular_frequency,
            "duration": float(log.time[-1]),
            "sample_rate": robots[0].rate,
            "cutoff": robots[0].cutoff,
            "condition_number": movement.condition_number(),
            "condition_number_designed": designed.condition_number(),
            "paper": _movement(movement),
            "designed": _movement(designed),
        },
        "noise": vars(Noise()),
        "arm": ARM if len(dyad.axes) == 2 else None,
        "axes": [
            {
                "robot": robot + 1,
                **axis,
                "mass_given": float(dyad.robots[robot].mass[i]),
                "damping_given": float(dyad.robots[robot].damping[i]),
                "coulomb_given": float(friction[robot, i]),
            }
            for robot, found in enumerate(robots)
            for i, axis in enumerate(found.to_json()["axes"])
        ],
        "methods": [
            {"method": method, "force": at, "robot": robot, **{key: axis[key] for key in _METHOD_KEYS}}
            for method, at, pair in compared
            for robot, found in enumerate(pair, start=1)
            for axis in found.to_json()["axes"]
        ],
        "reweightings": _reweightings(robots[0]),
        "axes_independent": [found.independent for found in robots],
        "seed": seed,
        "verdict": _verdict(robots, reference_of([dyad[name] for name in dyad.axes])),
    }
    return IdentificationStudy(
        numbers=numbers, movements=(("the paper's", movement), ("designed", designed)), robots=robots
    )


_METHOD_KEYS = ("axis", "mass", "mass_interval", "damping", "damping_interval")


@cache
def _designed() -> Excitation:
    """Design the movement once: it depends on no study."""
    return design_excitation()


def _estimate(
    log: RigLog,
    measured: tuple[FloatArray, FloatArray],
    robot: int,
    axes: list[str],
    method: Any,
    *,
    coulomb: bool,
) -> Identification:
    position, force = measured
    return identify(log.time, position[:, robot], force[:, robot], axes=axes, method=method, coulomb=coulomb)


def _movement(movement: Excitation) -> dict[str, Any]:
    position, velocity, acceleration = movement.extremes()
    return {
        "cosine": list(movement.cosine),
        "sine": list(movement.sine),
        "largest_position": position,
        "largest_velocity": velocity,
        "largest_acceleration": acceleration,
        "condition_number_with_friction": movement.condition_number(coulomb=True, offset=True),
    }


def _reweightings(found: Identification) -> dict[str, Any]:
    """Iterate the paper's weights on the first robot's first axis."""
    signals, axis = found.signals, found.axes[0]
    row = axis.signals_index
    columns = [signals.acceleration[row], signals.velocity[row]]
    if axis.coulomb is not None:
        columns.append(signals.direction[row])
    return {
        "axis": axis.axis,
        "samples": int(signals.time.size),
        "steps": [
            {
                "iteration": step.iteration,
                "mass": float(step.estimate[0]),
                "mass_half_width": float(step.half_width[0]),
                "damping": float(step.estimate[1]),
                "damping_half_width": float(step.half_width[1]),
                "effective_samples": step.effective_samples,
            }
            for step in paper_reweightings(np.stack(columns, axis=-1), signals.force[row], _REWEIGHTINGS)
        ],
    }


def _verdict(robots: tuple[Identification, Identification], reference: Reference) -> dict[str, Any] | None:
    """Carry the estimates' covariance to the margins at 2 K_xy and to the experiment's conditions.

    None where an estimate is no robot's.
    """
    if min(each.value for found in robots for a in found.axes for each in (a.mass, a.damping)) <= _LEAST:
        return None
    first, second = (
        Robot(
            [a.mass.value for a in found.axes],
            [a.damping.value for a in found.axes],
            [a.axis for a in found.axes],
        )
        for found in robots
    )
    estimated = Dyad(first, second)
    one, two = (
        Uncertainty(
            [a.mass.standard_error for a in found.axes],
            [a.damping.standard_error for a in found.axes],
            [a.correlation for a in found.axes],
        )
        for found in robots
    )
    stiffness = 2.0 * reference.stiffness
    margins = margin_uncertainty(estimated, (one, two), stiffness, reference.delay).to_json()
    axes = []
    for i, (margin, name) in enumerate(zip(margins["axes"], estimated.axes, strict=True)):
        axis = estimated[name]
        critical, longest = delta_method(estimated, (one, two), stiffness, i)
        axes.append(
            {
                **margin,
                "critical_stiffness": finite_or_none(axis.critical_stiffness()),
                "critical_stiffness_sd": finite_or_none(critical),
                "maximum_delay": finite_or_none(float(axis.maximum_delay(stiffness))),
                "maximum_delay_sd": finite_or_none(longest),
            }
        )
    conditions = []
    for factor in _STIFFNESS_FACTORS:
        for part in _DELAY_FACTORS:
            k, delay = factor * reference.stiffness, part * reference.delay
            chance = stable_probability(estimated, (one, two), k, delay, draws=_DRAWS)
            conditions.append(
                {
                    "stiffness_factor": factor,
                    "delay_factor": part,
                    "stiffness": k,
                    "delay": delay,
                    "probability_stable": chance.value,
                    "standard_error": chance.standard_error,
                    "draws": chance.draws,
                }
            )
    return {"stiffness": stiffness, "delay": reference.delay, "axes": axes, "conditions": conditions}
