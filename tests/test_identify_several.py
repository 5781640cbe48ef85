"""Several logs of one robot: the scatter between them is in the interval."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from typer.testing import CliRunner

from made_logs import TRUTH, made_log
from telespring import InvalidInput, cli
from telespring.identification import identify, identify_logs, robot_toml
from telespring.identification.combination import combine_estimates
from telespring.identification.results import Estimate
from telespring.study.robot_file import robot_record


def estimate(value: float, error: float) -> Estimate:
    return Estimate(value, error, (value - 1.959963984540054 * error, value + 1.959963984540054 * error))


def test_ref_hartung_and_knapp_by_their_closed_form() -> None:
    """DerSimonian and Laird's variance and Hartung and Knapp's interval, written out."""
    values, errors = np.array([95.06, 93.82, 94.9]), np.array([0.2, 0.25, 0.2])
    found = combine_estimates([estimate(v, e) for v, e in zip(values, errors, strict=True)])
    w = errors**-2.0
    mean = (w @ values) / w.sum()
    excess = w @ (values - mean) ** 2 - 2.0
    between = excess / (w.sum() - (w @ w) / w.sum())
    u = 1.0 / (between + errors**2)
    value = (u @ values) / u.sum()
    error = math.sqrt((u @ (values - value) ** 2) / (2.0 * u.sum()))
    assert found.estimate.value == pytest.approx(value, rel=1e-9)
    assert found.between == pytest.approx(math.sqrt(between), rel=1e-6)
    half = stats.t.ppf(0.975, 2) * error
    assert found.estimate.interval == pytest.approx((value - half, value + half), rel=1e-9)


def test_law_logs_that_agree_by_chance_give_no_narrower_interval_than_their_errors() -> None:
    found = combine_estimates([estimate(1.0, 0.1), estimate(1.0, 0.1)])
    low, high = found.estimate.interval
    # the mean of two: 0.1/√2
    assert high - low == pytest.approx(2.0 * 1.959963984540054 * 0.1 / math.sqrt(2.0), rel=1e-6)
    assert not found.disagree


@pytest.mark.parametrize("count", [2, 3, 6])
@pytest.mark.parametrize("scatter", [0.0, 3.0])
def test_law_the_interval_over_logs_holds_the_truth_in_95_percent(count: int, scatter: float) -> None:
    """600 times: chance is ±0.9 %. With no scatter the interval is wider than it must be."""
    random = np.random.default_rng(7)
    held = 0
    for _ in range(600):
        errors = random.uniform(0.5, 1.5, count)
        values = random.normal(10.0, np.hypot(errors, scatter))
        low, high = combine_estimates(
            [estimate(v, e) for v, e in zip(values.tolist(), errors.tolist(), strict=True)]
        ).estimate.interval
        held += low <= 10.0 <= high
    assert held / 600 > 0.92


def logs_with_gains(gains: tuple[float, ...]) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    return [made_log(np.random.default_rng(i), seconds=12.0, scale=gain) for i, gain in enumerate(gains)]


def test_law_several_logs_with_other_gains_hold_the_truth_that_each_alone_misses() -> None:
    logs = logs_with_gains((0.985, 1.0, 1.015))
    together = identify_logs(logs, force_delay=0.0)
    assert together.log_count == 3
    alone = [identify(*log, force_delay=0.0) for log in logs]
    for i, (mass, damping) in enumerate(TRUTH):
        for name, truth in (("mass", mass), ("damping", damping)):
            low, high = together.axes[i].estimates[name].interval
            assert low <= truth <= high
            intervals = [each.axes[i].estimates[name].interval for each in (alone[0], alone[2])]
            if name == "damping":
                # the first and the last exclude each other
                assert intervals[0][1] < intervals[1][0]
    told = [warning for warning in together.warnings if "the logs disagree about the damping" in warning]
    assert len(told) == 2
    assert "include their scatter" in together.outside_intervals
    assert "from one log" in alone[0].outside_intervals


def test_law_a_term_that_one_log_needs_is_in_the_model_of_all() -> None:
    logs = [made_log(np.random.default_rng(i), drag=drag, seconds=12.0) for i, drag in enumerate((0.0, 8.0))]
    found = identify_logs(logs)
    for each in found.logs:
        assert all("drag" in axis.estimates for axis in each.axes)


def test_law_logs_of_different_robots_are_refused() -> None:
    time, position, force = made_log(np.random.default_rng(1), seconds=12.0)
    with pytest.raises(InvalidInput, match="2 and 1 axes"):
        identify_logs([(time, position, force), (time, position[:, :1], force[:, :1])])
    with pytest.raises(InvalidInput, match="at least one log"):
        identify_logs([])


def test_law_the_command_takes_several_logs_and_the_robot_file_counts_them(tmp_path: Path) -> None:
    paths = []
    for number, (time, position, force) in enumerate(logs_with_gains((0.99, 1.01))):
        path = tmp_path / f"log{number}.csv"
        columns = {"time": time, "position_x": position[:, 0], "position_y": position[:, 1]}
        pd.DataFrame(columns | {"force_x": force[:, 0], "force_y": force[:, 1]}).to_csv(path, index=False)
        paths.append(str(path))
    robot, figure = tmp_path / "robot.toml", tmp_path / "residuals.png"
    runner = CliRunner(env={"COLUMNS": "120", "NO_COLOR": "1"})
    screen = runner.invoke(
        cli.app, ["identify", *paths, "--out", str(robot), "--figure", str(figure)], catch_exceptions=False
    )
    assert screen.exit_code == 0
    assert "Each log alone" in screen.stdout
    assert "The intervals are from 2 logs and include their scatter" in " ".join(screen.stdout.split())
    assert robot_record(robot).logs == 2
    assert figure.stat().st_size > 0
    answer = json.loads(runner.invoke(cli.app, ["identify", *paths, "--json"]).stdout)
    assert answer["logs"] == 2
    assert len(answer["each_log"]) == 2
    assert answer["log"] == "log0.csv, log1.csv"
    low, high = answer["axes"][0]["damping_interval"]
    assert low < answer["each_log"][0][0]["damping"] < answer["each_log"][1][0]["damping"] < high


def test_law_a_spring_that_the_logs_together_do_not_show_is_not_in_the_robot_file() -> None:
    """Springs of 5 and 0.5 N/m: each log is sure of its own, and two logs leave the spring open down to 0."""
    logs = [made_log(np.random.default_rng(seed), spring=spring) for seed, spring in ((1, 5.0), (2, 0.5))]
    found = identify_logs(logs)
    assert found.axes[0].stiffness is not None
    assert found.axes[0].stiffness.interval[0] < 0.0
    assert "stiffness" not in tomllib.loads(robot_toml(found, "open"))["identification"]
    assert any("do not show a spring" in warning for warning in found.warnings)
    sure = tomllib.loads(robot_toml(identify_logs(logs[:1]), "sure"))["identification"]
    assert abs(sure["stiffness"][0] - 5.0) < 0.2
