"""What a model of mass and damping lacks: springs, friction near rest, drag, gravity, lags and glitches."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import integrate
from typer.testing import CliRunner, Result

import telespring as ts
from made_logs import TRUTH, made_log
from telespring import InvalidInput, cli
from telespring._types import FloatArray
from telespring.identification import Excitation, Identification, identify, robot_toml
from telespring.identification.covariance import _kernel_sum  # the sum inside every interval
from telespring.identification.glitches import find_glitches

#: One frequency per axis, as in the paper's figure of eight.
SINE = Excitation([0.0], [0.25], angular_frequency=2.59)


def found_in(seed: int = 1, radius: float | None = None, **made: Any) -> Identification:
    log = made_log(np.random.default_rng(seed), radius=radius or 1.0, **made)
    return identify(*log, radius=radius)


def assert_true(found: Identification, errors: float = 4.0) -> None:
    """Check mass and damping of both axes against the truth, in standard errors."""
    for axis, truth in zip(found.axes, TRUTH, strict=True):
        for name, value in zip(("mass", "damping"), truth, strict=True):
            estimate = axis.estimates[name]
            assert abs(estimate.value - value) < errors * estimate.standard_error, (axis.axis, name)


def codes(found: Identification) -> set[str]:
    return {doubt.code for doubt in found.diagnostics}


# ---- springs


def test_ref_a_spring_is_estimated_beside_the_mass_and_named() -> None:
    """Without its term the mass would be 17 % too small: k/ω² at the movement's frequencies."""
    found = found_in(spring=5.0)
    assert_true(found)
    for axis in found.axes:
        assert axis.stiffness is not None
        assert abs(axis.stiffness.value - 5.0) < 4.0 * axis.stiffness.standard_error
        # the interval of the mass with a free lag; 0.0023 kg at a known one
        assert axis.half_width("mass") < 0.012
    assert codes(found) == {"spring"}
    assert "a spring of 5" in found.warnings[0]
    blind = identify(*made_log(np.random.default_rng(1), spring=5.0), stiffness=False, force_delay=0.0)
    assert blind.axes[0].mass.value < 0.75
    [told, _] = [warning for warning in blind.warnings if "--no-stiffness" in warning]
    assert "Leave out --no-stiffness for a mass of 0.83" in told


def test_law_a_known_lag_narrows_the_interval_beside_a_spring() -> None:
    log = made_log(np.random.default_rng(1), spring=5.0)
    known, unknown = identify(*log, force_delay=0.0), identify(*log)
    assert_true(known)
    assert known.axes[0].half_width("mass") < 0.7 * unknown.axes[0].half_width("mass")


@pytest.mark.parametrize("spring", [0.0, 3.0])
def test_law_one_frequency_cannot_tell_a_spring_from_a_mass_and_is_refused(spring: float) -> None:
    log = made_log(np.random.default_rng(1), movement=SINE, spring=spring)
    with pytest.raises(InvalidInput, match=r"a movement at one frequency, 0\.412 Hz") as refused:
        identify(*log)
    # 1/ω²
    assert f"{1.0 / 2.59**2:.2g} kg off the mass" in str(refused.value)
    assert "--no-stiffness" in refused.value.remedy
    ruled_out = identify(*log, stiffness=False)
    assert {"untested spring", "unknown lag"} <= codes(ruled_out)
    assert ruled_out.axes[0].time_shift is None
    if spring == 0.0:
        assert_true(ruled_out)


def written(tmp_path: Path, name: str, log: tuple[FloatArray, FloatArray, FloatArray]) -> Path:
    time, position, force = log
    columns = {"time": time, "position_x": position[:, 0], "position_y": position[:, 1]}
    path = tmp_path / name
    pd.DataFrame(columns | {"force_x": force[:, 0], "force_y": force[:, 1]}).to_csv(path, index=False)
    return path


def run(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "160", "NO_COLOR": "1"}).invoke(cli.app, list(map(str, arguments)))


def test_law_no_robot_file_comes_of_a_log_that_leaves_the_mass_open(tmp_path: Path) -> None:
    log = written(tmp_path, "log.csv", made_log(np.random.default_rng(1), movement=SINE, spring=3.0))
    refused = run("identify", log, "--out", tmp_path / "robot.toml")
    assert refused.exit_code == 2
    assert "a movement at one frequency" in " ".join(refused.stderr.split())
    assert not (tmp_path / "robot.toml").exists()


def test_law_a_study_takes_the_spring_with_the_robot(tmp_path: Path) -> None:
    """The margins from the robot file are those of the true robot with its spring, within 2 %."""
    log = written(tmp_path, "log.csv", made_log(np.random.default_rng(2), spring=3.0))
    robot = tmp_path / "robot.toml"
    assert run("identify", log, "--out", robot).exit_code == 0
    study = ts.Study.paper().with_robot(1, robot).with_robot(2, robot)
    mass, damping = zip(*TRUTH, strict=True)
    true = ts.Robot(list(mass), list(damping))
    held = ts.Operator(stiffness=[3.0, 3.0])
    dyad = ts.Dyad(true, true, operators=(held, held))
    for found, right in zip(study.dyad, dyad, strict=True):
        assert float(found.maximum_delay(77.0)) == pytest.approx(float(right.maximum_delay(77.0)), rel=0.02)
        free = ts.Dyad(true, true)[right.name]
        assert float(free.maximum_delay(77.0)) != pytest.approx(float(right.maximum_delay(77.0)), rel=0.02)


def test_law_a_force_that_pushes_away_gives_no_robot_file() -> None:
    found = found_in(spring=-3.0)
    assert_true(found)
    assert codes(found) == {"negative spring"}
    with pytest.raises(InvalidInput, match="pushes away from the middle"):
        robot_toml(found, "unstable")


def test_law_gravity_on_an_axis_that_turns_is_told_from_a_spring() -> None:
    """Travel of ±0.1 m on a radius of 0.06 m is ±95°, where the sine bends."""
    found = found_in(gravity=2.0, radius=0.06)
    assert_true(found)
    assert "gravity" in codes(found)
    assert found.axes[0].estimates["gravity_sine"].value == pytest.approx(2.0, abs=0.5)
    # on a slide it is a dependence on the position that the model lacks
    slide = identify(*made_log(np.random.default_rng(1), gravity=2.0, radius=0.06))
    assert any("the cube of the position" in warning for warning in slide.warnings)


# ---- friction and drag


def test_law_stiction_is_found_and_named_and_the_damping_is_right() -> None:
    found = found_in(coulomb=1.0, stiction=0.5)
    assert_true(found)
    assert codes(found) == {"stiction"}
    blind = identify(
        *made_log(np.random.default_rng(1), coulomb=1.0, stiction=0.5), stiction=False, force_delay=0.0
    )
    assert abs(blind.axes[0].damping.value - TRUTH[0][1]) > blind.axes[0].half_width("damping")
    assert any("--no-stiction" in warning for warning in blind.warnings)


def test_law_drag_is_found_and_named_and_the_damping_is_that_of_slow_movements() -> None:
    found = found_in(drag=5.0)
    assert_true(found)
    assert codes(found) == {"drag"}
    for axis in found.axes:
        assert abs(axis.estimates["drag"].value - 5.0) < 4.0 * axis.estimates["drag"].standard_error


def test_law_damping_that_depends_on_the_position_is_told() -> None:
    """2 N·s/m more at one end of the travel than in the middle."""
    found = found_in(uneven_damping=20.0)
    assert "omitted effect" in codes(found)
    assert any("position times velocity" in warning for warning in found.warnings)


def test_law_negative_friction_is_told_and_not_written_as_none_silently() -> None:
    found = found_in(coulomb=-0.4)
    assert "negative friction" in codes(found)
    assert tomllib.loads(robot_toml(found, "driven"))["robot"]["coulomb"] == [0.0, 0.0]
    # none at all: no key, no warning
    clean = found_in()
    assert clean.warnings == ()
    assert "coulomb" not in tomllib.loads(robot_toml(clean, "clean"))["robot"]


def test_cross_an_integrated_robot_with_friction_near_rest_is_identified() -> None:
    """A servo drives m x'' = F − b x' − friction, integrated by scipy with a smooth Stribeck curve."""
    mass, damping, command = 0.9, 8.0, ts.identification.paper_excitation()

    def friction(v: float) -> float:
        return float(np.tanh(v / 1e-3) * (0.8 + 0.3 * np.exp(-((v / 0.02) ** 2))))

    def servo(t: float, x: float, v: float) -> float:
        return float(200.0 * (command.velocity(t) - v) + 2000.0 * (command.position(t) - x))

    def change(t: float, state: FloatArray) -> list[float]:
        x, v = state
        return [v, (servo(t, x, v) - damping * v - friction(v)) / mass]

    time = np.arange(12000) / 1000.0
    start = [float(command.position(0.0)), float(command.velocity(0.0))]
    run = integrate.solve_ivp(change, (0.0, 12.0), start, "LSODA", time, rtol=1e-8, atol=1e-10, max_step=0.01)
    force = np.array([servo(t, x, v) for t, x, v in zip(time, *run.y, strict=True)])
    noise = np.random.default_rng(1).normal(0.0, 0.05, time.size)
    [axis] = identify(time, run.y[0], force + noise).axes
    for estimate, truth in ((axis.mass, mass), (axis.damping, damping)):
        # a smooth sign of a velocity is not the model's: two half-widths
        low, high = estimate.interval
        assert abs(estimate.value - truth) < high - low
        assert high - low < 0.05 * truth


# ---- glitches


def test_law_glitches_are_found_where_they_were_put_and_nowhere_else() -> None:
    random = np.random.default_rng(1)
    time, position, force = made_log(random, rate=200.0)
    places = np.sort(random.choice(np.arange(50, 3950), 80, replace=False))
    for signal, is_force in ((position[:, 0], False), (force[:, 0], True)):
        assert not find_glitches(signal, 200.0, is_force=is_force).any()
        zeros, spikes, frozen = signal.copy(), signal.copy(), signal.copy()
        zeros[places] = 0.0
        found = find_glitches(zeros, 200.0, is_force=is_force)
        near_zero = np.abs(signal[places]) < 0.1 * np.abs(signal).max()
        assert found[places[~near_zero]].all()
        # two dropouts with one good sample between them may take it along
        assert np.count_nonzero(found) < 1.1 * places.size
        spikes[places[::4]] += np.ptp(signal)
        found = find_glitches(spikes, 200.0, is_force=is_force)
        assert found[places[::4]].all()
        assert np.count_nonzero(found) < 1.15 * places[::4].size
        for start in range(300, 3900, 600):
            frozen[start : start + 12] = frozen[start]
        assert np.count_nonzero(find_glitches(frozen, 200.0, is_force=is_force)) > 20
    assert time.size == 4000


@pytest.mark.parametrize("where", ["force", "position"])
def test_law_dropouts_are_left_out_counted_and_bias_nothing(where: str) -> None:
    random = np.random.default_rng(3)
    time, position, force = made_log(random, rate=200.0)
    signal = force if where == "force" else position
    dropped = random.random(time.size) < 0.02
    signal[dropped, 0] = 0.0
    found = identify(time, position, force)
    assert_true(found)
    assert codes(found) == {"glitches"}
    [doubt] = found.diagnostics
    assert doubt.values["column"] == f"{where} (x)"
    assert doubt.values["count"] == pytest.approx(np.count_nonzero(dropped), rel=0.1)


def test_law_a_long_dropout_leaves_out_what_the_filter_makes_of_it() -> None:
    random = np.random.default_rng(3)
    time, position, force = made_log(random)
    for start in range(2000, 18000, 4000):
        force[start : start + 90, 1] = force[start, 1]
    found = identify(time, position, force)
    assert_true(found)
    assert "glitches" in codes(found)
    assert not found.signals.used.all()


def test_ref_the_covariance_does_not_reach_across_stretches() -> None:
    """Bartlett's sums of each stretch, added up."""
    scores = np.random.default_rng(1).normal(size=(60, 2)).cumsum(axis=0)
    stretch = np.repeat([0, 1], [25, 35])
    total = np.zeros((2, 2))
    for number in (0, 1):
        part = scores[stretch == number]
        for lag in range(5):
            product = part[lag:].T @ part[: len(part) - lag]
            total += (1.0 - lag / 5.0) * (product if lag == 0 else product + product.T)
    np.testing.assert_allclose(_kernel_sum(scores, 4, np.array([25])), total, rtol=1e-12)


def test_law_a_start_after_the_log_is_told_with_its_number(tmp_path: Path) -> None:
    log = written(tmp_path, "log.csv", made_log(np.random.default_rng(1)))
    refused = run("identify", log, "--start", "1e6")
    assert refused.exit_code == 2
    assert "None" not in refused.stderr
    assert "from 1000000 s" in refused.stderr
