"""The questions of `telespring decide`: what may be used, with units, with one's own robots and hands."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import telespring as ts
from questions import MINE, answered, decide, flat, limits, one_axis, run


def held_force_abscissa(k: float, delay: float, period: float) -> float:
    """Largest multiplier of the held dyad by its own state matrix, the rigid-body multiplier left out.

    Shares no code with the core: each robot by the exact solution over a period, the partner's sample by a
    shift register; the delay is a whole number of periods.
    """
    steps = round(delay / period)
    blocks = []
    for mass, damping in ((1.2, 6.0), (2.0, 9.0)):
        rate = damping / mass
        fall = np.exp(-rate * period)
        free = np.array([[1.0, (1.0 - fall) / rate], [0.0, fall]])
        push = np.array([(period - (1.0 - fall) / rate) / damping, (1.0 - fall) / damping])
        blocks.append((free, push))
    size = 4 + 2 * steps
    step = np.zeros((size, size))
    for i, (free, push) in enumerate(blocks):
        own, partner = 2 * i, 2 * (1 - i)
        seen = partner if steps == 0 else 4 + steps * (1 - i) + steps - 1
        step[own : own + 2, own : own + 2] += free
        step[own : own + 2, own] -= k * push
        step[own : own + 2, seen] += k * push
        if steps:
            register = 4 + steps * i
            step[register, own] = 1.0
            for j in range(1, steps):
                step[register + j, register + j - 1] = 1.0
    size_of = np.abs(np.linalg.eigvals(step))
    rigid = int(np.argmin(np.abs(np.linalg.eigvals(step) - 1.0)))
    return float(np.log(np.max(np.delete(size_of, rigid))) / period)


@pytest.mark.parametrize("delay", [0.01, 0.04, 0.1])
def test_cross_the_usable_stiffness_keeps_its_reserve_in_another_model(delay: float) -> None:
    """At 5 % more stiffness, and at 5 % more delay rounded up, an independent sampled model is stable."""
    found = limits(one_axis(), delay).delays[0]
    usable = found.usable_stiffness
    assert held_force_abscissa(0.999 * found.stiffness_limit, delay, 0.001) < 0.0
    assert held_force_abscissa(1.001 * found.stiffness_limit, delay, 0.001) > 0.0
    assert held_force_abscissa(1.05 * 0.999 * usable, delay, 0.001) < 0.0
    assert held_force_abscissa(0.999 * usable, np.ceil(1.05e3 * delay) / 1e3, 0.001) < 0.0
    assert decide(one_axis(), 0.999 * usable, delay).status == "stable"
    assert decide(one_axis(), 1.02 * usable, delay).status == "marginal"


@pytest.mark.parametrize(("k", "delay"), [(85.0, 0.1), (70.0, 0.13), (200.0, 0.06)])
def test_cross_remedies_hold_with_sampled_controllers(k: float, delay: float) -> None:
    found = decide(one_axis(), k, delay)
    shorter = np.floor(1e3 * found.delay_limit) / 1e3
    assert held_force_abscissa(k, shorter, 0.001) < 0.0
    assert held_force_abscissa(k, shorter + 0.002, 0.001) > 0.0
    if found.status == "unstable":
        added = 1.0001 * found.added_damping
        firmer = ts.Dyad(ts.Robot(1.2, 6.0 + added), ts.Robot(2.0, 9.0 + added))
        assert decide(firmer, k, delay).stable


def test_ref_the_status_follows_the_stated_reserve() -> None:
    """2K and Δ of the paper, 71.2 N/m over 167 ms, is stable by 0.3 ms and unstable with 1 ms sampling."""
    dyad = ts.hman()
    assert decide(dyad, 71.2, 0.167, sample_period=0.0).status == "marginal"
    assert decide(dyad, 71.2, 0.167).status == "unstable"
    assert decide(dyad, 71.2, 0.1).status == "stable"
    limit = decide(dyad, 50.0, 0.1, sample_period=0.0).stiffness_limit
    assert decide(dyad, 0.9999 * limit / 1.05, 0.05, sample_period=0.0).keeps_stiffness_reserve
    assert decide(dyad, 1.0001 * limit / 1.05, 0.1, sample_period=0.0).status == "marginal"


@pytest.mark.parametrize(("stiffness", "expected"), [("71.2", 0), ("97", 1), ("150", 1)])
def test_law_check_fails_unless_stable_with_the_reserve(stiffness: str, expected: int) -> None:
    assert run("decide", "--stiffness", stiffness, "--delay", "0.1", "--check").exit_code == expected
    assert run("decide", "--stiffness", stiffness, "--delay", "0.1").exit_code == 0
    word = {"71.2": "stable", "97": "marginal", "150": "unstable"}[stiffness]
    assert answered("--stiffness", stiffness, "--delay", "0.1")["status"] == word


def test_law_a_check_with_a_grip_counts_a_hand_that_lets_go() -> None:
    """100.9 N/m is the limit of free handles at 100 ms; hands of 200 to 300 N/m allow more."""
    grip = ("--stiffness", "105", "--delay", "0.1", "--grip", "200:300")
    answer = answered(*grip)
    assert answer["free"]["status"] == "unstable"
    assert answer["status"] != "unstable"
    assert run("decide", *grip, "--check").exit_code == 1


def test_law_without_a_stiffness_it_says_what_may_be_used() -> None:
    answer = answered(*MINE, "--ping", "80ms")
    assert answer["question"] == "limits"
    [row] = answer["delays"]
    assert row["delay"] == {"forward": 0.04, "backward": 0.04}
    screen = flat(run("decide", *MINE, "--ping", "80ms", "--ping-jitter", "15 ms").stdout)
    assert "A ping of 80 ms counts as 40 ms each way." in screen
    assert "if the ping is shared otherwise, the sum may be one period longer" in screen
    for name, has_buffer in (("Without a playout buffer", False), ("With a playout buffer of 55 ms", True)):
        told = re.search(rf"{name}: You may use up to ([0-9.]+) N/m", screen)
        assert told is not None
        found = decide(one_axis(), float(told[1]), 0.04, jitter=0.015, has_playout_buffer=has_buffer)
        assert found.status == "stable"


def test_law_without_a_delay_it_lists_delays_and_the_delay_of_a_stiffness() -> None:
    assert len(answered(*MINE)["delays"]) > 3
    answer = answered(*MINE, "--stiffness", "60")["stiffness"]
    assert decide(one_axis(), 60.0, 0.999 * answer["usable_delay"]).status == "stable"
    assert decide(one_axis(), 60.0, 1.01 * answer["delay_limit"]).status == "unstable"


def test_law_a_study_without_coupling_gives_limits_and_an_option_completes_it(tmp_path: Path) -> None:
    file = tmp_path / "open.toml"
    file.write_text(
        "robot1 = {mass = 1.2, damping = 6}\nrobot2 = {mass = 2, damping = 9}\nnetwork.delay = 0.04\n"
    )
    assert answered(str(file))["delays"][0]["stiffness_limit"] == pytest.approx(
        limits(one_axis(), 0.04).delays[0].stiffness_limit
    )
    assert answered(str(file), "--stiffness", "50")["status"] == "stable"


def test_law_robot_files_of_one_axis_replace_robots_of_two(tmp_path: Path) -> None:
    for name in ("left", "right"):
        (tmp_path / f"{name}.toml").write_text("[robot]\nmass = 0.9\ndamping = 7.0\n")
    files = ("--robot1", str(tmp_path / "left.toml"), "--robot2", str(tmp_path / "right.toml"))
    study = tmp_path / "two.toml"
    study.write_text("robot1 = {mass = [1, 2], damping = 6}\nrobot2 = {mass = [2, 3], damping = 9}\n")
    for arguments in (files, (str(study), *files)):
        screen = run("decide", *arguments, "--stiffness", "20", "--delay", "50ms")
        assert screen.exit_code == 0, screen.output
        assert "Robot 1, left.toml: 0.9 kg, 7 N·s/m on x" in screen.stdout
    assert "two H-MANs" not in run("decide", *files).stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--robot1", "1.2,6"], ["--robot2", "hman2"]),
        (["--robot", "1.2,6"], ["--robot", "Write it twice: --robot 1.2,6 --robot 1.2,6"]),
        (["--robot", "1.2", "--robot", "2,9"], ["--robot = 1.2", "1.2,6"]),
        (["--robot", "1200,6", "--robot", "2,9"], ["--robot", "Did you mean 1200 g? Write 1.2."]),
        (["--delay", "80"], ["--delay = 80 s", "Did you mean 80 ms? Write 0.08.", "--allow-unusual"]),
        (["--jitter", "15", "--delay", "0.08"], ["--jitter = 15 s", "15 ms? Write 0.015."]),
        (["--ping", "80"], ["--ping = 80 s", "80 ms? Write 0.08"]),
        (["--ping", "80ms", "--delay", "0.1"], ["--ping", "Leave out --delay"]),
        (["--sample-period", "1"], ["--sample-period = 1 s", "1 ms? Write 0.001."]),
        (["--stiffness", "0.0712"], ["--stiffness = 0.0712 N/m", "0.0712 N/mm? Write 71.2."]),
        (["--grip", "0.05:0.3"], ["--grip = 0.05 N/m", "N/mm"]),
        (["--grip", "300:50"], ["--grip", "smaller number first"]),
        (["--delay", "80 kg"], ["'--delay'", "'kg' is not a unit of a time"]),
        (["--delay", "0,08"], ["'--delay'", "decimal point"]),
        (["--stiffness", "71 N/foo"], ["'--stiffness'", "is not a unit that is known"]),
        (["--check"], ["--check", "Give --stiffness and --delay"]),
        (["--backward", "0.1", "--stiffness", "20"], ["--delay"]),
        (["--continuous", "--sample-period", "2ms"], ["--continuous", "Leave out one"]),
    ],
)
def test_law_a_refused_option_is_named_with_its_remedy(arguments: list[str], words: list[str]) -> None:
    found = run("decide", *arguments, columns=200)
    assert found.exit_code == 2
    assert found.stdout == ""
    for word in words:
        assert word in found.stderr, found.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["--delay", "80", "--stiffness", "20", "--allow-unusual"],
        ["--delay", "80 ms", "--stiffness", "71.2 N/m"],
        ["--delay", "80ms", "--stiffness", "0.0712 N/mm", "--robot", "1200g,6", "--robot", "2 kg,9 N*s/m"],
        ["--robot1", "hman1", "--robot2", "hman2"],
    ],
)
def test_law_units_and_allowed_values_are_read(arguments: list[str]) -> None:
    assert run("decide", *arguments).exit_code == 0


def test_law_units_mean_the_same_as_si() -> None:
    assert answered("--delay", "80 ms", "--stiffness", "0.0712N/mm", "--jitter", "5000µs") == answered(
        "--delay", "0.08", "--stiffness", "71.2", "--jitter", "0.005"
    )


def test_law_python_refuses_unusual_values_unless_told() -> None:
    with pytest.raises(ts.InvalidInput, match=r"80 ms\? Write 0\.08"):
        ts.decide(ts.hman(), 20.0, 80.0)
    found = ts.decide(ts.hman(), 20.0, ts.Network(80.0), allow_unusual=True).decision
    assert found is not None
    assert found.delay == (80.0, 80.0)


def test_law_no_line_mixes_the_worst_operator_with_another() -> None:
    """Every value of an axis over ranges is the worst, or that of the operators that are named."""
    ranges = ts.OperatorRange(ts.Operator(stiffness=50.0), ts.Operator(stiffness=300.0))
    found = decide(ts.hman(), 90.0, 0.1, operator_ranges=(ranges, ranges), sample_period=0.0)
    for i, axis in enumerate(found.axes):
        one, other = axis.worst_case.operators
        fixed = ts.Dyad(
            *ts.hman().robots,
            (ts.Operator(stiffness=one.stiffness), ts.Operator(stiffness=other.stiffness)),
        )
        own = fixed.axis(i)
        assert axis.worst_case.spectral_abscissa == pytest.approx(own.spectral_abscissa(90.0, 0.1))
        assert own.maximum_stiffness(0.1) == pytest.approx(axis.maximum_stiffness, rel=1e-3)
    answer = answered("--stiffness", "90", "--delay", "0.1", "--grip", "50:300", "--continuous")
    assert answer["axes"][0]["operators"][0]["stiffness"] >= 50.0


@pytest.mark.parametrize("stiffness", [(), ("--stiffness", "71.2")])
@pytest.mark.parametrize(
    ("grips", "is_left_out"),
    [
        (("--grip", "50:300"), True),
        (("--grip1", "0:300", "--grip2", "50:300"), True),
        (("--grip", "0:300"), False),
        (("--grip2", "50:300"), False),
    ],
)
def test_law_one_hand_that_lets_go_alone_is_said_where_it_is_left_out(
    stiffness: tuple[str, ...], grips: tuple[str, ...], is_left_out: bool
) -> None:
    screen = flat(run("decide", *stiffness, "--delay", "0.1", *grips).stdout)
    assert ("Neither case covers one hand that lets go" in screen) == is_left_out


def test_ref_one_hand_that_lets_go_alone_can_be_the_worst_case() -> None:
    dyad = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))

    def hands(*stiffnesses: tuple[float, float]) -> tuple[ts.OperatorRange, ts.OperatorRange]:
        one, other = (
            ts.OperatorRange(ts.Operator(stiffness=low), ts.Operator(stiffness=high))
            for low, high in stiffnesses
        )
        return one, other

    def is_stable(operators: tuple[ts.OperatorRange, ts.OperatorRange] | None) -> bool:
        return ts.decide(dyad, 193.5, 0.04, operator_range=operators).status in ("stable", "marginal")

    assert is_stable(None)
    assert is_stable(hands((50.0, 300.0), (50.0, 300.0)))
    assert not is_stable(hands((0.0, 0.0), (50.0, 300.0)))
    # the range from 0 has it
    assert not is_stable(hands((0.0, 300.0), (0.0, 300.0)))


def test_law_free_and_held_stand_side_by_side() -> None:
    screen = run("decide", "--stiffness", "71.2", "--delay", "0.1", "--grip", "50:300").stdout
    assert "Free handles: STABLE" in screen
    assert "Handles held by 50 to 300 N/m: STABLE" in flat(screen)
    header = next(line for line in screen.splitlines() if line.startswith("network"))
    assert header.split() == ["network", "free,", "N/m", "held,", "N/m", "a", "hand"]
    assert "helps" in screen


def test_law_the_probability_says_what_is_outside_it(tmp_path: Path) -> None:
    text = "[robot]\nmass = 0.9\ndamping = 7.0\nmass_sd = 0.02\ndamping_sd = 0.3\n"
    (tmp_path / "one.toml").write_text(text)
    (tmp_path / "three.toml").write_text(f"{text}[identification]\nlogs = 3\n")
    asked = ("--stiffness", "20", "--delay", "50ms")
    single = flat(run("decide", "--robot", str(tmp_path / "one.toml"), "--robot", "1,7", *asked).stdout)
    assert "It does not cover what the model of the robots leaves out" in single
    assert "gain" in single
    assert "logs of robot 1 differ" in single
    several = flat(run("decide", "--robot", str(tmp_path / "three.toml"), "--robot", "1,7", *asked).stdout)
    assert "differ from one another" not in several


@pytest.mark.parametrize("columns", [60, 80, 120])
@pytest.mark.parametrize(
    "arguments",
    [
        ("--stiffness", "71.2", "--delay", "0.1"),
        ("--stiffness", "97", "--delay", "0.1", "--grip", "50:300"),
        MINE,
        (*MINE, "--ping", "80ms"),
    ],
)
def test_law_no_terminal_cuts_a_word(columns: int, arguments: tuple[str, ...]) -> None:
    screen = run("decide", *arguments, columns=columns).stdout
    assert "…" not in screen
    assert all(len(line) <= columns for line in screen.splitlines())
    for word in ("any constant delay" if "--stiffness" in arguments else "any constant", "N/m"):
        assert word in flat(screen)


def as_process(*arguments: str, **options: Any) -> subprocess.CompletedProcess[bytes]:
    environment = {**os.environ, **options.pop("environment", {})}
    return subprocess.run(
        [sys.executable, "-m", "telespring", *arguments],
        stderr=subprocess.PIPE,
        check=False,
        timeout=100,
        env=environment,
        **options,
    )


def test_law_ascii_terminals_get_words_not_question_marks() -> None:
    found = as_process(
        "decide",
        "--stiffness",
        "97",
        "--delay",
        "0.1",
        stdout=subprocess.PIPE,
        environment={"LC_ALL": "C", "PYTHONIOENCODING": "ascii", "COLUMNS": "80"},
    )
    text = found.stdout.decode("ascii")
    assert "?" not in text
    assert "k <= b^2/(4m)" in text
    assert all(len(line) <= 80 for line in text.splitlines())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("arguments", [("decide",), ("decide", "--json"), ("--help",), ("decide", "--help")])
def test_law_output_that_cannot_be_written_is_told_in_two_lines(arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("wb") as full:
        found = as_process(*arguments, stdout=full)
    assert found.returncode == 2
    assert found.stderr.decode().splitlines()[0] == (
        "Refused: the output could not be written (No space left on device)."
    )
    assert len(found.stderr.splitlines()) == 2


@pytest.mark.parametrize("arguments", [("decide",), ("decide", "--json")])
def test_law_a_reader_that_stops_reading_is_no_trouble(arguments: tuple[str, ...]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        found = as_process(*arguments, stdout=writing)
    finally:
        os.close(writing)
    assert found.returncode == 141
    assert found.stderr == b""


def test_law_the_version_is_that_of_the_core() -> None:
    from telespring._core import __version__

    assert run("--version").stdout == f"telespring {__version__}\n"
    assert "--install-completion" in run("--help").stdout


@pytest.mark.parametrize(
    ("robots", "grip", "stiffness", "unstable_from"),
    [
        # where the continuous dyad is unstable with some hands in the range, by its characteristic roots
        (((3.2, 17.6), (0.9, 2.6)), "50:300", 95.0, 0.0948),
        (((1.2, 6.0), (2.0, 9.0)), "50:300", 120.0, 0.0724),
        # beyond 1 s
        (((0.79, 5.21), (4.88, 24.81)), None, 59.2, 2.567),
    ],
)
def test_ref_a_limit_of_delay_without_a_delay_in_question_holds(
    robots: tuple[tuple[float, float], ...], grip: str | None, stiffness: float, unstable_from: float
) -> None:
    given = [word for mass, damping in robots for word in ("--robot", f"{mass},{damping}")]
    held = [] if grip is None else ["--grip", grip]
    answer = run("decide", *given, *held, "--stiffness", str(stiffness), "--json")
    limits = json.loads(answer.stdout)["stiffness"]
    assert limits["delay_limit"] is not None
    assert 0.9 * unstable_from < limits["delay_limit"] < unstable_from


def test_law_options_of_controllers_and_coupling_are_those_of_a_study(tmp_path: Path) -> None:
    asked = (*MINE, "--delay", "40ms", "--stiffness", "100")
    options = ("--sample-period", "2ms", "--computing-time", "0.5ms", "--coupling-damping", "2")
    study = tmp_path / "study.toml"
    robots = "robot1 = {mass = 1.2, damping = 6}\nrobot2 = {mass = 2, damping = 9}\n"
    study.write_text(
        f"{robots}network.delay = 0.04\ncoupling = {{stiffness = 100, damping = 2}}\n"
        "controller = {sample_period = 0.002, computing_time = 0.0005}\n"
    )
    found = answered(*asked, *options)
    stated = answered(str(study))
    for key in ("status", "remedies", "verdicts", "axes"):
        assert found[key] == stated[key]
    assert found["remedies"] != answered(*asked, *options[:2])["remedies"]
    refused = run("decide", *asked, "--continuous", "--computing-time", "0.5ms")
    assert refused.exit_code == 2
    assert "--computing-time" in refused.stderr
    late = run("decide", *asked, "--computing-time", "5ms")
    assert late.exit_code == 2
    assert "--computing-time" in late.stderr
