"""Fig. 6, the virtual laboratory: its drawing, and robots, arms, agents, task and protocol in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Literal

from telespring.model import Architecture, Experiment
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.rehearsal.preflight import preflight_warnings
from telespring.rehearsal.target import target_path
from telespring.show import figures
from telespring.show.screens.rehearsal import preflight_sentence

__all__ = ["SECTION", "find_laboratory"]

#: Label and unit of a value of the study file, by its key.
_LABELS = {
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

#: Units of the settings of a session; a share or a ratio has none.
_SESSION_UNITS = {
    "capacity": "J",
    "intake": "W",
    "impedance": "N·s/m",
    "filter": "s",
    "largest_damping": "N·s/m",
    "level": "J",
    "transfer_rate": "1/s",
    "filling": "N·s/m per J",
    "damping": "N·s/m",
    "ceiling": "J",
    "process": "m²/s³ or m²/s⁵",
    "position": "m",
    "delay": "s",
    "margin": "s",
    "smallest": "s",
    "largest": "s",
    "window": "s",
}


def find_laboratory(scene: Scene) -> Findings:
    """Draw the laboratory and list what is simulated, for robots with its two axes."""
    experiment = scene.study.experiment
    if experiment is None:
        return Findings()
    settings = experiment.settings
    rows: list[dict[str, Any]] = []
    for i, friction in enumerate(scene.study.coulomb, start=1):
        if friction.any():
            rows += [
                _laboratory_row(f"robot {i}", f"Coulomb friction, {axis}", float(force), "N")
                for axis, force in zip(scene.study.dyad.axes, friction, strict=True)
            ]
    for i, agent in enumerate(experiment.agents, start=1):
        rows += _laboratory_rows(f"agent {i}", agent.to_dict())
    for i, arm in enumerate(experiment.arms, start=1):
        rows += _laboratory_rows(f"arm {i}", arm.to_dict())
    rows += _laboratory_rows("task", experiment.task.to_dict())
    if experiment.coupling_damping:
        rows.append(_laboratory_row("coupling", "damping", experiment.coupling_damping, "N·s/m"))
    if scene.study.session != Architecture():
        rows += _session_rows(scene.study.session)
    rows.append(_laboratory_row("controllers", "sample period", experiment.sample_period, "s"))
    if settings.computing_tick:
        rows.append(_laboratory_row("controllers", "a force acts", "one period after its samples", ""))
    rows += [
        _laboratory_row(part, name, value, unit)
        for part, name, value, unit in (
            ("controllers", "lag of the actuators", settings.actuator_lag, "s"),
            ("controllers", "resolution of the encoders", settings.encoder_resolution, "m"),
            ("network", "jitter, largest additional delay of a packet", settings.jitter, "s"),
            ("network", "probability that a packet is lost", settings.loss, "1"),
        )
        if value
    ]
    rows += [
        _laboratory_row("protocol", "conditions", len(experiment.conditions), "1"),
        _laboratory_row("protocol", "trials of each", experiment.trials, "1"),
        _laboratory_row("protocol", "length of a trial", experiment.duration, "s"),
        _laboratory_row("protocol", "discarded at its start", experiment.discard, "s"),
        _laboratory_row("protocol", "samples recorded per second", experiment.record_rate, "Hz"),
        _laboratory_row("protocol", "order of the trials", experiment.order, ""),
        _laboratory_row("protocol", "seed", experiment.seed, "1"),
    ]
    numbers = {
        "parameters": rows,
        "spots": _target_spot_row(experiment),
        "warnings": [
            preflight_sentence(warning) for warning in preflight_warnings(scene.study, scene.modules)
        ],
        "robots": [scene.robot_name(i) for i in (0, 1)],
        "arms": [arm.kind for arm in experiment.arms],
        "agents": [agent.kind for agent in experiment.agents],
        "task": experiment.task.kind,
        "of_the_paper": scene.of_the_papers_experiment,
    }
    return Findings(
        numbers={"laboratory": numbers}, drawings={"laboratory": _draw_figure_6(scene, experiment)}
    )


SECTION = Section(
    name="laboratory",
    anchor="laboratory",
    title="The virtual laboratory",
    step="Fig. 6, the laboratory",
    find=find_laboratory,
    holds=(Place("Fig. 6", "figure-laboratory"),),
)


def _target_spot_row(experiment: Experiment) -> dict[str, Any] | None:
    for agent in experiment.agents:
        if agent.spot_velocity is not None and agent.spot_lifetime is not None:
            return {
                "count": agent.spots,
                "velocity": agent.spot_velocity,
                "lifetime": agent.spot_lifetime,
                "reach": agent.spot_velocity * agent.spot_lifetime,
            }
    return None


def _laboratory_rows(part: str, described: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    yield _laboratory_row(part, "kind", str(described["kind"]), "")
    for key, value in described.items():
        if key == "kind" or value is None:
            continue
        name, unit = _LABELS.get(key, (key.replace("_", " "), "1"))
        if isinstance(value, Mapping):
            for option, setting in value.items():
                yield _laboratory_row(part, f"{name} {option}", str(setting), "")
        elif isinstance(value, list | tuple):
            places = ("x", "y") if key in {"mass", "damping", "base", "amplitude"} else ("1", "2")
            for place, entry in zip(places, value, strict=True):
                yield _laboratory_row(
                    part, f"{name}, {place}" if place in "xy" else f"{name} {place}", entry, unit
                )
        else:
            yield _laboratory_row(part, name, value, unit)


def _session_rows(session: Architecture) -> Iterator[dict[str, Any]]:
    """List strategy, predictor and play-out, and their settings where one is not the usual one."""
    for key, value in session.to_dict().items():
        settings = value if isinstance(value, Mapping) else {"kind": value}
        for name, setting in settings.items():
            of = "" if name == "kind" else f", {name.replace('_', ' ')}"
            unit = _SESSION_UNITS.get(name, "1") if isinstance(setting, float) else ""
            yield _laboratory_row("session", f"{'play-out' if key == 'playout' else key}{of}", setting, unit)


def _laboratory_row(part: str, name: str, value: Any, unit: str) -> dict[str, Any]:
    if value == math.inf:
        value = None  # no limit
    return {"part": part, "name": name, "value": value, "unit": unit}


def _draw_figure_6(scene: Scene, experiment: Experiment) -> str:
    sides = (_laboratory_side(scene, experiment, 0), _laboratory_side(scene, experiment, 1))
    return figures.to_svg(
        figures.laboratory_schematic(target_path(experiment, scene.modules), sides),
        "laboratory",
        "The laboratory: two robots, each held by an agent's arm",
        "Top: the target's path for each agent. Bottom: the robots seen from above. "
        + " ".join(
            f"{side.robot}: agent {' '.join(side.agent.split())}, {' '.join(side.arm.split())}."
            for side in sides
        )
        + " A virtual spring over a delayed network joins the two handles.",
    )


def _laboratory_side(scene: Scene, experiment: Experiment, i: int) -> figures.DrawnSide:
    """Describe robot, agent and arm on one side, for the drawing."""
    agent, arm = experiment.agents[i], experiment.arms[i]
    spots = agent.spots or 0
    if agent.class_ is not None:
        agent_label = "program\n" + agent.class_.rpartition(":")[2][-18:]
    elif spots:
        agent_label = f"less skilled:\n{spots} spot{'s' if spots > 1 else ''}"
    else:
        agent_label = "skilled"
    links: dict[str, tuple[Literal["drawn", "dashed", "block", "none"], str]] = {
        "two-link": ("drawn", "two-link arm"),
        "lumped": ("block", "arm: a mass and a damper"),
        "massless": ("none", "massless arm"),
    }
    drawn, arm_label = links[arm.kind]
    elbow = arm.elbow or ("left", "right")[i]
    if arm.kind == "massless" and scene.of_the_papers_experiment:
        drawn, arm_label = "dashed", "two-link arm,\nhere massless"
    return figures.DrawnSide(scene.robot_name(i), agent_label, spots, arm_label, drawn, elbow)
