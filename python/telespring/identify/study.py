"""Identification as the study shows it: both robots on the simulated rig, and what it does to the verdict."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np

import telespring as ts
from telespring.axes import finite_or_none
from telespring.identify.estimation import Identification, identify
from telespring.identify.excitation import Excitation, design_excitation, paper_excitation
from telespring.identify.regression import paper_reweightings
from telespring.identify.rig import ARM, Noise, rig_log
from telespring.uncertainty import delta_method, margin_uncertainty, stable_probability

__all__ = ["IdentificationStudy", "identification_study", "study_identification"]

_STIFFNESS_FACTORS = (0.5, 1.0, 2.0, 4.0)
_DELAY_FACTORS = (0.0, 0.5, 1.0, 2.0)
_ITERATIONS = (0, 1, 2, 5, 10, 30, 100)


@dataclass(frozen=True)
class _Known:
    """Errors of an identified robot, in the form of `telespring.Study.uncertainty`."""

    mass_sd: tuple[float, ...]
    damping_sd: tuple[float, ...]
    correlation: tuple[float, ...]

    @classmethod
    def of(cls, found: Identification) -> _Known:
        return cls(
            tuple(axis.mass.standard_error for axis in found.axes),
            tuple(axis.damping.standard_error for axis in found.axes),
            tuple(axis.correlation for axis in found.axes),
        )


@dataclass(frozen=True)
class IdentificationStudy:
    """Numbers of the study, and what its figures are drawn from.

    Attributes
    ----------
    numbers
        Plain values in SI units, as JSON has them.
    movements
        Name and movement: the paper's command and the designed one (Fig. 9).
    robots
        Name and identification at the handle of both robots (Fig. 10).
    """

    numbers: dict[str, Any]
    movements: tuple[tuple[str, Excitation], ...]
    robots: tuple[tuple[str, Identification], ...]


def identification_study(seed: int = 1) -> dict[str, Any]:
    """Identify both of the paper's robots on the simulated rig and carry the errors to the verdict.

    Parameters
    ----------
    seed : int
        Of the sensors' noise.

    Returns
    -------
    dict
        Plain values in SI units: `excitation`, `noise`, `arm`, `robots` (per robot the identification at the
        handle and at the joints, beside the truth, and the paper's method), `verdict` (intervals of margins
        and the probability that each of the paper's 16 conditions is stable).
    """
    return study_identification(seed).numbers


def study_identification(seed: int = 1, study: ts.Study | None = None) -> IdentificationStudy:
    """Do what `identification_study` does, and keep what the figures need.

    Parameters
    ----------
    seed
        Of the sensors' noise.
    study
        The robots, on two axes; the paper's unless given.

    Returns
    -------
    IdentificationStudy
        Numbers, movements and identifications.
    """
    source = study or ts.Study.paper()
    dyad = source.dyad
    paper, designed = paper_excitation(), design_excitation()
    log = rig_log(source, paper)
    random = np.random.default_rng(seed)
    handle, joints = log.measured(random), log.measured(random, at="joints")
    names = [name or f"robot {i + 1}" for i, name in enumerate(source.robot_names)]
    axes = [str(name) for name in dyad.axes]
    friction = _has_friction(source)
    robots, at_handle = [], []
    for i, name in enumerate(names):
        found = {
            place: identify(log.time, position[:, i], force[:, i], axes=axes, coulomb=friction)
            for place, (position, force) in (("handle", handle), ("joints", joints))
        }
        at_handle.append(found["handle"])
        robots.append(
            {
                "name": name,
                "truth": {"mass": dyad.robots[i].mass.tolist(), "damping": dyad.robots[i].damping.tolist()},
                "handle": found["handle"].to_json(),
                "joints": found["joints"].to_json(),
                "paper": _paper_method(log.time, handle[0][:, i], handle[1][:, i], axes, found["handle"]),
            }
        )
    numbers = {
        "excitation": {"paper": _movement(paper), "designed": _movement(designed)},
        "noise": {"seed": seed, **vars(Noise())},
        "arm": ARM,
        "robots": robots,
        "verdict": _verdict(dyad, at_handle),
    }
    return IdentificationStudy(
        numbers=numbers,
        movements=(("the paper's command", paper), ("designed", designed)),
        robots=tuple(zip(names, at_handle, strict=True)),
    )


def _has_friction(study: ts.Study) -> bool:
    """Tell whether a robot of the study has Coulomb friction, which must then be identified too."""
    tables = tomllib.loads(study.to_toml())
    return any(np.any(tables[robot].get("coulomb", 0.0)) for robot in ("robot1", "robot2"))


def _movement(movement: Excitation) -> dict[str, Any]:
    position, velocity, acceleration = movement.extremes()
    return {
        "angular_frequency": movement.angular_frequency,
        "cosine": list(movement.cosine),
        "sine": list(movement.sine),
        "largest_position": position,
        "largest_velocity": velocity,
        "largest_acceleration": acceleration,
        "condition_number": movement.condition_number(),
        "condition_number_with_friction": movement.condition_number(coulomb=True, offset=True),
    }


def _paper_method(
    time: Any, position: Any, force: Any, axes: list[str], robust: Identification
) -> list[dict[str, Any]]:
    """Per axis: the estimate after the one step that is printed, and where further steps lead."""
    friction = robust.axes[0].coulomb is not None
    once = identify(time, position, force, axes=axes, coulomb=friction, method="paper", cutoff=robust.cutoff)
    rows = []
    for axis in once.axes:
        signals = robust.signals
        row = axis.signals_index
        columns = [signals.acceleration[row], signals.velocity[row]]
        regressor = np.column_stack([*columns, signals.direction[row]] if friction else columns)
        steps = paper_reweightings(regressor, signals.force[row], _ITERATIONS)
        rows.append({**axis.to_json(), "iterations": [step.to_json() for step in steps]})
    return rows


def _verdict(dyad: ts.Dyad, found: list[Identification]) -> dict[str, Any]:
    """Margins of the robots as identified, with intervals, and the chance that each condition is stable."""
    estimated = ts.Dyad(_robot(found[0]), _robot(found[1]))
    known = (_Known.of(found[0]), _Known.of(found[1]))
    stiffness, delay = _reference(dyad)
    margins = margin_uncertainty(estimated, known, 2.0 * stiffness, delay)
    first_order = []
    for i, name in enumerate(estimated.axes):
        critical, longest = delta_method(estimated, known, 2.0 * stiffness, i)
        first_order.append(
            {
                "axis": str(name),
                "critical_stiffness_sd": finite_or_none(critical),
                "maximum_delay_sd": finite_or_none(longest),
            }
        )
    conditions = []
    for factor in _STIFFNESS_FACTORS:
        for delay_factor in _DELAY_FACTORS:
            probability = stable_probability(estimated, known, factor * stiffness, delay_factor * delay)
            conditions.append(
                {
                    "stiffness_factor": factor,
                    "delay_factor": delay_factor,
                    "stiffness": factor * stiffness,
                    "delay": delay_factor * delay,
                    "stable_probability": probability.value,
                    "standard_error": probability.standard_error,
                }
            )
    return {
        "stiffness": 2.0 * stiffness,
        "delay": delay,
        "margins": margins.to_json(),
        "first_order": first_order,
        "conditions": conditions,
    }


def _robot(found: Identification) -> ts.Robot:
    return ts.Robot(
        [axis.mass.value for axis in found.axes],
        [axis.damping.value for axis in found.axes],
        [axis.axis for axis in found.axes],
    )


def _reference(dyad: ts.Dyad) -> tuple[float, float]:
    """K_xy and Δ_xy of the true robots (Eq. 11), in whose multiples the experiment is laid out."""
    from telespring.axes import axes_of
    from telespring.reference import reference_of

    base = reference_of(axes_of(dyad))
    return base.stiffness, base.delay
