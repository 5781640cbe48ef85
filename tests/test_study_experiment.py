"""The experiment of a study file as Python sees it, and studies with values or robots put in."""

from __future__ import annotations

import copy
import json
import pickle
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app

ROBOT = """
[robot]
name = "measured"
axes = ["x", "y"]
mass = [0.84, 1.07]
damping = [7.7, 10.1]
coulomb = [0.2, 0.3]
mass_sd = [0.01, 0.02]
damping_sd = [0.1, 0.2]
mass_damping_correlation = [0.5, -0.5]

[identification]
method = "robust"
samples = 24841
"""


def experiment_of(study: ts.Study) -> ts.Experiment:
    experiment = study.experiment
    assert experiment is not None
    return experiment


def test_ref_the_paper_experiment() -> None:
    """Du, Kulkarni, Kager and Campolo, section IV: Unconnected Mode and 4 x 4 conditions, n = 20."""
    study = ts.Study.paper()
    experiment = experiment_of(study)
    conditions = experiment.conditions
    assert conditions[0] == (None, 0.0)
    assert [round(k) for k, _ in conditions[1::4] if k is not None] == [18, 36, 71, 142]
    # what the library says of the same robots, to the last bit
    base = min(
        float(ts.critical_stiffness(m1, b1, m2, b2))
        for m1, b1, m2, b2 in zip(
            study.dyad.robots[0].mass,
            study.dyad.robots[0].damping,
            study.dyad.robots[1].mass,
            study.dyad.robots[1].damping,
            strict=True,
        )
    )
    assert conditions[5][0] == base
    assert [delay for _, delay in conditions[1:5]] == pytest.approx(
        [0.0, 0.083593, 0.167186, 0.334373],
        rel=3e-6,  # the six digits printed here
    )
    assert (experiment.trials, experiment.duration, experiment.discard) == (20, 29.111, 4.852)
    assert (experiment.record_rate, experiment.seed, experiment.order) == (100.0, 1, "blocks")
    assert (experiment.sample_period, experiment.coupling_damping) == (0.001, 0.0)
    assert [agent.kind for agent in experiment.agents] == ["skilled", "blurred"]
    assert experiment.task.to_dict() == {
        "kind": "figure-eight",
        "amplitude": [0.05, 0.1],
        "angular_frequency": 2.59,
    }
    assert [arm.to_dict() for arm in experiment.arms] == [{"kind": "massless"}, {"kind": "massless"}]


def test_ref_the_second_example_is_another_experiment(root: Path) -> None:
    study = ts.Study.read(root / "examples" / "two-link.toml")
    experiment = experiment_of(study)
    assert [arm.elbow for arm in experiment.arms] == ["right", "left"]
    assert experiment.arms[1].torque_limit == (np.inf, np.inf)
    assert experiment.conditions[2] == (40.0, 0.04)
    assert experiment.order == "shuffled"
    first, second = study.uncertainty
    assert first is not None
    assert second is None
    assert first.damping_sd.tolist() == [0.08, 0.1]
    assert eval(repr(first), vars(ts)) == first
    assert pickle.loads(pickle.dumps(first)) == first


def test_law_an_experiment_is_a_value(root: Path) -> None:
    paper = ts.Study.paper()
    other = ts.Study.read(root / "examples" / "two-link.toml")
    for study in (paper, other):
        experiment = experiment_of(study)
        assert experiment == study.experiment
        assert pickle.loads(pickle.dumps(experiment)) == experiment
        assert copy.deepcopy(experiment) == experiment
        assert ts.Study.from_toml(study.to_toml()).experiment == experiment
        with pytest.raises(AttributeError):
            experiment.trials = 1  # type: ignore[misc]
    assert paper.experiment != other.experiment


def test_ref_options_of_python_arrive_as_python_values() -> None:
    options: dict[str, Any] = {"gain": 2.5, "order": 3, "side": "left", "on": True, "poles": [1.0, [2, "a"]]}
    study = ts.Study.paper().replace(
        agent2={"kind": "python", "class": "patients:Tremor", "options": options},
        task={"kind": "python", "function": "targets:circle"},
    )
    experiment = experiment_of(study)
    agent = experiment.agents[1]
    assert agent.to_dict() == {"kind": "python", "class": "patients:Tremor", "options": options}
    assert (agent.kind, agent.class_, agent.stiffness) == ("python", "patients:Tremor", None)
    assert agent.options is not None
    assert [type(value) for value in agent.options.values()] == [
        float,
        bool,
        int,
        list,
        str,
    ]
    assert experiment.task.to_dict() == {"kind": "python", "function": "targets:circle", "options": {}}
    with pytest.raises(ts.InvalidInput, match="Python function"):
        experiment.task.positions([0.0])


def test_ref_what_cannot_be_rehearsed_says_so() -> None:
    one_axis = ts.Study.from_toml(
        "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\n"
        "coupling.stiffness = 20\nnetwork.delay = 0.05"
    )
    assert one_axis.experiment is None
    undamped = ts.Study.paper().replace(robot1={"damping": 0.0}, robot2={"damping": 0.0})
    with pytest.raises(ts.InvalidInput, match="critical stiffness K") as refused:
        _ = undamped.experiment
    assert refused.value.field == "protocol.stiffness"


def test_law_replacing_changes_what_it_names_only() -> None:
    paper = ts.Study.paper()
    assert paper.replace() == paper
    changed = paper.replace(
        name="heavier",
        robot1={"coulomb": np.array([0.1, 0.2]), "mass_sd": np.float64(0.01)},
        arm1={"kind": "lumped", "mass": 0.5},
        agent2={"spot_velocity": 0.1},
    )
    assert changed.name == "heavier"
    assert changed.dyad == paper.dyad
    assert changed.uncertainty[0] == ts.Uncertainty([0.01, 0.01], [0.0, 0.0], [0.0, 0.0])
    experiment = experiment_of(changed)
    less_skilled = experiment_of(paper).agents[1].to_dict()
    assert experiment.agents[1].to_dict() == {**less_skilled, "spot_velocity": 0.1}
    assert experiment.conditions == experiment_of(paper).conditions
    # another kind starts the section anew, None takes a key away, and back we are
    back = changed.replace(
        name=paper.name,
        robot1={
            "coulomb": None,
            "mass_sd": None,
            "damping_sd": None,
            "mass_damping_correlation": None,
        },
        arm1={"kind": "massless"},
        agent2={"spot_velocity": 0.3},
    )
    assert back == paper


def test_law_parts_of_an_experiment_are_values_and_stand_for_their_sections(root: Path) -> None:
    other = experiment_of(ts.Study.read(root / "examples" / "two-link.toml"))
    paper = ts.Study.paper()
    parts = (*other.agents, *other.arms, other.task, other.settings, *other.conditions)
    for part in parts:
        assert pickle.loads(pickle.dumps(part)) == part
        assert copy.deepcopy(part) == part
        assert eval(repr(part), vars(ts), {"inf": np.inf}) == part
    with pytest.raises(AttributeError):
        other.arms[0].base = (0.0, 0.0)  # type: ignore[misc]
    changed = paper.replace(arm1=other.arms[0], agent2=other.agents[1], laboratory=other.settings)
    experiment = experiment_of(changed)
    assert experiment.arms == (other.arms[0], experiment_of(paper).arms[1])
    assert experiment.agents == (experiment_of(paper).agents[0], other.agents[1])
    assert experiment.settings == other.settings
    # the settings carry what the network does; what is said of the network itself comes first
    assert changed == paper.replace(
        arm1=other.arms[0],
        agent2=other.agents[1],
        laboratory={
            key: value for key, value in other.settings.to_dict().items() if key not in ("jitter", "loss")
        },
        network={"jitter": 0.005, "loss": 0.02},
    )
    plain = {"jitter": None, "loss": None}
    assert changed.replace(arm1=None, agent2=None, laboratory=None, network=plain) == paper
    kept = experiment_of(paper.replace(network={"loss": 0.5}, laboratory=other.settings)).settings
    assert (kept.jitter, kept.loss) == (0.005, 0.5)


def test_law_a_condition_is_a_pair() -> None:
    condition = ts.Condition(35.6, 0.1)
    stiffness, delay = condition
    assert (stiffness, delay) == (condition.stiffness, condition.delay) == condition
    assert hash(condition) == hash((35.6, 0.1))
    assert condition != ts.Condition(None, 0.0)
    assert condition != (35.6, 0.2)
    assert len(condition) == 2
    assert ts.Condition(None, 0.0).to_dict() == {"stiffness": None, "delay": 0.0}


def test_law_a_study_knows_whether_it_names_what_holds_the_handles(root: Path) -> None:
    paper = ts.Study.paper()
    assert not paper.names_arms_or_agents
    assert not paper.replace(protocol={"trials": 3}).names_arms_or_agents
    named = paper.replace(arm1={"kind": "massless"})
    assert named.names_arms_or_agents
    assert named == paper
    assert named.with_robot(1, ROBOT).names_arms_or_agents
    assert ts.Study.read(root / "examples" / "two-link.toml").names_arms_or_agents


def test_law_friction_has_a_value_for_each_robot_and_axis() -> None:
    rough = ts.Study.paper().replace(robot2={"coulomb": 0.3})
    assert rough.coulomb.tolist() == [[0.0, 0.0], [0.3, 0.3]]


def test_law_the_documented_function_of_before_does_the_same() -> None:
    paper = ts.Study.paper()
    with pytest.warns(DeprecationWarning, match="telespring.study_text"):
        with_robot = import_module("telespring.study_text").with_robot
    assert with_robot(paper, 2, ROBOT) == paper.with_robot(2, ROBOT)


def test_law_conditions_and_lists_take_each_others_place() -> None:
    listed = ts.Study.paper().replace(
        protocol={"conditions": [{"stiffness": 20.0, "delay": 0.1}], "trials": 3}
    )
    assert list(experiment_of(listed).conditions) == [(None, 0.0), (20.0, 0.1)]
    combined = listed.replace(protocol={"stiffness": [10.0, 20.0], "delay": [0.0]})
    assert list(experiment_of(combined).conditions) == [(None, 0.0), (10.0, 0.0), (20.0, 0.0)]
    assert experiment_of(combined).trials == 3


def test_ref_a_refusal_names_no_line_of_a_text_that_nobody_wrote() -> None:
    refusals: tuple[tuple[dict[str, dict[str, object]], str], ...] = (
        ({"arm1": {"mass": 1.0}}, "arm1.mass"),
        ({"coupling": {"stiffness": float("nan")}}, "coupling.stiffness"),
        ({"agent1": {"kind": object()}}, "agent1.kind"),
        ({"protocol": {"seed": 2**64}}, "protocol.seed"),
        ({"arms": {}}, "arms"),
    )
    for values, field in refusals:
        with pytest.raises(ts.InvalidInput) as refused:
            ts.Study.paper().replace(**values)
        assert refused.value.field == field
        assert "line" not in str(refused.value)
    with pytest.raises(ts.InvalidInput, match="is a section with the keys stiffness, damping"):
        ts.Study.paper().replace(coupling=20.0)


def test_ref_a_robot_file_replaces_the_robot_whole(tmp_path: Path) -> None:
    path = tmp_path / "left.toml"
    path.write_text(ROBOT, encoding="utf-8")
    paper = ts.Study.paper()
    study = paper.with_robot(2, path)
    assert study == paper.with_robot(2, ROBOT)
    assert study.robot_names == ("H-MAN 1", "measured")
    assert study.dyad.robots == (paper.dyad.robots[0], ts.Robot([0.84, 1.07], [7.7, 10.1]))
    assert study.uncertainty == (None, ts.Uncertainty([0.01, 0.02], [0.1, 0.2], [0.5, -0.5]))
    assert "coulomb = [0.2, 0.3]" in study.to_toml()
    # another robot in its place leaves nothing of it behind
    certain = study.with_robot(2, "[robot]\nmass = [1, 1]\ndamping = 5")
    assert certain.uncertainty == (None, None)
    assert certain.robot_names == ("H-MAN 1", None)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "[robot]\nmass = [1, 1]",
            "Missing robot1.damping (N·s/m). Add damping = 5.0 under [robot]. See [robot] in",
        ),
        ("[robot]\nmass = [1, -1]\ndamping = 5", "robot1.mass[1] = -1"),
        ("[robot]\nmass = 1\ndamping = 5\nfriction = 2", "robot1.friction = 2"),
        ("[robot]\nmass = 1 kg", "TOML text, and this is not"),
        ("[robot1]\nmass = 1\ndamping = 5", "has only the sections [robot]"),
        ("", "no section [robot]"),
        (ROBOT + "[coupling]\nstiffness = 5", "This is a study: give it as the study, without --robot."),
    ],
)
def test_ref_a_wrong_robot_file_is_refused_by_its_name(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ts.InvalidInput) as refused:
        ts.Study.paper().with_robot(1, path)
    assert said in str(refused.value)
    assert "robot.toml" in str(refused.value)


def test_ref_a_robot_file_of_other_letters_or_none(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_bytes('[robot]\nname = "Zürich"'.encode("latin-1"))
    with pytest.raises(ts.InvalidInput, match="UTF-8"):
        ts.Study.paper().with_robot(1, path)
    with pytest.raises(FileNotFoundError):
        ts.Study.paper().with_robot(1, tmp_path / "none.toml")
    with pytest.raises(ts.InvalidInput, match="robots 1 and 2"):
        ts.Study.paper().with_robot(3, ROBOT)


def test_ref_the_command_line_takes_robot_files(tmp_path: Path) -> None:
    path = tmp_path / "stiff.toml"
    # two alike with ten times the paper's damping: K is B²/(2M)
    path.write_text("[robot]\nmass = [0.8, 1.1]\ndamping = [77.0, 100.0]", encoding="utf-8")
    runner = CliRunner()
    paper = runner.invoke(app, ["decide", "--json", "--stiffness", "71.2", "--delay", "0.2"])
    robots = ["--robot1", str(path), "--robot2", str(path)]
    stiff = runner.invoke(app, ["decide", "--json", "--stiffness", "71.2", "--delay", "0.2", *robots])
    assert paper.exit_code == stiff.exit_code == 0, stiff.output
    assert json.loads(paper.output)["stable"] is False
    answer = json.loads(stiff.output)
    assert answer["stable"] is True
    assert answer["axes"][0]["critical_stiffness"] == pytest.approx(77.0**2 / 1.6, rel=1e-12)
    written = runner.invoke(
        app,
        [
            "simulate",
            "--duration",
            "0.1",
            "--out",
            str(tmp_path / "s.csv"),
            "--robot1",
            str(path),
            "--robot2",
            "hman2",
        ],
    )
    assert written.exit_code == 0, written.output
    missing = runner.invoke(app, ["decide", "--robot1", "hman1", "--robot2", str(tmp_path / "none.toml")])
    assert missing.exit_code == 2
    path.write_text("[robot]\nmass = [0.8, 1.1]", encoding="utf-8")
    refused = runner.invoke(app, ["decide", "--robot1", "hman1", "--robot2", str(path)])
    assert refused.exit_code == 2
    assert "robot2.damping" in refused.output


def test_law_access_by_key_works_and_names_the_attribute() -> None:
    experiment = experiment_of(ts.Study.paper())
    for participant, key in (
        (experiment.agents[1], "spots"),
        (experiment.arms[0], "kind"),
        (experiment.task, "kind"),
    ):
        with pytest.warns(DeprecationWarning, match=rf'\["{key}"\] is now \w+\.{key};'):
            assert participant[key] == getattr(participant, key)
    with pytest.raises(KeyError, match="no_such_key"):
        experiment.task["no_such_key"]
