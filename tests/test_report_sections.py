"""The report is made of any of its sections: no template needs what another section computes."""

from __future__ import annotations

import re
from collections.abc import Mapping
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
        replace(section, find=lambda _, name=section.name: results[name])  # type: ignore[misc]
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
