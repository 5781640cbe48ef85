"""The answers of the page, run by Node.js, against those of `telespring decide --json`."""

from __future__ import annotations

import json
import math
import os
import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import telespring as ts
from telespring.decision.decide import decide_case
from telespring.decision.question import Question
from telespring.show.decision_json import decision_json

CORE = "out/page/telespring.wasm"


def needs(root: Path) -> None:
    if shutil.which("node") is None:
        pytest.skip("NO NODE.JS HERE: the page's answers are not compared")
    if not (root / CORE).is_file():
        pytest.skip("NO PAGE HERE: 'make page' builds it")


def random_study(draw: random.Random) -> ts.Study:
    """Draw a study as laboratories have them."""

    def decade(least: float, most: float) -> float:
        return float(f"{least * (most / least) ** draw.random():.4g}")

    axes = draw.choice([1, 1, 2])
    text = ""
    for robot in (1, 2):
        mass = [decade(0.1, 10.0) for _ in range(axes)]
        damping = [decade(0.5, 50.0) for _ in range(axes)]
        text += f"[robot{robot}]\nmass = {mass}\ndamping = {damping}\n"
        if draw.random() < 0.1:
            text += f"ground_stiffness = {decade(1.0, 100.0)}\n"
        if draw.random() < 0.3:
            text += f"[operator{robot}]\nstiffness = {decade(5.0, 500.0)}\ndamping = {decade(0.1, 10.0)}\n"
    text += f"[coupling]\nstiffness = {decade(2.0, 2000.0)}\n"
    if draw.random() < 0.15:
        text += f"damping = {decade(0.01, 5.0)}\n"
    text += "[network]\n"
    if draw.random() < 0.8:
        text += f"delay = {decade(0.001, 0.4)}\n"
    else:
        text += f"delay = {{forward = {decade(0.001, 0.4)}, backward = {decade(0.001, 0.4)}}}\n"
    if draw.random() < 0.2:
        text += f"jitter = {decade(0.001, 0.05)}\nplayout_buffer = {draw.choice(['true', 'false'])}\n"
    if draw.random() < 0.1:
        text += f"max_gap = {decade(0.001, 0.05)}\n"
    if draw.random() < 0.05:
        text += f"loss = {decade(0.001, 0.05)}\n"
    period = draw.choice([0.0, 0.001, 0.002])
    text += f"[controller]\nsample_period = {period}\n"
    if draw.random() < 0.2:
        text += f"computing_time = {period * draw.choice([0.1, 0.5, 1.0])}\n"
    return ts.Study.from_toml(text)


def native(study: ts.Study) -> dict[str, Any]:
    """Return the answer of the command for held and for free handles, without the search for changes."""
    question = Question.of_study(study)

    def answer(asked: Question) -> dict[str, Any]:
        return decision_json(decide_case(asked, study.stiffness))

    return {**answer(question), "free": answer(question.released()) if question.is_held else None}


def differences(page: Any, command: Any, where: str = "") -> list[str]:
    """List where what both have differs: numbers by more than 1e-9, above that of a nanosecond or so."""
    if isinstance(page, dict) and isinstance(command, dict):
        pairs = [(key, page[key], command[key]) for key in sorted(page.keys() & command.keys())]
    elif isinstance(page, list) and isinstance(command, list) and len(page) == len(command):
        pairs = [(str(i), *both) for i, both in enumerate(zip(page, command, strict=True))]
    elif isinstance(page, float | int) and isinstance(command, float | int):
        is_same = math.isclose(page, command, rel_tol=1e-9, abs_tol=1e-9)
        return [] if is_same else [f"{where}: {page} {command}"]
    else:
        return [] if page == command else [f"{where}: {page} {command}"]
    return [found for key, one, other in pairs for found in differences(one, other, f"{where}.{key}")]


def on_the_page(root: Path, studies: list[ts.Study]) -> list[dict[str, Any]]:
    runner = root / "crates/telespring-wasm/tests/node.mjs"
    done = subprocess.run(
        ["node", str(runner), str(root / CORE), str(root / "page/engine.js")],
        input=json.dumps([["decide", study.to_toml()] for study in studies]),
        capture_output=True,
        text=True,
        check=True,
    )
    answers: list[dict[str, Any]] = json.loads(done.stdout)
    return answers


def compare(root: Path, count: int, seed: int) -> None:
    needs(root)
    draw = random.Random(seed)
    studies = [random_study(draw) for _ in range(count)]
    words = set()
    for study, page in zip(studies, on_the_page(root, studies), strict=True):
        command = json.loads(json.dumps(native(study)))
        words.add(command["status"])
        assert {"status", "remedies", "verdicts", "axes"} <= page.keys() & command.keys()
        assert differences(page, command) == [], study.to_toml()
    assert words == {"stable", "marginal", "unstable", "not proven"}


def test_cross_the_page_answers_as_the_command_does(root: Path) -> None:
    compare(root, 120, 4)


@pytest.mark.verify
def test_cross_the_page_answers_as_the_command_does_ten_thousand_times(root: Path) -> None:
    compare(root, 10_000, int(os.environ.get("TELESPRING_VERIFY", "1")))


def test_ref_the_papers_study_on_the_page_is_that_of_the_command(root: Path) -> None:
    needs(root)
    runner = root / "crates/telespring-wasm/tests/node.mjs"
    done = subprocess.run(
        ["node", str(runner), str(root / CORE), str(root / "page/engine.js")],
        input=json.dumps([["study", ""], ["decide", ""]]),
        capture_output=True,
        text=True,
        check=True,
    )
    values, answer = json.loads(done.stdout)
    study = ts.Study.from_toml(values["toml"])
    assert study.dyad == ts.hman()
    assert values["sample_period"] == 0.001
    assert answer["status"] == ts.decide(study).status
