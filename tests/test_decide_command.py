"""The command `decide`: its answer in words and as JSON, over ranges of operators, jitter and sampling."""

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

import telespring as ts
from questions import answered, decide, flat, run


def test_ref_decide_answers_in_json_for_the_papers_case() -> None:
    """71.2 N/m over 167 ms; K from Table III's parameters by Eq. 5."""
    found = run("decide", "--json", "--stiffness", "71.2", "--delay", "0.167", "--continuous")
    assert found.exit_code == 0
    answer = json.loads(found.stdout)
    x, y = answer["axes"]
    assert (x["axis"], y["axis"]) == ("x", "y")
    assert x["critical_stiffness"] == pytest.approx(35.615988, rel=1e-8)
    assert x["critical_stiffness_paper"] == pytest.approx(35.615988, rel=1e-8)
    assert y["critical_stiffness"] == pytest.approx(39.442273, rel=1e-8)
    # at 71.2 N/m, slightly below 2K, both last a little longer than at 2K
    assert 0.16718632424 < x["maximum_delay"] < 0.1675
    assert x["stable_delays"][0] == [0.0, x["maximum_delay"]]
    assert x["stable"]
    assert answer["stable"]
    assert x["spectral_abscissa"] < 0
    assert set(answer["verdicts"]) == {
        "constant_delay",
        "any_constant_delay",
        "age_in_a_range",
        "bounded_varying_delay",
        "any_network",
        "paper",
    }
    assert answer["verdicts"]["constant_delay"]["satisfied"]
    assert answer["allowing_verdict"] == "constant delay"
    bound = answer["verdicts"]["constant_delay"]["stiffness_allowed"]
    assert answer["stiffness_allowed"] == bound == pytest.approx(71.28, abs=0.005)
    assert not answer["verdicts"]["any_constant_delay"]["satisfied"]


def test_law_no_limit_is_valid_json_with_a_flag() -> None:
    found = run("decide", "--json", "--stiffness", "20", "--delay", "0")
    assert "Infinity" not in found.stdout
    assert "NaN" not in found.stdout
    axis = json.loads(found.stdout)["axes"][0]
    assert axis["maximum_delay"] is None
    assert axis["maximum_delay_unbounded"]
    assert axis["maximum_stiffness_unbounded"]


def test_law_an_unstable_answer_is_an_answer_and_says_what_to_change() -> None:
    found = run("decide", "--json", "--stiffness", "71.2", "--delay", "0.3")
    assert found.exit_code == 0
    answer = json.loads(found.stdout)
    assert not answer["stable"]
    softer = run(
        "decide", "--json", "--stiffness", str(0.999 * answer["remedies"]["stiffness"]), "--delay", "0.3"
    )
    nearer = run(
        "decide", "--json", "--stiffness", "71.2", "--delay", str(0.999 * answer["remedies"]["delay"])
    )
    assert json.loads(softer.stdout)["stable"]
    assert json.loads(nearer.stdout)["stable"]
    assert answer["remedies"]["added_damping"] > 0


def test_law_the_screen_says_the_answer_in_words_and_ms() -> None:
    stable, unstable = (run("decide", "--stiffness", "71.2", "--delay", delay) for delay in ("0.1", "0.2"))
    assert "STABLE at this constant delay" in stable.stdout
    assert "UNSTABLE on axis x" in unstable.stdout
    assert "To be stable with the reserve, one of:" in unstable.stdout
    for name in ("constant delay", "any constant delay", "bounded varying delay", "any network", "paper"):
        assert name in stable.stdout
    assert "167.3 ms" in stable.stdout
    # one screen
    assert len(stable.stdout.splitlines()) <= 30


def test_law_unequal_delays_act_by_their_sum() -> None:
    one = json.loads(
        run("decide", "--json", "--stiffness", "71.2", "--delay", "0.2", "--backward", "0.1").stdout
    )
    other = json.loads(run("decide", "--json", "--stiffness", "71.2", "--delay", "0.15").stdout)
    assert one["delay"] == {"forward": 0.2, "backward": 0.1, "mean": pytest.approx(0.15)}
    for left, right in zip(one["axes"], other["axes"], strict=True):
        # 1e-9: two roundings of one root
        assert left["spectral_abscissa"] == pytest.approx(right["spectral_abscissa"], rel=1e-9)


RANGES = """
name = "held by people"
robot1 = {mass = 0.8334, damping = 7.7257}
robot2 = {mass = 0.7776, damping = 7.4208}
operator1.stiffness = {min = 0, max = 300}
operator1.mass = {min = 0, max = 0.5}
operator2.stiffness = {min = 0, max = 300}
coupling.stiffness = 71.2
network = {delay = 0.12, jitter = 0.02, max_gap = 0.01}
controller = {sample_period = 0.004, computing_time = 0.001}
"""


UNDAMPED = """
robot1 = {mass = 1.0, damping = 0.0}
robot2 = {mass = 1.0, damping = 0.0}
coupling.stiffness = 20.0
network.delay = 0.05
"""


#: Stable again at a longer delay.
RETURNING = """
robot1 = {mass = 0.97670822, damping = 2.15372614}
robot2 = {mass = 0.30379312, damping = 4.59594729}
coupling.stiffness = 9.174736188
network.delay = 1.9
"""


def written(folder: Path, text: str) -> str:
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return str(folder / "study.toml")


def damped(dyad: ts.Dyad, damping: float) -> ts.Dyad:
    one, other = (ts.Robot(each.mass, each.damping + damping, axes=dyad.axes) for each in dyad.robots)
    return ts.Dyad(one, other, dyad.operators, dyad.coupling_damping)


def judged(study: ts.Study, **changed: Any) -> ts.Verdicts:
    network = study.network
    return ts.verdicts(
        **{
            "dyad": study.dyad,
            "stiffness": study.stiffness,
            "delay": study.delay,
            "jitter": network.jitter,
            "max_gap": network.max_gap,
            "sample_period": network.sample_period,
            "computing_time": network.computing_time,
            "operator_range": study.operator_ranges,
            **changed,
        }
    )


@pytest.mark.parametrize("stiffness", [20.0, 40.0, 60.0, 71.2, 90.0])
def test_cross_decide_says_what_the_verdicts_say_of_the_whole_file(stiffness: float, tmp_path: Path) -> None:
    """Ranges, jitter, gap and sampling of the file all count, as in `ts.verdicts`."""
    answer = answered(written(tmp_path, RANGES), "--stiffness", str(stiffness))
    truth = judged(ts.Study.from_toml(RANGES), stiffness=stiffness)
    constant = truth.tier("constant delay")
    assert answer["stable"] == (constant.satisfied and truth.sampled_stable is True)
    assert answer["sampled_stable"] == truth.sampled_stable
    assert answer["over_operator_ranges"]
    assert answer["constant_delay"] == {
        "forward": pytest.approx(0.15),
        "backward": pytest.approx(0.15),
        "mean": pytest.approx(0.15),
        "buffered": True,
        "status": answer["constant_delay"]["status"],
    }
    for part in ("network", "jitter", "gap", "sampling", "computing", "total"):
        assert answer["delay_budget"]["forward"][part] == pytest.approx(
            getattr(truth.delay_budget[0], part), rel=1e-12
        )
    for tier in truth.tiers:
        told = answer["verdicts"][tier.tier.replace(" ", "_")]
        assert told["stiffness_allowed"] == tier.stiffness_bound
        assert told["satisfied"] == tier.satisfied
        assert told["assumption"] == tier.assumption
    for told, axis in zip(answer["axes"], truth.axes, strict=True):
        by_name = {tier.tier: tier for tier in axis.tiers}
        assert axis.sampled is not None
        assert told["stable"] == (by_name["constant delay"].satisfied and axis.sampled.stable)
        assert told["maximum_delay"] == (axis.maximum_delay if math.isfinite(axis.maximum_delay) else None)
        assert told["maximum_stiffness"] == by_name["constant delay"].stiffness_bound
        assert told["critical_stiffness"] == by_name["any constant delay"].stiffness_bound
    bounds = [constant.stiffness_bound, *(axis.sampled_stiffness_bound for axis in truth.axes)]
    assert answer["remedies"]["stiffness"] == min(bound for bound in bounds if bound is not None)
    if not answer["stable"]:
        # Each remedy is judged again, sampled controllers and all operators included.
        judge = {"jitter": 0.0, "max_gap": 0.0, "stiffness": stiffness}
        study = ts.Study.from_toml(RANGES)
        shorter = answer["remedies"]["delay"]
        assert shorter is not None
        nearer = judged(study, **judge, delay=0.999 * shorter)
        assert nearer.tier("constant delay").satisfied
        assert nearer.sampled_stable
        firmer = judged(
            study, **judge, delay=0.15, dyad=damped(study.dyad, 1.001 * answer["remedies"]["added_damping"])
        )
        assert firmer.tier("constant delay").satisfied
        assert firmer.sampled_stable


def test_law_the_worst_operator_decides_not_the_middle_one(tmp_path: Path) -> None:
    """The middle operators are stable here, others in the ranges are not."""
    study = ts.Study.from_toml(RANGES)
    stiffness = 90.0
    constant: dict[str, Any] = {
        "jitter": 0.0, "max_gap": 0.0, "sample_period": 0.0, "computing_time": 0.0, "stiffness": stiffness,
    }  # fmt: skip
    assert judged(study, **constant, operator_range=None).tier("constant delay").satisfied
    assert not judged(study, **constant).tier("constant delay").satisfied
    text = RANGES.replace(", jitter = 0.02, max_gap = 0.01", "").replace("controller =", "# controller =")
    text = text.replace("# controller = {sample_period = 0.004, computing_time = 0.001}", "")
    file = written(tmp_path, text)
    answer = answered(file, "--stiffness", str(stiffness))
    assert not answer["stable"]
    assert not answer["axes"][0]["stable"]
    assert answer["remedies"]["added_damping"] > 0.0
    screen = flat(run("decide", file, "--stiffness", str(stiffness)).stdout)
    assert "UNSTABLE on axis x" in screen
    assert "for some operators in their ranges" in screen
    assert "Axis x, worst case at this delay: robot 1" in screen
    assert "middle" not in screen
    softer = str(0.999 * answer["remedies"]["stiffness"])
    assert answered(file, "--stiffness", softer)["stable"]


# The operators at the corners and in the middle of these ranges are stable; some between them are not.
WORST_INSIDE = """
robot1 = {mass = 1.76, damping = 0.6}
robot2 = {mass = 1.14, damping = 5.8}
operator1.stiffness = {min = 49.8, max = 351}
operator2.stiffness = {min = 34.9, max = 270}
coupling.stiffness = 20.0
network.delay = 0.502
"""


def test_law_the_worst_operator_inside_a_range_decides(tmp_path: Path) -> None:
    file = written(tmp_path, WORST_INSIDE)
    answer = answered(file)
    assert not answer["stable"]
    # An operator pair of 118.1 and 57.5 N/m allows 17.15 N/m.
    assert 16.0 < answer["remedies"]["stiffness"] < 17.16
    assert answered(file, "--stiffness", str(0.999 * answer["remedies"]["stiffness"]))["stable"]
    assert answered(file, "--delay", str(0.999 * answer["remedies"]["delay"]))["stable"]


def test_law_jitter_counts_where_a_buffer_makes_the_delay_constant() -> None:
    common = ("--stiffness", "71.2", "--delay", "0.1", "--jitter", "0.1", "--sample-period", "0.001")
    answer = answered(*common)
    assert not answer["stable"]
    assert not answer["verdicts"]["constant_delay"]["satisfied"]
    assert answer["constant_delay"]["mean"] == 0.2
    assert answer["axes"][0]["spectral_abscissa"] > 0.0
    screen = flat(run("decide", *common).stdout)
    assert "With a playout buffer of 200 ms: UNSTABLE on axis x at this constant delay" in screen
    soft = run("decide", "--stiffness", "5", "--delay", "0.1", "--jitter", "0.1").stdout
    assert "nothing to change" in soft  # stable on any network, without a buffer
    stable = flat(run("decide", "--stiffness", "71.2", "--delay", "0.1", "--jitter", "0.01").stdout)
    assert "With a playout buffer of 110 ms: STABLE at this constant delay" in stable
    assert "UNSTABLE" not in stable


def test_law_a_dyad_that_only_sampling_makes_unstable_is_told_so_and_helped() -> None:
    common = ("--delay", "0.1", "--sample-period", "0.05")
    answer = answered("--stiffness", "100", *common)
    assert answer["verdicts"]["constant_delay"]["satisfied"]
    assert answer["sampled_stable"] is False
    assert not answer["stable"]
    assert answered("--stiffness", str(0.999 * answer["remedies"]["stiffness"]), *common)["stable"]
    screen = flat(run("decide", "--stiffness", "100", *common).stdout)
    assert "UNSTABLE on axes x and y at this constant delay with sampled controllers" in screen
    assert "To be stable with the reserve, one of:" in screen
    assert "a stiffness of up to" in screen


@pytest.mark.parametrize("text", [None, RANGES])
def test_law_the_damping_to_add_is_enough_and_no_less_is(text: str | None) -> None:
    study = ts.Study.paper() if text is None else ts.Study.from_toml(text)
    arguments: dict[str, Any] = {"operator_ranges": study.operator_ranges}
    # Corners of the ranges decide about the damping: 90 N/m over 200 ms leaves a free handle the worst.
    added = decide(study.dyad, 90.0, 0.2, **arguments).added_damping
    assert added > 0.0

    def damped_by(damping: float) -> bool:
        return decide(damped(study.dyad, damping), 90.0, 0.2, **arguments).stable

    assert damped_by(1.001 * added)
    assert not damped_by(0.999 * added)


def test_law_undamped_robots_get_an_answer(tmp_path: Path) -> None:
    """Without damping Eq. 9 of the paper is 0/0, and no stiffness and no delay is stable."""
    file = written(tmp_path, UNDAMPED)
    answer = answered(file)
    assert not answer["stable"]
    assert answer["axes"][0]["maximum_delay_paper"] == 0.0
    screen = run("decide", file)
    assert screen.exit_code == 0
    assert "no stiffness is low enough" in screen.stdout
    assert "no delay is short enough" in screen.stdout
    assert "below 0" not in screen.stdout


def test_law_what_the_screen_advises_is_safe_at_the_digits_it_shows() -> None:
    """Limits to the nearest digit would be 167.2 ms here, which is not stable."""
    k = ts.Study.paper().stiffness
    screen = run("decide", "--stiffness", str(k), "--delay", "0.1672").stdout
    assert "UNSTABLE" in screen
    delay = re.search(r"delay of up to ([0-9.]+) ms", screen)
    stiffness = re.search(r"stiffness of up to ([0-9.]+) N/m", screen)
    damping = re.search(r"at least ([0-9.]+) N·s/m", screen)
    assert delay is not None
    assert stiffness is not None
    assert damping is not None
    study = ts.Study.paper()
    assert decide(study.dyad, k, 1e-3 * float(delay[1])).status == "stable"
    assert decide(study.dyad, float(stiffness[1]), 0.1672).status == "stable"
    assert decide(damped(study.dyad, float(damping[1])), k, 0.1672).status == "stable"
    stable = flat(run("decide", "--stiffness", str(k), "--delay", "0.16").stdout)
    grown = re.search(r"by ([0-9.]+) ms, to ([0-9.]+) ms", stable)
    assert grown is not None
    assert decide(study.dyad, k, 0.16 + 1e-3 * float(grown[1])).stable
    assert decide(study.dyad, k, 1e-3 * float(grown[2])).stable


def test_law_in_a_later_interval_both_ends_are_told(tmp_path: Path) -> None:
    """The interval of this dyad is that of the doctest of `ts.stable_delays`: 1.7738 s to 2.1128 s."""
    screen = flat(run("decide", written(tmp_path, RETURNING), "--continuous").stdout)
    assert "the delay may grow by 212.7 ms, to 2.112 s (axis x), and shrink by 126.2 ms, to 1.774 s" in screen


def test_law_a_later_interval_is_open_at_its_start() -> None:
    axis = ts.DyadAxis(0.97670822, 2.15372614, 0.30379312, 4.59594729)
    first, second = axis.stable_delays(9.174736188, 3.0)
    assert axis.is_stable(9.174736188, 0.0)
    assert not axis.is_stable(9.174736188, first[1])
    assert not axis.is_stable(9.174736188, second[0])
    assert axis.is_stable(9.174736188, math.nextafter(second[0], 3.0))
    assert not axis.is_stable(9.174736188, second[1])


def test_law_many_intervals_do_not_fill_the_screen(tmp_path: Path) -> None:
    text = RETURNING.replace("coupling.stiffness = 9.174736188", "coupling.stiffness = 9.0")
    text = text.replace(
        "robot1 = {mass = 0.97670822, damping = 2.15372614}", "robot1 = {mass = 1, damping = 1}"
    )
    text = text.replace(
        "robot2 = {mass = 0.30379312, damping = 4.59594729}", "robot2 = {mass = 1, damping = 1}"
    )
    text += "operator1 = {stiffness = 300}\noperator2 = {stiffness = 300}\n"
    file = written(tmp_path, text)
    answer = answered(file, "--continuous", "--horizon", "1000", "--stiffness", "18")
    intervals = answer["axes"][0]["stable_delays"]
    assert len(intervals) > 6
    screen = flat(run("decide", file, "--continuous", "--horizon", "1000", "--stiffness", "18").stdout)
    assert f"… {len(intervals) - 6} more" in screen
    assert len(screen) < 4000


def test_cross_the_decay_rate_holds_inside_the_range_and_not_outside() -> None:
    """The spectral abscissa, which is found by another way, agrees at both ends on the worse axis."""
    near = ("--stiffness", "71.2", "--delay", "0.05")
    answer = answered(*near, "--decay-rate", "1.5")
    assert answer["decay"]["rate"] == 1.5
    [[low, high]] = answer["decay"]["stiffness"]
    dyad = ts.hman()

    def worst(k: float) -> float:
        return max(float(ts.spectral_abscissa(dyad, k, 0.05, axis=i)) for i in range(2))

    for k in (1.0001 * low, 0.9999 * high):
        assert worst(k) < -1.5
    for k in (0.9999 * low, 1.0001 * high):
        assert worst(k) > -1.5
    screen = flat(run("decide", *near, "--decay-rate", "1.5").stdout)
    told = re.search(r"decays at a rate of at least 1.5 1/s: ([0-9.]+) to ([0-9.]+) N/m", screen)
    assert told is not None
    assert low <= float(told[1]) < 1.001 * low
    assert 0.999 * high < float(told[2]) <= high
    assert answered(*near)["decay"] is None
    assert (
        answered("--stiffness", "71.2", "--delay", "0", "--decay-rate", "1")["decay"]["stiffness"][0][1]
        is None
    )
    assert "1/s: above " in run("decide", "--stiffness", "71.2", "--delay", "0", "--decay-rate", "1").stdout
    assert "1/s: none" in run("decide", *near, "--decay-rate", "50").stdout
    refused = run("decide", *near, "--decay-rate", "-1")
    assert refused.exit_code == 2
    assert "--decay-rate" in refused.stderr
