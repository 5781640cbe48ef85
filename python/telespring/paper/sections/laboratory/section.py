"""Fig. 6 in numbers: robots, arms, agents, task, controllers and protocol of the rehearsal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from telespring.model import Experiment
from telespring.paper.scene import Found, Scene
from telespring.rehearsal.preflight import laboratory_settings, warnings_of

__all__ = ["find_laboratory"]

#: Words and unit of what a study file says, by its key.
_WORDS = {
    "stiffness": ("stiffness to the target", "N/m"),
    "damping": ("damping", "N·s/m"),
    "spots": ("spots in the cloud", "1"),
    "spot_velocity": ("standard deviation of a spot's velocity, per axis", "m/s"),
    "spot_lifetime": ("lifetime of a spot", "s"),
    "class": ("program", ""),
    "function": ("program", ""),
    "mass": ("mass", "kg"),
    "base": ("shoulder", "m"),
    "elbow": ("elbow", ""),
    "link_length": ("length of link", "m"),
    "link_mass": ("mass of link", "kg"),
    "link_centre": ("centre of mass of link from its joint", "m"),
    "link_inertia": ("inertia of link about its centre", "kg·m²"),
    "joint_damping": ("damping of joint", "N·m·s/rad"),
    "rotor_inertia": ("inertia of actuator at joint", "kg·m²"),
    "torque_limit": ("largest torque of joint", "N·m"),
    "amplitude": ("amplitude", "m"),
    "angular_frequency": ("angular frequency ω", "rad/s"),
}


def find_laboratory(scene: Scene) -> Found:
    """List what is simulated, for robots with the laboratory's two axes."""
    experiment = scene.study.experiment
    if experiment is None:
        return Found()
    settings = laboratory_settings(scene.study)
    rows: list[dict[str, Any]] = []
    for i, friction in enumerate(settings["coulomb"], start=1):
        if any(friction):
            rows += [
                _row(f"robot {i}", f"Coulomb friction, {axis}", each, "N")
                for axis, each in zip(scene.study.dyad.axes, friction, strict=True)
            ]
    for i, agent in enumerate(experiment.agents, start=1):
        rows += _rows(f"agent {i}", agent.to_dict())
    for i, arm in enumerate(experiment.arms, start=1):
        rows += _rows(f"arm {i}", arm.to_dict())
    rows += _rows("task", experiment.task.to_dict())
    if experiment.coupling_damping:
        rows.append(_row("coupling", "damping", experiment.coupling_damping, "N·s/m"))
    rows.append(_row("controllers", "sample period", experiment.sample_period, "s"))
    if settings["computing_tick"]:
        rows.append(_row("controllers", "a force acts", "one period after its samples", ""))
    rows += [
        _row(part, name, settings[key], unit)
        for part, name, key, unit in (
            ("controllers", "lag of the actuators", "actuator_lag", "s"),
            ("controllers", "resolution of the encoders", "encoder_resolution", "m"),
            ("network", "jitter, the most that a packet is later", "jitter", "s"),
            ("network", "probability that a packet is lost", "loss", "1"),
        )
        if settings[key]
    ]
    rows += [
        _row("protocol", "conditions", len(experiment.conditions), "1"),
        _row("protocol", "trials of each", experiment.trials, "1"),
        _row("protocol", "length of a trial", experiment.duration, "s"),
        _row("protocol", "left out at its start", experiment.discard, "s"),
        _row("protocol", "samples recorded per second", experiment.record_rate, "Hz"),
        _row("protocol", "order of the trials", experiment.order, ""),
        _row("protocol", "seed", experiment.seed, "1"),
    ]
    return Found(
        numbers={
            "laboratory": {
                "parameters": rows,
                "spots": _spots(experiment),
                "warnings": warnings_of(scene.study, scene.modules),
                "robots": [scene.robot_name(i) for i in (0, 1)],
                "arms": [arm["kind"] for arm in experiment.arms],
                "agents": [agent["kind"] for agent in experiment.agents],
                "task": experiment.task["kind"],
                "of_the_paper": scene.of_the_papers_experiment,
            }
        }
    )


def _spots(experiment: Experiment) -> dict[str, Any] | None:
    for agent in experiment.agents:
        if agent["kind"] == "blurred":
            return {
                "count": agent["spots"],
                "velocity": agent["spot_velocity"],
                "lifetime": agent["spot_lifetime"],
                "reach": agent["spot_velocity"] * agent["spot_lifetime"],
            }
    return None


def _rows(part: str, described: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    yield _row(part, "kind", str(described["kind"]), "")
    for key, value in described.items():
        if key == "kind" or value is None:
            continue
        name, unit = _WORDS.get(key, (key.replace("_", " "), "1"))
        if isinstance(value, Mapping):
            for inner, given in value.items():
                yield _row(part, f"{name} {inner}", str(given), "")
        elif isinstance(value, list | tuple):
            places = ("x", "y") if key in {"mass", "damping", "base", "amplitude"} else ("1", "2")
            for place, each in zip(places, value, strict=True):
                yield _row(part, f"{name}, {place}" if place in "xy" else f"{name} {place}", each, unit)
        else:
            yield _row(part, name, value, unit)


def _row(part: str, name: str, value: Any, unit: str) -> dict[str, Any]:
    if value == math.inf:
        value = None  # no limit
    return {"part": part, "name": name, "value": value, "unit": unit}
