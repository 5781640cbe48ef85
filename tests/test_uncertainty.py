"""What errors of mass and damping do to the margins."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import telespring as ts
from questions import decide
from telespring.cli import app
from telespring.decision.uncertainty import (
    DRAWS,
    Probability,
    delta_method,
    margin_uncertainty,
    sample_parameters,
    stable_probability,
)
from telespring.show.decision_json import decision_json

K = 71.231976
DELTA = 0.16718632


def known(mass: float = 0.01, damping: float = 0.1, correlation: float = 0.0) -> SimpleNamespace:
    return SimpleNamespace(mass_sd=[mass] * 2, damping_sd=[damping] * 2, correlation=[correlation] * 2)


def test_law_draws_have_the_moments_they_were_asked_for(hman: ts.Dyad) -> None:
    drawn = sample_parameters(hman, (known(0.02, 0.2, -0.6), None))
    m1, b1, m2, b2 = drawn[:, 0]
    # five standard errors of each moment
    assert m1.mean() == pytest.approx(0.8334, abs=5 * 0.02 / math.sqrt(DRAWS))
    assert b1.std() == pytest.approx(0.2, rel=5 / math.sqrt(2 * DRAWS))
    assert np.corrcoef(m1, b1)[0, 1] == pytest.approx(-0.6, abs=5 * 0.64 / math.sqrt(DRAWS))
    # what is certain stays
    assert set(m2) == {0.7776}
    assert set(b2) == {7.4208}
    np.testing.assert_array_equal(drawn, sample_parameters(hman, (known(0.02, 0.2, -0.6), None)))


def test_law_no_draw_is_unphysical(hman: ts.Dyad) -> None:
    drawn = sample_parameters(hman, (known(2.0, 20.0), known(2.0, 20.0)), draws=2000)
    assert (drawn[[0, 2]] >= 1e-4).all()
    assert (drawn[[1, 3]] >= 0.0).all()


@pytest.mark.parametrize("correlation", [-0.8, 0.0, 0.8])
def test_cross_delta_method_and_monte_carlo_agree_where_errors_are_small(
    hman: ts.Dyad, correlation: float
) -> None:
    errors = (known(0.004, 0.04, correlation), known(0.004, 0.04, correlation))
    found = margin_uncertainty(hman, errors, K, 0.1)
    for i, axis in enumerate(found.axes):
        critical, longest = delta_method(hman, errors, K, i)
        # quantiles of 20000 draws are known to 2 %, and the margins bend a little
        assert np.ptp(axis.critical_stiffness) == pytest.approx(2 * 1.96 * critical, rel=0.05)
        assert np.ptp(axis.maximum_delay) == pytest.approx(2 * 1.96 * longest, rel=0.05)


def test_ref_critical_stiffness_of_identical_certain_masses_in_closed_form() -> None:
    """k_m = (b1² + b2²)/(4m) for alike robots; with only b1 uncertain its deviation is b1 sd/(2m)."""
    robot = ts.Robot([1.0], [5.0])
    dyad = ts.Dyad(robot, robot)
    critical, _ = delta_method(dyad, (known(0.0, 0.05), None), 20.0)
    assert critical == pytest.approx(5.0 * 0.05 / 2.0, rel=1e-6)


def test_law_probability_goes_from_one_to_zero_through_the_boundary(hman: ts.Dyad) -> None:
    errors = (known(), known())
    at = [stable_probability(hman, errors, K, delay) for delay in (0.9 * DELTA, DELTA, 1.1 * DELTA)]
    assert at[0].value > 0.999
    assert at[1].value == pytest.approx(0.5, abs=0.05)
    assert at[2].value < 0.001
    assert all(0.0 < each.standard_error < 0.004 for each in at)
    # below the surely critical stiffness no delay matters
    assert stable_probability(hman, errors, 17.8, 50.0).value == 1.0


def test_law_certain_robots_give_the_plain_verdict(hman: ts.Dyad) -> None:
    for delay, stable in ((0.16, 1.0), (0.18, 0.0)):
        assert stable_probability(hman, (None, None), K, delay, draws=10).value == stable


def test_law_operators_are_added_to_the_robots() -> None:
    robot = ts.Robot([1.0], [5.0])
    held = ts.Dyad(robot, robot, operators=(ts.Operator(mass=0.5, damping=1.0), ts.Operator()))
    drawn = sample_parameters(held, (None, None), draws=3)
    np.testing.assert_array_equal(drawn[:, 0, 0], [1.5, 6.0, 1.0, 5.0])


def test_law_the_standard_error_of_a_sure_thing_is_not_zero() -> None:
    sure = Probability.of(np.ones(1000, dtype=bool))
    assert sure.value == 1.0
    assert 0.0 < sure.standard_error < 2e-3


def test_law_unbounded_delays_are_null_in_json(hman: ts.Dyad) -> None:
    found = decision_json(decide(hman, 20.0, 0.1, uncertainty=(known(), None)))["uncertainty"]
    assert found["worst"]["maximum_delay_interval"] == [None, None]
    assert found["worst"]["maximum_delay_unbounded_probability"] == 1.0
    assert decision_json(decide(hman, 20.0, 0.1))["uncertainty"] is None


def recommend_and_judge(seed: int, count: int, folder: Path) -> list[object]:
    """Ask the command what random pairs with errors may use, and judge exactly what it prints."""
    random = np.random.default_rng(seed)
    bad: list[object] = []
    for _ in range(count):
        files = []
        for name in ("one", "two"):
            mass, damping = random.uniform(0.4, 3.0), random.uniform(1.0, 12.0)
            file = folder / f"{name}.toml"
            file.write_text(
                f"[robot]\nmass = {mass}\ndamping = {damping}\n"
                f"mass_sd = {mass * random.uniform(0.002, 0.1)}\n"
                f"damping_sd = {damping * random.uniform(0.005, 0.25)}\n"
                f"mass_damping_correlation = {random.uniform(-0.8, 0.8)}\n"
            )
            files += ["--robot", str(file)]
        asked = ["decide", *files, "--delay", f"{random.uniform(5.0, 200.0):.4g}ms"]
        runner = CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"})
        screen = runner.invoke(app, asked).stdout
        told = re.search(r"You may use up to ([0-9.]+) N/m", screen)
        if told is None:
            assert "No stiffness is" in screen, screen
            continue
        judged = runner.invoke(app, [*asked, "--stiffness", told[1], "--check"])
        if judged.exit_code != 0 or "STABLE at" not in judged.stdout:
            bad.append((asked, told[1], judged.stdout))
    return bad


def test_law_what_is_recommended_is_called_stable_by_the_command(tmp_path: Path) -> None:
    assert recommend_and_judge(4, 12, tmp_path) == []


@pytest.mark.verify
def test_law_what_is_recommended_is_called_stable_by_the_command_at_length(tmp_path: Path) -> None:
    assert recommend_and_judge(int(os.environ.get("TELESPRING_VERIFY", "5")), 150, tmp_path) == []
