"""Figs. 9 and 10 and Table III: both robots identified on the simulated rig."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import telespring as ts
from telespring import figures
from telespring.axes import axes_of, finite_or_none
from telespring.study.part import Found, Scene
from telespring.study.settings import FACTORS

if TYPE_CHECKING:
    from telespring._types import FloatArray
    from telespring.identify import Identification

__all__ = ["find_identification"]

#: The noise of the logs; fixed, so that the same study gives the same bytes.
_SEED = 20251122

#: Of the Monte Carlo behind each probability.
_DRAWS = 5000

#: After so many reweightings of the paper's method the report looks; it prints one step and no number.
_REWEIGHTINGS = (0, 1, 5, 30)


def find_identification(scene: Scene) -> Found:
    """Drive the study's bare robots with the paper's excitation and estimate them from noisy logs."""
    from telespring.figures.identification import excitation_figure, regression_figure
    from telespring.identify import design_excitation, identify, paper_excitation
    from telespring.identify.rig import rig_log

    dyad = scene.dyad
    names = list(dyad.axes)
    movement, designed = paper_excitation(), design_excitation()
    log = rig_log(scene.study, movement)
    measured = {at: log.measured(np.random.default_rng(_SEED), at=at) for at in ("handle", "joints")}

    def estimate(robot: int, at: str, method: Any) -> Identification:
        position, force = measured[at]
        return identify(log.time, position[:, robot], force[:, robot], axes=names, method=method)

    robots = [estimate(robot, "handle", "robust") for robot in (0, 1)]
    compared = [
        ("robust", "handle", robots),
        ("least squares", "handle", [estimate(robot, "handle", "ols") for robot in (0, 1)]),
        ("robust", "joints", [estimate(robot, "joints", "robust") for robot in (0, 1)]),
    ]
    first = robots[0]
    drawings = {
        "excitation": figures.to_svg(
            excitation_figure([("the paper's", movement), ("designed", designed)]),
            "excitation",
            "Velocity, position and acceleration of the excitation",
            "Two columns, the paper's movement and a designed one, over one period.",
        ),
        "regression": figures.to_svg(
            regression_figure(
                [
                    (f"H-MAN {i}" if scene.of_the_paper else f"robot {i}", found)
                    for i, found in enumerate(robots, start=1)
                ]
            ),
            "regression",
            "Measured and estimated force, and its plane over velocity and acceleration",
            "A row per robot and axis: force over time on the left, samples and plane on the right.",
        ),
    }
    return Found(
        numbers={
            "identification": {
                "excitation": {
                    "harmonics": len(movement.cosine),
                    "base_frequency": movement.angular_frequency,
                    "duration": float(log.time[-1]),
                    "sample_rate": first.rate,
                    "cutoff": first.cutoff,
                    "condition_number": movement.condition_number(),
                    "condition_number_designed": designed.condition_number(),
                },
                "axes": [
                    {"robot": robot, **axis, **_given(dyad, robot, i)}
                    for robot, found in enumerate(robots, start=1)
                    for i, axis in enumerate(found.to_json()["axes"])
                ],
                "methods": [
                    {
                        "method": method,
                        "force": at,
                        "robot": robot,
                        **{key: axis[key] for key in _METHOD_KEYS},
                    }
                    for method, at, pair in compared
                    for robot, found in enumerate(pair, start=1)
                    for axis in found.to_json()["axes"]
                ],
                "reweightings": _reweightings(first),
                "axes_independent": [found.independent for found in robots],
                "seed": _SEED,
                "verdict": _verdict(scene, robots),
            }
        },
        drawings=drawings,
    )


_METHOD_KEYS = ("axis", "mass", "mass_interval", "damping", "damping_interval")


def _given(dyad: ts.Dyad, robot: int, axis: int) -> dict[str, float]:
    """Tell what the simulated robot really is: for the paper's robots Table III."""
    of = dyad.robots[robot - 1]
    return {"mass_given": float(of.mass[axis]), "damping_given": float(of.damping[axis])}


def _verdict(scene: Scene, robots: list[Identification]) -> dict[str, Any] | None:
    """Carry the estimates' covariance to the margins at 2 K_xy and to the experiment's conditions.

    None where an estimate is no robot's: too light or too little damped for what the sensors resolve.
    """
    from telespring.uncertainty import margin_uncertainty, stable_probability

    if min(each.value for found in robots for a in found.axes for each in (a.mass, a.damping)) <= 1e-4:
        return None
    names = list(scene.dyad.axes)
    first, second = (
        ts.Robot([a.mass.value for a in found.axes], [a.damping.value for a in found.axes], names)
        for found in robots
    )
    estimated = ts.Dyad(first, second)
    one, two = (
        ts.Uncertainty(
            [a.mass.standard_error for a in found.axes],
            [a.damping.standard_error for a in found.axes],
            [a.correlation for a in found.axes],
        )
        for found in robots
    )
    stiffness = 2 * scene.reference.stiffness
    margins = margin_uncertainty(estimated, (one, two), stiffness, scene.reference.delay).to_json()
    conditions = [
        (factor * scene.reference.stiffness, part * scene.reference.delay)
        for factor in FACTORS
        for part in (0.5, 1.0, 2.0)
    ]
    return {
        "stiffness": stiffness,
        "axes": [
            {
                **margin,
                "critical_stiffness": finite_or_none(axis.critical_stiffness()),
                "maximum_delay": finite_or_none(float(axis.maximum_delay(stiffness))),
            }
            for margin, axis in zip(margins["axes"], axes_of(estimated), strict=True)
        ],
        "conditions": [
            {
                "stiffness": k,
                "delay": delay,
                "probability_stable": stable_probability(estimated, (one, two), k, delay, draws=_DRAWS).value,
            }
            for k, delay in conditions
        ],
    }


def _reweightings(found: Identification) -> dict[str, Any]:
    """Iterate the paper's weights on the first robot's first axis."""
    from telespring.identify import paper_reweightings

    signals, axis = found.signals, found.axes[0]
    row = axis.signals_index
    columns: FloatArray = np.stack([signals.acceleration[row], signals.velocity[row]], axis=-1)
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
            for step in paper_reweightings(columns, signals.force[row], _REWEIGHTINGS)
        ],
    }
