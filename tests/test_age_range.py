"""Age in a range: the verdict from Python, compared with the gain of the loop on a grid of frequencies."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
import scipy.stats
from typer.testing import CliRunner

import telespring as ts
from age_range_gain import gain
from telespring.cli import app
from telespring.decision.question import Question
from telespring.decision.varying_delay import varying_delay

ARM = ts.Robot(0.8334, 7.7257)
#: Standard errors of 0.02 kg and 0.25 N·s/m of either robot.
ERRORS = ts.Study.from_toml(
    "robot1 = {mass = 1, damping = 5, mass_sd = 0.02, damping_sd = 0.25}\n"
    "robot2 = {mass = 1, damping = 5, mass_sd = 0.02, damping_sd = 0.25}\n"
).uncertainty


@pytest.mark.parametrize("ages", [((0.03, 0.07), (0.03, 0.07)), ((0.09, 0.12), (0.02, 0.1))])
def test_cross_the_bound_is_where_the_gain_on_a_grid_reaches_one(
    ages: tuple[tuple[float, float], tuple[float, float]],
) -> None:
    other = ts.Robot(1.9, 5.2)
    bound = ts.Dyad(ARM, other).axis(0).age_range_stiffness(ages[1], ages[0])
    assert gain(0.99 * bound, ages, ARM, other) < 1.0 < gain(1.01 * bound, ages, ARM, other)


def test_ref_a_little_jitter_no_longer_costs_a_tier() -> None:
    # DESIGN: 95 to 105 ms, 94.6 N/m, between 73.6 of a bounded delay and 98.9 of the longest constant one.
    found = ts.verdicts(ts.Dyad(ARM, ARM), 80.0, 0.095, jitter=0.01)
    tier = found.tier("age in a range")
    assert tier.stiffness_bound == pytest.approx(94.61, abs=0.01)
    assert tier.satisfied
    assert tier.ages is not None
    assert tier.ages[0] == pytest.approx((0.095, 0.105))
    assert found.stiffness_allowed is not None
    assert found.stiffness_allowed.tier == "age in a range"
    assert tier.attack is None
    attacked = ts.verdicts(ts.Dyad(ARM, ARM), 80.0, 0.095, jitter=0.01, attack_seed=3).tier("age in a range")
    assert attacked.attack == pytest.approx(97.0, rel=0.02)


def test_law_a_sampled_coupling_damper_has_no_bound() -> None:
    damped = ts.Dyad(ARM, ARM, coupling_damping=0.5)
    found = ts.verdicts(damped, 30.0, 0.1, jitter=0.01, sample_period=0.001).tier("age in a range")
    assert found.stiffness_bound is None
    assert found.unavailable == "coupling damping with sampled controllers"
    assert ts.verdicts(damped, 30.0, 0.1, jitter=0.01).tier("age in a range").satisfied


def test_law_without_jitter_it_is_the_constant_delay() -> None:
    found = ts.verdicts(ts.hman(), 30.0, 0.1)
    assert found.tier("age in a range").stiffness_bound == found.tier("constant delay").stiffness_bound
    assert found.stiffness_allowed is not None
    assert found.stiffness_allowed.tier == "constant delay"


def test_law_over_a_range_of_operators_no_single_pair_has_less() -> None:
    low, high = ts.Operator(0.1, 1.0, 20.0), ts.Operator(0.6, 3.0, 120.0)
    held = ts.verdicts(ts.Dyad(ARM, ARM), 30.0, 0.08, jitter=0.02, operator_range=ts.OperatorRange(low, high))
    tier = held.tier("age in a range")
    assert tier.stiffness_bound is not None
    random = np.random.default_rng(5)
    for _ in range(60):
        pair = [ts.Operator(*random.uniform((0.1, 1.0, 20.0), (0.6, 3.0, 120.0)).tolist()) for _ in range(2)]
        own = ts.verdicts(ts.Dyad(ARM, ARM, (pair[0], pair[1])), 30.0, 0.08, jitter=0.02)
        bound = own.tier("age in a range").stiffness_bound
        assert bound is not None
        assert bound >= tier.stiffness_bound


def test_law_decide_answers_by_it_while_the_delay_varies() -> None:
    question = Question(ts.hman(), ts.Network(0.08, jitter=0.02, sample_period=0.001))
    found = varying_delay(question, question.judge(80.0))
    assert found is not None
    assert (found.status, found.tier) == ("stable", "age in a range")
    assert varying_delay(question, question.judge(found.usable_stiffness)).status == "stable"  # type: ignore[union-attr]
    robots = ["--robot", "0.8334,7.7257"] * 2
    options = [*robots, "--stiffness", "80", "--delay", "80ms", "--jitter", "20ms"]
    answer = json.loads(CliRunner().invoke(app, ["decide", "--json", *options]).stdout)
    assert answer["varying_delay"]["verdict"] == "age in a range"
    assert answer["verdicts"]["age_in_a_range"]["ages"][0] == pytest.approx([0.08, 0.101])


def test_cross_each_way_has_its_own_jitter() -> None:
    other = ts.Robot(1.9, 5.2)
    dyad, network = ts.Dyad(ARM, other), ts.Network((0.08, 0.03), jitter=(0.04, 0.01))
    tier = ts.verdicts(dyad, 40.0, network).tier("age in a range")
    assert tier.ages is not None
    assert [list(ages) for ages in tier.ages] == [pytest.approx([0.08, 0.12]), pytest.approx([0.03, 0.04])]
    assert tier.stiffness_bound is not None
    # What arrives at robot 1 took the way back.
    ages = ((0.08, 0.12), (0.03, 0.04))
    assert gain(0.99 * tier.stiffness_bound, ages, ARM, other) < 1.0
    assert gain(1.01 * tier.stiffness_bound, ages, ARM, other) > 1.0
    larger = ts.verdicts(dyad, 40.0, ts.Network((0.08, 0.03), jitter=0.04)).tier("age in a range")
    assert larger.stiffness_bound is not None
    assert larger.stiffness_bound < 0.95 * tier.stiffness_bound
    assert network.oldest_partner_sample == pytest.approx((0.12, 0.04))
    assert network.buffered == pytest.approx((0.12, 0.04))


def test_law_a_network_with_two_jitters_is_kept_whole() -> None:
    network = ts.Network(0.08, jitter=(0.01, 0.03), sample_period=0.001)
    assert (network.jitter, network.jitters) == (0.03, (0.01, 0.03))
    assert pickle.loads(pickle.dumps(network)) == network
    assert eval(repr(network), {"Network": ts.Network}) == network
    assert network.to_dict()["jitter"] == [0.01, 0.03]
    assert network != ts.Network(0.08, jitter=0.03, sample_period=0.001)
    text = "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\n"
    study = ts.Study.from_toml(
        f"{text}network = {{delay = 0.08, jitter = {{forward = 0.01, backward = 0.03}}}}"
    )
    assert study.network == network
    assert ts.Study.from_toml(f"{text}network.delay = 0.02").replace(network=network).network == network
    assert ts.Study.from_toml(study.to_toml()).network == network
    with pytest.raises(ts.InvalidInput, match="a jitter is one number for both ways"):
        ts.Network(0.08, jitter=(0.01, 0.02, 0.03))


def test_law_decide_allows_more_where_only_one_way_jitters() -> None:
    limits = [
        ts.decide(ts.hman(), 60.0, ts.Network(0.08, jitter=jitter, sample_period=0.001)).stiffness_limit
        for jitter in (0.02, (0.02, 0.0), (0.0, 0.02), 0.0)
    ]
    assert None not in limits
    both, forward, backward, neither = (limit or 0.0 for limit in limits)
    assert both < min(forward, backward) <= max(forward, backward) < neither
    text = str(ts.decide(ts.hman(), 60.0, ts.Network(0.08, jitter=(0.02, 0.01), sample_period=0.001)))
    assert "20 ms more forward and 10 ms backward (jitter)" in " ".join(text.split())


def test_law_robots_with_errors_are_judged_all_at_once() -> None:
    """No robot within the simultaneous 95 % intervals of mass and damping allows less than what is proven."""
    network = ts.Network(0.08, jitter=0.02)
    question = Question(ts.Dyad(ARM, ts.Robot(1.1, 8.0)), network)
    certain = varying_delay(question, question.judge(40.0))
    found = varying_delay(question, question.judge(40.0), ERRORS)
    assert certain is not None
    assert found is not None
    assert (certain.tier, found.tier) == ("age in a range", "age in a range")
    # Four parameters on two sides.
    width = scipy.stats.norm.ppf(1.0 - 0.05 / 8.0)
    random = np.random.default_rng(11)
    corners = [(i, j, k, n) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1) for n in (-1, 1)]
    bounds = []
    for parts in [*corners, *random.uniform(-1.0, 1.0, (40, 4)).tolist()]:
        masses, dampings = (0.02 * width * np.array(parts[:2]), 0.25 * width * np.array(parts[2:]))
        one = ts.Robot(0.8334 + masses[0], 7.7257 + dampings[0])
        two = ts.Robot(1.1 + masses[1], 8.0 + dampings[1])
        bound = ts.verdicts(ts.Dyad(one, two), 40.0, network).tier("age in a range").stiffness_bound
        assert bound is not None
        bounds.append(bound)
    assert found.usable_stiffness <= min(bounds)
    assert found.usable_stiffness > 0.93 * min(bounds)
    assert found.usable_stiffness < certain.usable_stiffness


def test_law_a_grip_and_errors_are_judged_together() -> None:
    grip = ts.OperatorRange(ts.Operator(), ts.Operator(stiffness=200.0))
    question = Question(ts.Dyad(ARM, ARM), ts.Network(0.08, jitter=0.02, sample_period=0.001), (grip, grip))
    held = varying_delay(question, question.judge(40.0))
    both = varying_delay(question, question.judge(40.0), ERRORS)
    free = varying_delay(question.released(), question.released().judge(40.0), ERRORS)
    assert held is not None
    assert both is not None
    assert free is not None
    assert both.usable_stiffness < held.usable_stiffness
    # A search over a range ends within 1 % of its failure.
    assert both.usable_stiffness < 1.01 * free.usable_stiffness


def test_law_an_attack_is_searched_only_on_request() -> None:
    network = ts.Network(0.08, jitter=0.02, sample_period=0.001)
    plain = ts.decide(ts.hman(), 80.0, network).decision
    assert plain is not None
    assert plain.varying is not None
    assert plain.varying.attack is None
    attacked = ts.decide(ts.hman(), 80.0, network, attack_seed=1)
    assert attacked.decision is not None
    varying = attacked.decision.varying
    assert varying is not None
    assert varying.attack is not None
    assert varying.stiffness_limit < varying.attack < 1.1 * varying.stiffness_limit
    assert attacked.to_dict()["varying_delay"]["attack"] == {"stiffness": varying.attack}
    assert "an attack is known at" in str(attacked)
    assert "if no sample is played after a newer one" in " ".join(str(attacked).split())
    for given in ({"delay": 0.08}, {"delay": network}):
        with pytest.raises(ts.InvalidInput, match="attack_seed"):
            ts.decide(ts.hman(), 80.0 if given["delay"] == 0.08 else None, attack_seed=1, **given)


def test_law_the_command_attacks_a_delay_that_varies() -> None:
    options = ["--stiffness", "80", "--delay", "80ms", "--attack"]
    answer = json.loads(CliRunner().invoke(app, ["decide", "--json", *options, "--jitter", "20ms"]).stdout)
    varying = answer["varying_delay"]
    assert varying["stiffness_limit"] < varying["attack"]["stiffness"] < 1.1 * varying["stiffness_limit"]
    refused = CliRunner().invoke(app, ["decide", *options])
    assert refused.exit_code == 2
    assert "--attack" in refused.output


def test_law_a_session_of_more_than_a_spring_is_told_apart() -> None:
    robot = "{mass = [1, 1], damping = 5}"
    text = f"robot1 = {robot}\nrobot2 = {robot}\nnetwork.delay = 0.02\n"
    study = ts.Study.from_toml(f"{text}coupling.stiffness = 20\n")
    plain = ts.decide(study)
    assert not any("bare spring" in note for note in plain.notes)
    guarded = ts.decide(study.replace(session={"strategy": "guard"}))
    assert "Above its limits the guard weakens the force" in " ".join(str(guarded).split())
    assert guarded.to_dict()["status"] == plain.to_dict()["status"]
    waves = ts.decide(study.replace(session={"strategy": "wave-variables"}))
    assert any("not of the session's strategy" in note for note in waves.notes)
    assert waves.status == "not proven"
