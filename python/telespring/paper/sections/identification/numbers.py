"""Identification of both robots on the simulated rig, and the effect of its errors on the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._json import finite_or_none
from telespring.decision.uncertainty import delta_method, margin_uncertainty, stable_probability
from telespring.identification.estimation import identify
from telespring.identification.excitation import Excitation, design_excitation, paper_excitation
from telespring.identification.results import Identification
from telespring.identification.reweighting import paper_reweightings
from telespring.identification.simulated_logs import ARM, SensorNoise, SimulatedLog, simulate_log
from telespring.model import Dyad, Robot, Study, Uncertainty
from telespring.paper.published import EXPERIMENT_DELAY_FACTORS, EXPERIMENT_STIFFNESS_FACTORS
from telespring.paper.reference import Reference, reference_of
from telespring.show.decision_json import uncertainty_json

if TYPE_CHECKING:
    from telespring._types import FloatArray

__all__ = ["IdentificationStudy", "study_identification"]

#: Seed of the logs' noise; fixed, so that the same study gives the same numbers.
_SEED = 20251122

#: Monte Carlo draws for each probability.
_DRAWS = 5000

#: Numbers of reweightings of the paper's method that are shown; the paper prints one step and no number.
_REWEIGHTINGS = (0, 1, 5, 30, 100)

#: A robot with a smaller estimate, kg or N·s/m, is too light or too little damped for the sensors.
_LEAST = 1e-4


@dataclass(frozen=True)
class IdentificationStudy:
    """Numbers of an identification, and the data of its figures.

    Attributes
    ----------
    numbers
        Plain values in SI units, as JSON has them: ``excitation``, ``noise``, ``arm``, ``axes`` (per robot
        and axis, measured at the handle, with the true values), ``methods``, ``reweightings``,
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
    """Identify a study's bare robots, the paper's by default, from noisy logs of the simulated rig."""
    source = Study.paper() if study is None else study
    dyad = source.dyad
    movement, designed = paper_excitation(), _designed_excitation()
    log = simulate_log(source, movement)
    random = np.random.default_rng(seed)
    measured = {at: log.measured(random, at=at) for at in ("handle", "joints")}
    friction = source.coulomb

    def estimate(at: str, method: Any) -> tuple[Identification, Identification]:
        one, other = (
            _identify_robot(log, measured[at], robot, list(dyad.axes), method, coulomb=bool(friction.any()))
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
            "paper": _excitation_numbers(movement),
            "designed": _excitation_numbers(designed),
        },
        "noise": vars(SensorNoise()),
        "arm": ARM if len(dyad.axes) == 2 else None,
        "axes": [
            {
                "robot": robot + 1,
                **axis,
                "mass_given": float(dyad.robots[robot].mass[i]),
                "damping_given": float(dyad.robots[robot].damping[i]),
                "coulomb_given": float(friction[robot, i]),
            }
            for robot, identified in enumerate(robots)
            for i, axis in enumerate(identified.to_json()["axes"])
        ],
        "methods": [
            {"method": method, "force": at, "robot": robot, **{key: axis[key] for key in _METHOD_KEYS}}
            for method, at, pair in compared
            for robot, identified in enumerate(pair, start=1)
            for axis in identified.to_json()["axes"]
        ],
        "reweightings": _reweighting_numbers(robots[0]),
        "axes_independent": [identified.independent for identified in robots],
        "seed": seed,
        "verdict": _margins_as_identified(robots, reference_of(list(dyad))),
    }
    return IdentificationStudy(
        numbers=numbers, movements=(("the paper's", movement), ("designed", designed)), robots=robots
    )


_METHOD_KEYS = ("axis", "mass", "mass_interval", "damping", "damping_interval")


@cache
def _designed_excitation() -> Excitation:
    """Design the movement, once: it does not depend on the study."""
    return design_excitation()


def _identify_robot(
    log: SimulatedLog,
    measured: tuple[FloatArray, FloatArray],
    robot: int,
    axes: list[str],
    method: Any,
    *,
    coulomb: bool,
) -> Identification:
    position, force = measured
    return identify(log.time, position[:, robot], force[:, robot], axes=axes, method=method, coulomb=coulomb)


def _excitation_numbers(movement: Excitation) -> dict[str, Any]:
    position, velocity, acceleration = movement.extremes()
    return {
        "cosine": list(movement.cosine),
        "sine": list(movement.sine),
        "largest_position": position,
        "largest_velocity": velocity,
        "largest_acceleration": acceleration,
        "condition_number_with_friction": movement.condition_number(coulomb=True, offset=True),
    }


def _reweighting_numbers(identified: Identification) -> dict[str, Any]:
    """Iterate the paper's weights on the first robot's first axis."""
    signals, axis = identified.signals, identified.axes[0]
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


def _margins_as_identified(
    robots: tuple[Identification, Identification], reference: Reference
) -> dict[str, Any] | None:
    """Propagate the estimates' covariance to the margins at 2 K_xy and to the experiment's conditions.

    None if an estimate is not positive enough to be a mass or a damping.
    """
    estimates = [value for robot in robots for axis in robot.axes for value in (axis.mass, axis.damping)]
    if min(estimate.value for estimate in estimates) <= _LEAST:
        return None
    first, second = (
        Robot(
            [axis.mass.value for axis in robot.axes],
            [axis.damping.value for axis in robot.axes],
            [axis.axis for axis in robot.axes],
        )
        for robot in robots
    )
    estimated = Dyad(first, second)
    one, two = (
        Uncertainty(
            [axis.mass.standard_error for axis in robot.axes],
            [axis.damping.standard_error for axis in robot.axes],
            [axis.correlation for axis in robot.axes],
        )
        for robot in robots
    )
    stiffness = 2.0 * reference.stiffness
    margins = uncertainty_json(margin_uncertainty(estimated, (one, two), stiffness, reference.delay))
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
    for factor in EXPERIMENT_STIFFNESS_FACTORS:
        for delay_factor in EXPERIMENT_DELAY_FACTORS:
            k, delay = factor * reference.stiffness, delay_factor * reference.delay
            probability = stable_probability(estimated, (one, two), k, delay, draws=_DRAWS)
            conditions.append(
                {
                    "stiffness_factor": factor,
                    "delay_factor": delay_factor,
                    "stiffness": k,
                    "delay": delay,
                    "probability_stable": probability.value,
                    "standard_error": probability.standard_error,
                    "draws": probability.draws,
                }
            )
    return {"stiffness": stiffness, "delay": reference.delay, "axes": axes, "conditions": conditions}
