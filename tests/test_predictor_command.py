"""Predictors on recorded motion: errors in closed form, the noise that made a motion, and the command."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import telespring as ts
from telespring.analysis import HandMotion, compare_predictors, write_template
from telespring.cli import app

RADIUS, SPEED = 0.05, 4.0


def circle(step: float = 0.005, seconds: float = 20.0) -> HandMotion:
    time = np.arange(0.0, seconds, step)
    angle = SPEED * time
    position = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    velocity = RADIUS * SPEED * np.column_stack([-np.sin(angle), np.cos(angle)])
    return HandMotion("circle", time, position, velocity, position + np.array([0.01, -0.02]))


def test_ref_errors_on_a_circle() -> None:
    delays = (0.05, 0.1, 0.25)
    comparison = compare_predictors([circle()], delays)
    errors = {entry.label: entry.errors for entry in comparison.predictors}
    phase = SPEED * np.array(delays)
    # hold: |1 - e^(jφ)|; linear: |1 + jφ - e^(jφ)|
    assert errors["hold"] == pytest.approx(RADIUS * np.abs(1 - np.exp(1j * phase)), rel=1e-4)
    assert errors["linear"] == pytest.approx(RADIUS * np.abs(1 + 1j * phase - np.exp(1j * phase)), rel=1e-3)
    assert errors["shared target"] == pytest.approx([0.0] * 3, abs=1e-5)
    assert comparison.best.label == "shared target"
    assert comparison.best_without_target.label.startswith("kalman, constant acceleration")
    # at any noise, a filter that knows the acceleration beats a line on a circle
    kalman = min(entry.errors[1] for entry in comparison.predictors if "acceleration" in entry.label)
    assert kalman < errors["linear"][1]


def test_law_without_velocities_the_last_two_samples_give_them() -> None:
    known = circle()
    errors = [
        compare_predictors([motion], [0.1]).predictors[1].errors[0]
        for motion in (known, known._replace(velocity=None))
    ]
    # half a sample older
    assert errors[1] == pytest.approx(RADIUS * abs(1 + 0.4j - np.exp(0.4j)), rel=0.1)
    assert errors[1] > errors[0]


def test_ref_the_noise_that_made_the_motion_is_found() -> None:
    random = np.random.default_rng(5)
    step, process, noise = 0.005, 2.0, 2e-4
    # white acceleration over a step: a kick of the velocity, half of it on the way, the rest independent
    kicks = random.normal(size=(6000, 2)) * np.sqrt(process * step)
    apart = random.normal(size=(6000, 2)) * np.sqrt(process * step**3 / 12)
    before = np.cumsum(kicks, axis=0) - kicks
    place = np.cumsum(step * (before + 0.5 * kicks) + apart, axis=0)
    place += random.normal(size=(6000, 2)) * noise
    fit = ts.fit_noise(step * np.arange(6000), place, "constant-velocity")
    assert fit.end == "maximum"
    assert fit.process == pytest.approx(process, rel=0.1)
    assert fit.position == pytest.approx(noise, rel=0.05)
    assert fit.log_likelihood > ts.fit_noise(step * np.arange(6000), place).log_likelihood


def test_law_what_cannot_be_compared_is_refused() -> None:
    for motions, delays, field in (
        ([circle(seconds=1.05)], [0.1], "motions"),
        ([], [0.1], "motions"),
        ([circle()], [], "delays"),
        ([circle()], [0.1, -0.1], "delays[1]"),
        ([circle()._replace(position=np.zeros((4000, 2)))], [0.1], "circle: positions"),
    ):
        with pytest.raises(ts.InvalidInput) as refused:
            compare_predictors(motions, delays)
        assert refused.value.field == field
    with pytest.raises(ts.InvalidInput) as refused:
        ts.fit_noise([0.0, 1.0], [[0.0, 0.0]], "constant-jerk")
    assert refused.value.field == "model"


def run(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["predictor", *arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.fixture
def log(tmp_path: Path) -> Path:
    random = np.random.default_rng(2)
    motion = circle(0.002, 12.0)
    table = np.column_stack(
        [motion.time, (motion.position + 5e-5 * random.normal(size=motion.position.shape)).round(5)]
    )
    path = tmp_path / "hand.csv"
    np.savetxt(path, table, delimiter=",", header="time,position_x,position_y", comments="")
    return path


def test_law_the_command_compares_predictors_on_a_log(log: Path) -> None:
    status, screen, _ = run(str(log))
    assert status == 0
    assert len(screen.splitlines()) <= 30
    line = next(line for line in screen.splitlines() if line.startswith("predictor = "))
    settings = tomllib.loads(line)["predictor"]
    assert settings["kind"] == "kalman"
    # what is printed is what every criterion takes
    ts.hman().delay_system(71.0, 0.1, predictor=settings)
    status, text, _ = run(str(log), "--json", "--delay", "50ms", "--delay", "0.1")
    numbers = json.loads(text)
    assert numbers["delays"] == [0.05, 0.1]
    hold = next(entry for entry in numbers["predictors"] if entry["predictor"] == "hold")
    assert hold["rms"][1] == pytest.approx(RADIUS * abs(1 - np.exp(0.4j)), rel=0.01)


def test_law_the_command_reads_trials_with_their_target(tmp_path: Path) -> None:
    index = write_template(tmp_path / "lab")
    status, text, error = run(str(index.parent), "--json", "--delay", "50ms")
    assert status == 0, error
    numbers = json.loads(text)
    assert numbers["predictors"][-1]["predictor"] == "shared-target"
    assert numbers["motions"]["recorded"] % 2 == 0


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (["nowhere.csv"], "nowhere.csv"),
        (["{log}", "--delay", "-1"], "--delay"),
        (["{log}", "--delay", "84"], "--delay"),
        (["{log}", "--position", "1,2,3"], "--position"),
        (["{log}", "--position", "z"], "--position"),
        (["{log}", "--time", "t"], "--time"),
    ],
)
def test_law_the_command_refuses_in_a_few_lines(log: Path, arguments: list[str], field: str) -> None:
    status, _, error = run(*(argument.format(log=log) for argument in arguments))
    assert status == 2
    assert field in error
    assert len(error.splitlines()) <= 8
