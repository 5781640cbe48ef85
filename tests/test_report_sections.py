"""The report is made of any of its sections: no template needs what another section computes."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain, combinations

import numpy as np
import pytest

import telespring as ts
from telespring.paper import PARTS, STEPS, Analysis, Findings, Scene, Section, analyse
from telespring.paper.page import render_section
from telespring.paper.sections import SECTIONS

#: One axis and an arm on one side: no laboratory, and so no findings of the sections about it.
ONE_AXIS = """
robot1 = {mass = 1.2, damping = 6.0}
robot2 = {mass = 0.7, damping = 9.0}
operator2 = {mass = 0.5, damping = 1.0, stiffness = 40.0}
coupling.stiffness = 30.0
network.delay = 0.05
"""


@pytest.fixture(scope="module")
def paper() -> ts.Study:
    """Return the paper's study with short trials."""
    return ts.Study.paper().replace(protocol={"trials": 2, "duration": 4.852, "discard": 2.426})


@pytest.fixture(scope="module")
def findings(paper: ts.Study, analysis: Analysis) -> dict[str, Findings]:
    """Compute every section once; only the calibration, which takes long, is the whole study's."""
    scene = Scene.of(paper)
    results = {
        section.name: section.find(scene)
        for section in PARTS
        if section.find is not None and section.name != "calibration"
    }
    drawings = {"calibration": "<svg></svg>"}
    results["calibration"] = Findings({"calibration": analysis.numbers["calibration"]}, drawings)
    return results


def with_results(results: Mapping[str, Findings]) -> list[Section]:
    """Return all sections that compute something, each with its results at hand."""
    return [
        replace(section, find=lambda _, name=section.name: results[name], start=None)  # type: ignore[misc]
        for section in PARTS
    ]


def test_law_a_section_is_declared_once_and_its_folder_has_its_name() -> None:
    names = [section.name for section in SECTIONS]
    assert len(set(names)) == len(names)
    assert len({section.anchor for section in SECTIONS}) == len(names)
    assert set(PARTS) == {section for section in SECTIONS if section.find is not None}
    assert len(set(STEPS)) == len(PARTS) + 1
    for section in SECTIONS:
        assert set(section.mentions) <= set(names) - {section.name}


def test_law_no_two_sections_share_a_key_or_a_drawing(findings: dict[str, Findings]) -> None:
    for own in ([result.numbers for result in findings.values()], [r.drawings for r in findings.values()]):
        keys = list(chain.from_iterable(own))
        assert len(set(keys)) == len(keys)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.name)
def test_law_a_section_needs_no_other_section(
    section: Section, paper: ts.Study, findings: dict[str, Findings]
) -> None:
    """Every subset of the 15 parts renders.

    `render_section` shows a template its own results and those that it mentions, nothing else, and what is
    undefined is an error. So all that another section's absence can change is a subset of the mentioned.
    """
    study = Scene.of(paper).describe_study()
    for count in range(len(section.mentions) + 1):
        for mentioned in combinations(section.mentions, count):
            html = render_section(
                section, study, {n: findings[n] for n in (section.name, *mentioned) if n in findings}
            )
            assert f'id="{section.anchor}"' in html
            assert (
                re.findall(r"<svg ", html) == ["<svg "] * html.count("<figure id=")
                or section.name == "calibration"
            )


@pytest.mark.parametrize("of_paper", [True, False])
def test_law_a_report_of_any_sections_is_made(
    of_paper: bool, paper: ts.Study, findings: dict[str, Findings]
) -> None:
    study = paper
    if not of_paper:
        study = ts.Study.from_toml(ONE_AXIS)
        scene = Scene.of(study)
        findings = {section.name: section.find(scene) for section in PARTS if section.find is not None}
    parts = with_results(findings)
    random = np.random.default_rng(15)
    subsets = [[], *([part] for part in parts), *([p for p in parts if p is not part] for part in parts)]
    subsets += [[part for part in parts if random.random() < 0.5] for _ in range(30)]
    for subset in subsets:
        report = analyse(study, parts=subset)
        keys = {key for part in subset for key in findings[part.name].numbers}
        assert set(report.numbers) == {"schema", "study", *keys}
        shown = {part.anchor for part in subset if findings[part.name] != Findings()}
        assert {section.anchor for section in SECTIONS if f'id="{section.anchor}"' in report.html} == {
            *shown,
            "reading",
        }
        identifiers = re.findall(r' id="([^"]+)"', report.html)
        assert set(re.findall(r'<a href="#([^"]+)"', report.html)) <= set(identifiers)


def test_law_a_condition_has_one_verdict_wherever_it_is_judged(analysis: Analysis) -> None:
    """Fig. 5, the map and the table of arms judge free handles; the one in Fig. 5(h) is marginal on x."""
    judged: dict[tuple[float, float], dict[str, str]] = {}
    for panel in analysis.numbers["responses"]["panels"]:
        judged.setdefault((panel["stiffness"], panel["delay"]), {})[panel["axis"]] = panel["verdict"]
    shared = 0
    for condition in analysis.numbers["arms"]["conditions"]:
        verdicts = judged.get((condition["stiffness"], condition["delay"]))
        if verdicts is None:
            continue
        shared += 1
        for word, axes in (("unstable", "unstable_axes_free"), ("marginal", "marginal_axes_free")):
            assert condition[axes] == [axis for axis, verdict in verdicts.items() if verdict == word]
        order = ("stable", "marginal", "unstable")
        assert condition["free"] == max(verdicts.values(), key=order.index)
        assert (condition["free"] == "marginal") == (verdicts == {"x": "marginal", "y": "stable"})
    assert shared == 16
    assert re.search(r'<td class="marginal">marginal on x</td>', analysis.html)


def test_law_the_first_screen_explains_its_condition_and_its_numbers(analysis: Analysis) -> None:
    numbers = analysis.numbers
    assert numbers["summary"]["answer"]["figure_5_panel"] == "h"
    first = re.sub(r"<[^>]+>", "", analysis.html[: analysis.html.index('id="allowed"')])
    assert "This is the condition of the paper's Fig. 5(h)" in first
    compared = numbers["experiment"]["compared"]
    assert compared["unstable_conditions"] == [
        f"CM-{condition['stiffness']:.0f}-{1e3 * condition['delay']:.0f}"
        for condition in numbers["arms"]["conditions"]
        if condition["in_arms"] == "unstable"
    ]
    squares = {
        row["condition"]: [(row[f"{te}_mean"] - row["printed"][f"{te}_mean"]) ** 2 for te in ("te1", "te2")]
        for row in numbers["table1"]
    }
    everything = [each for pair in squares.values() for each in pair]
    stable = [
        each for name, pair in squares.items() if name not in compared["unstable_conditions"] for each in pair
    ]
    assert (len(everything), len(stable)) == (34, 28)
    assert compared["rms_difference"] == pytest.approx(np.sqrt(np.mean(everything)), rel=1e-12)
    assert compared["rms_difference_stable"] == pytest.approx(np.sqrt(np.mean(stable)), rel=1e-12)
    # TE2 in the unconnected mode is what the others are compared with
    assert compared["arrows"] == numbers["calibration"]["hypotheses"][0]["arrows"]["of"] == 33


def test_law_p_reads_alike_however_it_was_found(analysis: Analysis) -> None:
    """In the report as on the screen: below 0.001 no digits, whether permutations bound p or count it."""
    rows = analysis.numbers["experiment"]["kruskal_wallis"]
    assert any(row["is_p_bound"] for row in rows)
    table = analysis.html[analysis.html.index('id="group-tests"') :]
    table = table[: table.index("</table>")]
    assert "9,999 random permutations" in table
    assert "≤" not in table
    for i, row in enumerate(rows):
        for name in ("p", "p_holm"):
            if row[name] is not None:
                shown = table.split(f'data-key="experiment.kruskal_wallis.{i}.{name}">')[1].split("</data>")[
                    0
                ]
                assert (shown == "&lt; 0.001") == (row[name] < 0.001)


@pytest.mark.parametrize(
    ("stiffness", "delay", "panel"),
    [
        (71.23, 0.167, "h"),
        (35.616, 0.0836, "d"),
        (142.46, 0.334, "l"),
        (71.23, 0.1, None),
        (60.0, 0.167, None),
    ],
)
def test_law_a_condition_of_figure_5_is_recognised(stiffness: float, delay: float, panel: str | None) -> None:
    study = ts.Study.paper().replace(coupling={"stiffness": stiffness}, network={"delay": delay})
    [summary] = [section for section in PARTS if section.name == "summary"]
    assert summary.find is not None
    assert summary.find(Scene.of(study)).numbers["summary"]["answer"]["figure_5_panel"] == panel


def test_law_a_computation_beside_the_others_ends_with_the_report() -> None:
    """An error in another section, or Ctrl-C, must neither wait for the fits nor leave processes behind."""
    ended = []

    @contextmanager
    def start(_: Scene) -> Iterator[Callable[[], Findings]]:
        try:
            yield Findings
        finally:
            ended.append(True)

    def fail(_: Scene) -> Findings:
        raise KeyboardInterrupt

    parts = [
        Section("failing", "failing", step="failing", find=fail),
        Section("beside", "beside", step="beside", find=lambda _: Findings(), start=start),
    ]
    with pytest.raises(KeyboardInterrupt):
        analyse(ts.Study.paper(), parts=parts)
    assert ended == [True]


def test_law_fits_that_are_not_awaited_end_at_once() -> None:
    [calibration] = [section for section in PARTS if section.name == "calibration"]
    assert calibration.start is not None
    threads = threading.active_count()
    with calibration.start(Scene.of(ts.Study.paper())):
        assert threading.active_count() > threads
    # the fits take a minute; the test's own limit would end it
    assert threading.active_count() == threads
