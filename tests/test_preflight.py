"""What a report and `rehearse` say of a study of one's own: its laboratory, and what will spoil trials."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app
from telespring.paper import PARTS, Analysis, analyse
from telespring.paper.scene import Scene
from telespring.rehearsal.preflight import preflight_warnings
from telespring.rehearsal.target import target_path
from telespring.show.screens.rehearsal import preflight_sentence

#: A site's file is the live program's, whose own tests read it.
EXAMPLES = sorted(
    path
    for path in (Path(__file__).resolve().parent.parent / "examples").glob("*.toml")
    if not path.stem.startswith("site-")
)

#: What the page says of the laboratory and its trials.
LABORATORY = [part for part in PARTS if part.name in ("summary", "model", "laboratory", "experiment")]

#: Two periods of the paper's target, its first left out.
BRIEF = {"trials": 2, "duration": 4.852, "discard": 2.426}


def read(name: str) -> ts.Study:
    return ts.Study.read(next(path for path in EXAMPLES if path.stem == name))


def warnings_of(study: ts.Study) -> list[str]:
    return [preflight_sentence(warning) for warning in preflight_warnings(study)]


def brief(study: ts.Study) -> ts.Study:
    return study.replace(protocol=BRIEF)


def section(found: Analysis, anchor: str) -> str:
    matched = re.search(
        rf'<figure id="{anchor}">.*?</figure>|<table id="{anchor}".*?</table>', found.html, re.S
    )
    assert matched is not None
    return matched[0]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_law_the_study_of_every_example_is_whole(path: Path) -> None:
    parts = [part for part in PARTS if part in LABORATORY or part.name == "arms"]
    found = analyse(brief(ts.Study.read(path)), modules=path.parent, parts=parts)
    assert json.loads(json.dumps(found.numbers, allow_nan=False)) == found.numbers
    assert 'id="figure-laboratory"' in found.html
    assert found.numbers["experiment"]["finished"] > 0


def test_law_all_that_is_simulated_is_listed() -> None:
    found = analyse(brief(read("two-link")), parts=LABORATORY)
    listed = {
        (each["part"], each["name"]): each["value"] for each in found.numbers["laboratory"]["parameters"]
    }
    for part, name, value in (
        ("robot 1", "Coulomb friction, x", 0.3),
        ("robot 2", "Coulomb friction, y", 0.5),
        ("arm 1", "mass of link 1", 0.9),
        ("arm 2", "inertia of actuator at joint 2", 0.01),
        ("controllers", "a force acts", "one period after its samples"),
        ("controllers", "lag of the actuators", 0.002),
        ("controllers", "resolution of the encoders", 1e-5),
        ("network", "jitter, largest additional delay of a packet", 0.005),
        ("network", "probability that a packet is lost", 0.02),
    ):
        assert listed[part, name] == value
    damped = ts.Study.paper().replace(coupling={"damping": 2.0})
    [row] = [
        each
        for each in analyse(damped, parts=LABORATORY[:-1]).numbers["laboratory"]["parameters"]
        if each["part"] == "coupling"
    ]
    assert (row["name"], row["value"], row["unit"]) == ("damping", 2.0, "N·s/m")


def test_law_a_study_of_ones_own_shows_its_own_laboratory() -> None:
    own = analyse(brief(read("two-link")), parts=LABORATORY)
    for shown in (section(own, "figure-laboratory"), section(own, "table1")):
        assert "H-MAN" not in shown
        assert "printed" not in shown
        assert "‡" not in shown
    assert "handles of light and heavy" in own.html
    # the paper's robots on another task with another agent are not its experiment
    other = analyse(brief(read("tremor")), modules=EXAMPLES[0].parent, parts=LABORATORY)
    assert all(row["printed"] is None for row in other.numbers["table1"])
    assert "two-link" not in section(other, "figure-laboratory")
    papers = analyse(brief(ts.Study.paper()), parts=LABORATORY)
    assert "had two-link arms, drawn dashed" in section(papers, "figure-laboratory")
    # two trials can have no arrow, so that none of them differs from a printed one
    table = section(papers, "table1")
    assert table.count(" †") >= 33
    assert "‡</span>" not in table
    assert {
        each["agrees"] for each in papers.numbers["experiment"]["reported"] if "rank" in each["test"]
    } == {None}
    four = analyse(brief(ts.Study.paper()).replace(protocol={"trials": 4}), parts=LABORATORY)
    table = section(four, "table1")
    assert table.count("‡</span>") == table.count('class="differs"') > 0
    assert "‡: the arrow here differs" in table
    unconnected = four.numbers["table1"][0]
    # nothing is random in robot 1 alone: one trial, and 2 of the 5 places that it can have among five
    assert (unconnected["te1_n"], unconnected["te1_copies"], unconnected["te1_least_p"]) == (1, 3, 0.4)
    assert unconnected["te1_untestable"] is True
    assert "TE₁ in UM" in four.html
    [paragraph] = [each for each in four.html.split("<p>") if "repeat another one to the nanometre" in each]
    words = " ".join(re.sub("<[^>]*>", "", paragraph.split("</p>")[0]).split())
    assert words.startswith(
        "Trials that repeat another one to the nanometre do not count: TE₁ in UM: 3, so n = 1"
    )
    assert "1 and p cannot be below 0.4" in words
    assert words.endswith("Where n = 1 nothing is random, and more trials do not help.")
    assert "p is smaller where trials differ: judge by the size" in four.html


def test_law_the_papers_experiment_is_its_robots_task_and_agents() -> None:
    def of_the_paper(values: dict[str, dict[str, object]]) -> bool:
        return Scene.of(ts.Study.paper().replace(**values)).of_the_papers_experiment

    # other trials, and arms that the paper may have had, are still it
    assert of_the_paper({"protocol": {"trials": 3}, "arm1": {"kind": "lumped", "mass": 0.5}})
    others: tuple[dict[str, dict[str, object]], ...] = (
        {"task": {"angular_frequency": 2.0}},
        {"agent2": {"kind": "skilled"}},
        {"robot1": {"mass": 1.0}},
    )
    for other in others:
        assert not of_the_paper(other)


def test_ref_the_targets_path_is_what_the_trials_follow() -> None:
    study = read("tremor")
    assert study.experiment is not None
    path = target_path(study.experiment, EXAMPLES[0].parent)
    # the example's circle, of radius 0.08 m
    assert np.hypot(*path.T) == pytest.approx(0.08, abs=1e-12)


def test_ref_what_will_spoil_the_trials_has_a_warning() -> None:
    assert warnings_of(ts.Study.paper()) == []
    lost = ts.Study.paper().replace(network={"loss": 1.0, "jitter": 30.0}, allow_unusual=True)
    jitter, loss = warnings_of(lost)
    assert "jitter = 30 s is no shorter than a trial of 29.111 s" in jitter
    assert "no packet ever arrives" in loss
    # 450 mm below the centre and 120 mm above it, an arm of 600 mm has 30 mm left
    assert warnings_of(read("two-link")) == []
    near = read("two-link").replace(arm2={"base": [0.0, -0.47]})
    [warning] = warnings_of(near)
    assert "arm2: the target comes within 10 mm of its full reach of 600 mm, at (0, 120) mm" in warning
    far = read("two-link").replace(arm1={"base": [0.0, -0.5]})
    assert "arm1: the target goes 20 mm beyond its full reach" in warnings_of(far)[0]
    folded = read("two-link").replace(arm1={"link_length": [0.55, 0.2]})
    assert "arm1: the target goes 20 mm inside its shortest reach of 350 mm" in warnings_of(folded)[0]


def test_law_rehearse_names_arm_condition_and_time(tmp_path: Path) -> None:
    study = brief(read("two-link")).replace(arm2={"base": [0.0, -0.5]})
    (tmp_path / "far.toml").write_text(study.to_toml(), encoding="utf-8")
    run = CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"}).invoke(
        app, ["rehearse", str(tmp_path / "far.toml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    )
    assert run.exit_code == 0, run.output
    assert "Warning: arm2: the target goes 20 mm beyond its full reach" in run.output
    [line] = [each for each in run.output.splitlines() if each.startswith("UM ")]
    told = re.search(r"2 out of reach of arm 2, the first at (\d\.\d+) s$", line.rstrip())
    assert told is not None, run.output
    # the target is highest after a quarter of its period
    assert 0.2 < float(told[1]) < 0.6 * np.pi / 1.6


def _first_answer(study: ts.Study, modules: Path | None = None) -> tuple[dict[str, Any], str]:
    found = analyse(study, modules=modules, parts=[part for part in PARTS if part.name == "summary"])
    matched = re.search(r'<section id="summary".*?</section>', found.html, re.S)
    assert matched is not None
    words = " ".join(re.sub("<[^>]*>", "", matched[0]).split())
    return found.numbers["summary"]["answer"], f"{matched[0].split('>')[0]}> {words}"


def test_law_the_first_answer_says_what_arms_and_agents_change() -> None:
    condition = {"coupling": {"stiffness": 60.0}, "network": {"delay": 0.15}}
    arm, agent = {"kind": "lumped", "mass": 5.0}, {"kind": "skilled", "stiffness": 0}
    heavy = ts.Study.paper().replace(arm1=arm, arm2=arm, agent1=agent, agent2=agent, **condition)
    answer, words = _first_answer(heavy)
    # the arms as operators, by the characteristic roots
    held = ts.Dyad(*ts.hman().robots, (ts.Operator(mass=5.0), ts.Operator(mass=5.0)))
    assert max(axis.spectral_abscissa(60.0, 0.15) for axis in held) > 0.0
    assert (answer["status"], answer["in_arms"]["stable"]) == ("stable", False)
    assert 'class="answer unstable"' in words
    assert "with them and continuous controllers the dyad is UNSTABLE." in words
    # conditions of the protocol, by the roots with free handles
    assert heavy.experiment is not None
    unstable = [
        {"stiffness": k, "delay": delay}
        for k, delay in heavy.experiment.conditions
        if k is not None and max(axis.spectral_abscissa(k, delay) for axis in ts.hman()) > 0.0
    ]
    assert answer["unstable_conditions"] == unstable
    assert ("unstable with free handles:" in words) == bool(unstable)
    # an agent that is a program: nobody knows its stiffness
    tremor = read("tremor").replace(**condition)
    answer, words = _first_answer(tremor, EXAMPLES[0].parent)
    assert answer["in_arms"]["known"] is False
    assert "stability with them is not known: agent" in words
    # the paper's own study names neither arms nor agents
    answer, words = _first_answer(ts.Study.paper().replace(**condition))
    assert answer["in_arms"] is None
    assert "arms and agents hold" not in words
