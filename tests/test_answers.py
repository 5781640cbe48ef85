"""The answer of `decide`, from the command and from Python: with jitter, with arms, in words."""

from __future__ import annotations

import inspect
import json
import math
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import telespring as ts
from age_range_gain import gain
from questions import MINE, answered, decide, flat, limits, one_axis, run
from telespring._html import _with_unit  # the table of units itself is compared with the documentation


def bounded_delay_stiffness(oldest: float) -> float:
    """The rule for a bounded varying delay of continuous controllers, k < √(b₁b₂)/T each way."""
    return math.sqrt(6.0 * 9.0) / oldest


# -- jitter, with and without a playout buffer


@pytest.mark.parametrize("jitter", [0.002, 0.01, 0.05])
def test_ref_without_a_buffer_the_answer_is_that_of_a_varying_delay(jitter: float) -> None:
    continuous = {"jitter": jitter, "sample_period": 0.0}
    found = decide(one_axis(), 50.0, 0.04, **continuous).varying
    assert found is not None
    limit = found.stiffness_limit
    assert limit > bounded_delay_stiffness(0.04 + jitter)
    ages = ((0.04, 0.04 + jitter),) * 2
    robots = one_axis().robots
    assert gain(0.99 * limit, ages, *robots) < 1.0 < gain(1.01 * limit, ages, *robots)
    assert decide(one_axis(), 0.999 * limit / 1.05, 0.04, **continuous).status == "stable"
    assert decide(one_axis(), 1.001 * limit / 1.05, 0.04, **continuous).status == "marginal"
    beyond = decide(one_axis(), 1.001 * limit, 0.04, **continuous)
    assert beyond.status == "not proven"
    has_reserve = 1.05 * 1.001 * limit < ts.maximum_stiffness(one_axis(), 0.04 + jitter)
    buffered = "stable" if has_reserve else "marginal"
    assert beyond.constant_delay_status == buffered
    assert decide(one_axis(), 1.001 * limit, 0.04, has_playout_buffer=True, **continuous).status == buffered


def test_cross_an_unstable_constant_delay_within_the_jitter_is_unstable() -> None:
    """By the characteristic roots: stable at 40 ms, unstable at 80 ms; jitter may give both."""
    axis = one_axis().axis(0)
    assert axis.spectral_abscissa(130.0, 0.04) < 0.0 < axis.spectral_abscissa(130.0, 0.08)
    found = decide(one_axis(), 130.0, 0.04, jitter=0.04, sample_period=0.0)
    assert found.status == "unstable"
    # Stable behind a buffer of a later stable interval, unstable at the delay itself.
    assert decide(one_axis(), 130.0, 0.04, sample_period=0.0).status == "stable"


@pytest.mark.parametrize("jitter", ["--jitter", "--ping-jitter"])
def test_law_check_counts_no_buffer_that_nobody_promised(jitter: str, tmp_path: Path) -> None:
    asked = (*MINE, "--ping", "80ms", "--stiffness", "100", jitter, "40ms")
    assert run("decide", *asked, "--check").exit_code == 1
    assert run("decide", *asked, "--playout-buffer", "--check").exit_code == 0
    answer = answered(*asked)
    assert (answer["status"], answer["constant_delay"]["status"]) == ("not proven", "stable")
    assert answer["varying_delay"]["stiffness_limit"] < 100.0
    screen = flat(run("decide", *asked).stdout)
    assert screen.index("Without a playout buffer: NOT PROVEN") < screen.index(
        "With a playout buffer of 80 ms: STABLE"
    )
    study = tmp_path / "buffered.toml"
    text = "robot1 = {mass = 1.2, damping = 6}\nrobot2 = {mass = 2, damping = 9}\ncoupling.stiffness = 100\n"
    study.write_text(f"{text}[network]\ndelay = 0.04\njitter = 0.04\nplayout_buffer = true\n")
    assert run("decide", str(study), "--check").exit_code == 0
    assert run("decide", str(study), "--no-playout-buffer", "--check").exit_code == 1
    read = ts.Study.read(study)
    assert ts.Study.from_toml(read.to_toml()).has_playout_buffer
    assert ts.decide(read).status == "stable"
    assert ts.decide(read, playout_buffer=False).status == "not proven"


def test_law_gaps_vary_the_delay_as_jitter_does() -> None:
    found = decide(one_axis(), 100.0, 0.04, max_gap=0.04)
    assert (found.status, found.constant_delay_status) == ("not proven", "stable")
    assert "gaps of up to 40 ms" in run("decide", *MINE, "--delay", "40ms", "--max-gap", "40ms").stdout


def test_ref_limits_say_both_answers_with_and_without_a_delay() -> None:
    row = limits(one_axis(), 0.04, jitter=0.015, sample_period=0.0).delays[0]
    assert row.varying is not None
    limit, robots = 1.05 * row.varying.usable_stiffness, one_axis().robots
    ages = ((0.04, 0.055),) * 2
    assert gain(0.99 * limit, ages, *robots) < 1.0 < gain(1.01 * limit, ages, *robots)
    assert row.usable_stiffness > row.varying.usable_stiffness
    listed = answered(*MINE, "--jitter", "15ms", "--continuous")["delays"]
    for row_ in listed:
        delay, varying = row_["delay"]["forward"], row_["varying_delay"]["stiffness_limit"]
        ages = ((delay, delay + 0.015),) * 2
        assert gain(0.98 * varying, ages, *robots) < 1.0
        assert varying >= max(bounded_delay_stiffness(delay + 0.015), 6.0**2 / (4 * 1.2)) * (1.0 - 1e-9)
    screen = run("decide", *MINE, "--jitter", "15ms").stdout
    assert "up to 15 ms more (jitter)" in screen
    assert re.search(r"no buffer\s+with buffer", screen)


def test_ref_the_delay_of_a_stiffness_leaves_room_for_jitter() -> None:
    """√(b₁b₂)/(1.05 k) less the jitter, in closed form."""
    found = limits(one_axis(), None, 60.0, jitter=0.015, sample_period=0.0).stiffness
    assert found is not None
    assert found.usable_delay_while_varying == pytest.approx(
        bounded_delay_stiffness(1.05 * 60.0) - 0.015, abs=1e-6
    )
    soft = limits(one_axis(), None, 5.0, jitter=0.015, sample_period=0.0).stiffness
    assert soft is not None
    assert soft.usable_delay_while_varying == math.inf  # 5 N/m is stable on any network
    hands = ts.OperatorRange(ts.Operator(damping=1.0), ts.Operator(damping=3.0, stiffness=200.0))
    held = limits(
        one_axis(), None, 60.0, jitter=0.015, sample_period=0.0, operator_ranges=(hands, hands)
    ).stiffness
    assert held is not None
    assert held.usable_delay_while_varying == pytest.approx(math.sqrt(7.0 * 10.0) / 63.0 - 0.015, abs=1e-6)


def test_law_uncertain_robots_need_more_room_while_the_delay_varies() -> None:
    known = ts.Uncertainty([0.0], [0.6], [0.0])
    k = 0.97 * bounded_delay_stiffness(0.05) / 1.05
    common = {"jitter": 0.01, "sample_period": 0.0}
    assert decide(one_axis(), k, 0.04, **common).status == "stable"
    assert decide(one_axis(), k, 0.04, uncertainty=(known, known), **common).status == "marginal"
    # In another way: the share of draws for which the rule proves it is below 0.95.
    draws = np.random.default_rng(1).normal([6.0, 9.0], 0.6, size=(20_000, 2))
    assert np.mean(1.05 * k < np.sqrt(draws.prod(axis=1)) / 0.05) < 0.95
    soft = decide(one_axis(), 0.6 * k, 0.04, uncertainty=(known, known), **common)
    assert soft.status == "stable"


# -- one object in Python


@pytest.mark.parametrize(
    ("arguments", "asked"),
    [
        ((*MINE, "--ping", "80ms", "--stiffness", "150"), lambda: ts.decide(one_axis(), 150.0, 0.04)),
        ((*MINE, "--ping", "80ms"), lambda: ts.decide(one_axis(), delay=0.04)),
        (MINE, lambda: ts.decide(one_axis())),
        ((*MINE, "--stiffness", "60"), lambda: ts.decide(one_axis(), 60.0)),
        (
            (*MINE, "--delay", "40ms", "--jitter", "10ms", "--stiffness", "90", "--grip", "50:300"),
            lambda: ts.decide(
                one_axis(),
                90.0,
                ts.Network(0.04, jitter=0.01, sample_period=0.001),
                operator_range=ts.OperatorRange(ts.Operator(stiffness=50.0), ts.Operator(stiffness=300.0)),
            ),
        ),
        (("examples/two-link.toml",), lambda: ts.decide(ts.Study.read("examples/two-link.toml"))),
        (
            ("examples/two-link.toml", "--stiffness", "60", "--delay", "50ms", "--decay-rate", "1"),
            lambda: ts.decide(ts.Study.read("examples/two-link.toml"), 60.0, 0.05, decay_rate=1.0),
        ),
    ],
)
def test_law_python_answers_what_the_command_answers(
    arguments: tuple[str, ...], asked: Any, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(root)
    answer = asked()
    assert answer.to_dict() == answered(*arguments)
    assert len(repr(answer)) < 300
    assert "\n" not in repr(answer)
    html = answer._repr_html_()
    assert "N/m" in html
    if answer.decision is None:
        assert "usable" in repr(answer)
    else:
        assert f"status {answer.status}" in repr(answer)
        assert "stiffness limit, N/m" in html
    # The screen, without the lines that say how a ping is understood.
    shown = "\n".join(line.rstrip() for line in run("decide", *arguments).stdout.splitlines())
    shown = re.sub(r"^A ping of .*?one\speriod\slonger\.\n", "", shown, flags=re.DOTALL | re.MULTILINE)
    assert str(answer) == shown


def test_law_the_default_of_both_calls_is_said() -> None:
    """The command and `ts.decide` sample every 1 ms; `ts.verdicts` is continuous and says so."""
    assert ts.decide(one_axis(), 150.0, 0.04).to_dict()["sample_period"] == 0.001
    assert "sample_period=0.0" in repr(ts.verdicts(one_axis(), 150.0, 0.04))
    text = inspect.getdoc(ts.verdicts) or ""
    assert "continuous unless one is given" in flat(text)
    assert "sampled every 1 ms unless" in flat(inspect.getdoc(ts.decide) or "")


def test_law_verdicts_take_a_network() -> None:
    network = ts.Network((0.04, 0.05), jitter=0.01, max_gap=0.002, sample_period=0.001, computing_time=0.0005)
    assert ts.verdicts(one_axis(), 90.0, network) == ts.verdicts(
        one_axis(), 90.0, (0.04, 0.05), 0.01, 0.002, 0.001, 0.0005
    )
    with pytest.raises(ts.InvalidInput, match="jitter") as refused:
        ts.verdicts(one_axis(), 90.0, network, jitter=0.02)
    assert "Network(delay, jitter=0.02)" in refused.value.remedy


def test_law_the_representation_of_verdicts_tells_every_tier() -> None:
    found = ts.verdicts(one_axis(), 90.0, 0.04, sample_period=0.001)
    for tier in found.tiers:
        assert f"{tier.tier.replace(' ', '_')}={tier.satisfied}" in repr(found)
        assert tier.stiffness_bound is not None
        shown = re.search(rf" {tier.tier.replace(' ', '_')}=\w+ \(limit ([0-9.]+) N/m\)", repr(found))
        assert shown is not None
        assert 0.999 * tier.stiffness_bound < float(shown[1]) <= tier.stiffness_bound
    sampled = min(axis.sampled_stiffness_bound or 0.0 for axis in found.axes)
    told = re.search(r"sampled_stable=True \(limit ([0-9.]+) N/m\)", repr(found))
    assert told is not None
    assert 0.999 * sampled < float(told[1]) <= sampled


def test_law_tables_have_the_units_of_the_documentation() -> None:
    """The unit in the text of an attribute and the one that the table shows are the same."""
    found = ts.verdicts(one_axis(), 90.0, ts.Network(0.04, jitter=0.01, sample_period=0.001))
    records: list[Any] = [
        found,
        *found.tiers,
        found.delay_budget[0],
        found.remedies,
        found.paper,
        found.tiers[0].margin,
    ]
    records += [
        found.axes[0],
        found.axes[0].tiers[0],
        found.axes[0].sampled,
        *(found.tiers[0].worst_operators or ()),
    ]
    checked = 0
    for record in records:
        for name, value in record.to_dict().items():
            if not isinstance(value, float):
                continue
            text = (inspect.getdoc(getattr(type(record), name)) or "").split(":")[0]
            unit = re.search(r"\b(N/m|N·s/m|kg|rad/s|1/s|s)(?=[,.;:]|$| each)", text)
            shown = _with_unit(name, value).partition(", ")[2]
            if unit is not None:
                assert shown == unit[1], (type(record).__name__, name, text)
                checked += 1
    assert checked > 12


def test_law_a_study_keeps_its_unusual_values_out_of_a_decision() -> None:
    with pytest.raises(ts.InvalidInput, match="Did you mean 80 ms"):
        ts.decide(ts.Study.paper(), delay=80.0)
    with pytest.raises(ts.InvalidInput, match="Dyad or a Study"):
        ts.decide(3.0)  # type: ignore[arg-type]
    for arguments, field in (
        ({"stiffness": "a", "delay": 0.04}, "stiffness"),
        ({"stiffness": 150.0, "delay": "x"}, "delay"),
        ({"stiffness": 150.0, "delay": 0.04, "operator_range": ts.Operator()}, "operator_range"),
        ({"stiffness": 150.0, "delay": 0.04, "horizon": -1.0}, "horizon"),
        ({"stiffness": -150.0, "delay": 0.04}, "stiffness"),
    ):
        bad: Any = arguments
        with pytest.raises(ts.InvalidInput, match=f"^{field}") as refused:
            ts.decide(one_axis(), **bad)
        assert refused.value.remedy


# -- what the answer rests on


def test_law_unknown_arms_are_told_before_the_answer(root: Path) -> None:
    screen = flat(run("decide", str(root / "examples/tremor.toml"), "--stiffness", "20", "--check").stdout)
    assert screen.index("stability with them is unknown") < screen.index("STABLE at this constant delay")


def test_law_unstable_arms_are_told_before_the_answer_and_fail_the_check(tmp_path: Path) -> None:
    """Arms of 5 kg without damping on robots that are stable alone."""
    arm = 'kind = "lumped"\nmass = 5.0\n'
    text = ts.Study.paper().to_toml() + f"\n[arm1]\n{arm}[arm2]\n{arm}"
    text += '[agent1]\nkind = "skilled"\nstiffness = 0\n[agent2]\nkind = "skilled"\nstiffness = 0\n'
    file = tmp_path / "heavy.toml"
    file.write_text(text)
    asked = (str(file), "--stiffness", "60", "--delay", "0.15")
    heavy = ts.Dyad(*ts.hman().robots, (ts.Operator(mass=5.0), ts.Operator(mass=5.0)))
    assert max(axis.spectral_abscissa(60.0, 0.15) for axis in heavy) > 0.0
    answer = answered(*asked)
    assert (answer["status"], answer["in_arms"]["stable"]) == ("stable", False)
    assert run("decide", *asked, "--check").exit_code == 1
    screen = flat(run("decide", *asked).stdout)
    assert screen.index("with them the dyad is UNSTABLE") < screen.index("STABLE at this constant delay")


def test_law_the_header_names_robots_values_and_axes(tmp_path: Path) -> None:
    file = tmp_path / "left.toml"
    file.write_text("[robot]\nmass = [1.2, 1.4]\ndamping = [6.0, 8.0]\n")
    screen = flat(run("decide", "--robot", str(file), "--robot", "2,9", "--ping", "80ms").stdout)
    assert "Robot 1, left.toml: 1.2 kg, 6 N·s/m on x; 1.4 kg, 8 N·s/m on y" in screen
    assert "Robot 2: 2 kg, 9 N·s/m on x and y" in screen
    assert "Robot 2 is given by one mass and one damping: they count for each of the axes x and y." in screen
    assert "one mass" not in run("decide", *MINE, "--ping", "80ms").stdout


def test_law_a_hand_that_lets_go_decides_what_to_change() -> None:
    """105 N/m at 100 ms: held handles are stable, free ones are not; what is advised is for both."""
    asked = ("--stiffness", "105", "--delay", "0.1", "--grip", "200:300")
    screen = flat(run("decide", *asked).stdout)
    told = re.search(r"with the reserve, free and held, one of: a stiffness of up to ([0-9.]+) N/m", screen)
    assert told is not None
    assert run("decide", "--stiffness", told[1], *asked[2:], "--check").exit_code == 0
    assert decide(ts.hman(), 1.01 * float(told[1]), 0.1).status == "marginal"


# -- messages


def test_ref_growth_is_told_by_its_doubling_time() -> None:
    """e^(rate t) = 2; the rate from the characteristic roots."""
    screen = flat(run("decide", *MINE, "--delay", "70ms", "--stiffness", "190", "--continuous").stdout)
    told = re.search(r"the motion doubles every ([0-9.]+) ms", screen)
    assert told is not None
    rate = one_axis().axis(0).spectral_abscissa(190.0, 0.07)
    assert math.exp(rate * 1e-3 * float(told[1])) == pytest.approx(2.0, rel=1e-2)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--stiffness", "71N/mm"), ("--stiffness = 71N/mm (71000 N/m)", "Check the number and its unit.")),
        (("--delay", "80s", "--stiffness", "20"), ("--delay = 80s (80 s)", "Check the number and its unit.")),
        (("--horizon", "2000", "--stiffness", "20", "--delay", "0.1"), ("--horizon", "Leave it out")),
        (("--decay-rate", "1"), ("--decay-rate", "Give stiffness and delay")),
    ],
)
def test_law_a_unit_that_was_written_is_not_guessed_again(
    arguments: tuple[str, ...], words: tuple[str, ...]
) -> None:
    found = run("decide", *arguments, columns=200)
    assert found.exit_code == 2
    assert "Did you mean" not in found.stderr
    for word in words:
        assert word in found.stderr, found.stderr


def test_law_scales_of_a_log_may_have_units(root: Path) -> None:
    log = str(root / "examples/log.csv")
    asked = ("identify", log, "--json")
    one, other = (
        json.loads(run(*asked, "--position-scale", length, "--force-scale", force).stdout)
        for length, force in (("500mm", "500mN"), ("0.5", "0.5"))
    )
    assert one == other


@pytest.mark.parametrize(
    ("line", "remedy"),
    [
        ('network.delay = "80 ms"', "Write 0.08"),
        ('network.jitter = "5ms"', "Write 0.005"),
        ('coupling.stiffness = "71.2 N/m"', "Write 71.2"),
        ('coupling.stiffness = "0.0712 N/mm"', "Write 71.2"),
        ('operator1.mass = "800 g"', "Write 0.8"),
        ('operator1.damping = "2.5 N*s/m"', "Write 2.5"),
        ('network.delay = "80 kg"', "Write the number alone, in s"),
        ('network.delay = "soon"', "Write the number alone, in s"),
    ],
)
def test_law_a_text_with_a_unit_in_a_study_is_answered_with_its_number(line: str, remedy: str) -> None:
    text = f"robot1 = {{mass = 1, damping = 5}}\nrobot2 = {{mass = 1, damping = 5}}\n{line}\n"
    with pytest.raises(ts.InvalidInput) as refused:
        ts.Study.from_toml(text)
    assert remedy in refused.value.remedy
    assert "See line 3." in refused.value.remedy


@pytest.mark.parametrize("code", ["def path(): pass", "path = int", "def path(times, missing): pass"])
def test_law_errors_of_a_program_cite_no_file_of_the_package(code: str, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(code)
    study = tmp_path / "mine.toml"
    study.write_text(ts.Study.paper().to_toml() + '\n[task]\nkind = "python"\nfunction = "mine:path"\n')
    found = run("rehearse", str(study), "--out", str(tmp_path / "out"), columns=300)
    assert found.exit_code == 2
    assert "Correct it in mine.py." in found.stderr
    assert "user_code" not in found.stderr


def test_law_every_command_takes_robots_and_simulate_a_ping(tmp_path: Path) -> None:
    out = [tmp_path / "a.csv", tmp_path / "b.csv"]
    assert run("simulate", *MINE, "--ping", "80ms", "--stiffness", "50", "--out", str(out[0])).exit_code == 0
    text = "robot1 = {mass = 1.2, damping = 6}\nrobot2 = {mass = 2, damping = 9}\ncoupling.stiffness = 50\n"
    (tmp_path / "same.toml").write_text(f"{text}network.delay = 0.04\n")
    assert run("simulate", str(tmp_path / "same.toml"), "--out", str(out[1])).exit_code == 0
    assert out[0].read_text() == out[1].read_text()
    for command in ("decide", "simulate", "rehearse", "reproduce"):
        assert "--robot " in run(command, "--help").stdout


@pytest.mark.parametrize("columns", [60, 80, 120])
@pytest.mark.parametrize("more", [(), ("--stiffness", "150"), ("--stiffness", "150", "--grip", "50:300")])
def test_law_the_verdicts_are_a_table_at_every_width(more: tuple[str, ...], columns: int) -> None:
    screen = run("decide", *MINE, "--ping", "80ms", "--ping-jitter", "10ms", *more, columns=columns).stdout
    assert all(len(line) <= columns for line in screen.splitlines())
    assert re.search(r"^any constant delay +", screen, re.MULTILINE)
    assert "is no matter" not in screen
    assert "factor of e" not in screen


def test_law_help_has_no_broken_line() -> None:
    """Every paragraph of the help fills its lines: none ends before the next word would fit."""
    lines = [line.strip() for line in run("decide", "--help").stdout.splitlines()]
    text = lines[: next(i for i, line in enumerate(lines) if line.startswith("╭"))]
    for line, following in pairwise(text):
        if line and following:
            assert len(line) + 1 + len(following.split()[0]) > 76, line


@pytest.mark.parametrize("given", ["no", 0, 1, 2.0])
def test_law_only_a_bool_promises_a_playout_buffer(given: object) -> None:
    network = ts.Network(0.04, jitter=0.01, sample_period=0.001)
    dyad = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
    with pytest.raises(ts.InvalidInput, match="playout_buffer"):
        ts.decide(dyad, 150.0, network, playout_buffer=given)  # type: ignore[arg-type]


def test_law_a_short_answer_rounds_no_limit_up() -> None:
    dyad = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
    for delay in (0.03, 0.04, 0.05, 0.06, 0.07):
        answer = ts.decide(dyad, 50.0, delay)
        shown = float(repr(answer).split("stiffness limit ")[1].split(" ")[0])
        assert answer.stiffness_limit is not None
        assert shown <= answer.stiffness_limit


def test_law_a_stiffness_near_the_largest_allowed_is_answered() -> None:
    dyad = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
    answer = ts.decide(dyad, 9.6e6, 0.04, allow_unusual=True)
    assert answer.status == "unstable"
    assert ts.decide(dyad, 9.6e6, allow_unusual=True).limits is not None


@pytest.mark.parametrize(("jitter", "largest"), [("10ms", "90 ms"), ("100ms", "180 ms")])
def test_law_the_screen_says_which_pings_are_meant(jitter: str, largest: str) -> None:
    screen = flat(run("decide", *MINE, "--ping", "80ms", "--ping-jitter", jitter).stdout)
    assert f"Pings from 80 ms (the smallest) to {largest} are meant." in screen
    assert ("subtract the smallest" in screen) == (jitter == "100ms")
