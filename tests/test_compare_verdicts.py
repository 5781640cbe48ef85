"""What a comparison asks `decide` about the bare spring, with the ages as they were played."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import telespring as ts
from telespring.comparison.spring_verdicts import SpringVerdicts

DELAY = 0.084
STUDY = ts.Study.paper().replace(controller={"sample_period": 0.001}, network={"delay": DELAY})


def of_ages(shortest: tuple[float, float], longest: tuple[float, float]) -> ts.Network:
    """Return a network with these ages at robots 1 and 2; robot 1 receives on the way backward."""
    jitters = longest[1] - shortest[1], longest[0] - shortest[0]
    return ts.Network((shortest[1], shortest[0]), jitter=jitters, sample_period=0.001)


@pytest.mark.parametrize("stiffness", [17.8, 71.2, 107.0, 112.5, 142.5])
def test_cross_ages_as_promised_are_judged_as_the_study_says(stiffness: float) -> None:
    ages = (DELAY, DELAY)
    status = SpringVerdicts(STUDY).status(stiffness, DELAY, ages, ages)
    assert status == ts.decide(STUDY, stiffness).status


@pytest.mark.parametrize("is_buffer_promised", [False, True])
def test_cross_stated_jitter_is_judged_with_or_without_the_buffer(is_buffer_promised: bool) -> None:
    """The ages within the jitter, or the constant one behind the buffer, which allows more."""
    study = STUDY.replace(network={"jitter": 0.02, "playout_buffer": is_buffer_promised})
    played = (DELAY, 0.104) if not is_buffer_promised else (0.104, 0.104)
    words = []
    for stiffness in (60.0, 80.0, 91.0):
        status = SpringVerdicts(study).status(stiffness, DELAY, (played[0],) * 2, (played[1],) * 2)
        assert status == ts.decide(study, stiffness).status
        words.append(status)
    assert words[-1] == ("stable" if is_buffer_promised else "not proven")


def test_law_an_adaptive_playout_is_no_buffer() -> None:
    """Its ages vary: what a buffer at 104 ms would allow is not called stable."""
    study = STUDY.replace(network={"jitter": 0.02}, session={"playout": "adaptive"})
    ages = ((0.085, 0.085), (0.107, 0.107))
    status = SpringVerdicts(study).status(91.0, DELAY, *ages)
    assert status == ts.decide(study, 91.0).status != "stable"


def test_cross_ages_that_nobody_promised_are_judged_as_they_were_played() -> None:
    shortest, longest = (0.080, DELAY), (0.101, 0.110)
    verdicts, words = SpringVerdicts(STUDY), []
    for stiffness in (30.0, 78.0, 84.0, 130.0):
        word = verdicts.status(stiffness, DELAY, shortest, longest)
        assert word == ts.decide(STUDY.dyad, stiffness, of_ages(shortest, longest)).status
        words.append(word)
    assert words[0] == "stable"
    # A spring that is stable at the stated delay is not called so at ages that are longer.
    assert ts.decide(STUDY, 84.0).status == "stable"
    assert words[2] != "stable"


def test_law_a_later_playout_is_judged_at_its_own_age() -> None:
    """It plays later than the network delivers, and so the limit is lower."""
    study = STUDY.replace(session={"playout": {"kind": "fixed", "delay": 0.1}})
    verdicts, age = SpringVerdicts(study), (0.1, 0.1)
    for stiffness in (80.0, 95.0, 105.0):
        word = verdicts.status(stiffness, DELAY, age, age)
        assert word == ts.decide(STUDY.dyad, stiffness, ts.Network(0.1, sample_period=0.001)).status


@pytest.mark.parametrize("strategy", ["guard", "wave-variables"])
def test_law_the_bare_spring_is_judged_whatever_the_strategy(strategy: str) -> None:
    ages = (DELAY, DELAY)
    study = STUDY.replace(session={"strategy": strategy, "predictor": "linear"})
    assert SpringVerdicts(study).status(71.2, DELAY, ages, ages) == ts.decide(STUDY, 71.2).status


def test_law_losses_count_with_the_gaps_of_an_hour() -> None:
    """What a short rehearsal played is less than what the network may do."""
    ages = (DELAY, DELAY)
    study = STUDY.replace(network={"loss": 0.3})
    assert SpringVerdicts(study).status(95.0, DELAY, ages, ages) == ts.decide(study, 95.0).status
    assert ts.decide(STUDY, 95.0).status == "stable" != ts.decide(study, 95.0).status


def test_law_without_ages_the_stated_network_is_judged() -> None:
    nothing = (math.nan, math.nan)
    status = SpringVerdicts(STUDY).status(71.2, DELAY, nothing, nothing)
    assert status == "stable"


@pytest.mark.parametrize("shortest", [(0.05, 0.05), (0.084, 0.06)])
@pytest.mark.parametrize("stiffness", [60.0, 80.0])
def test_cross_the_longest_age_is_where_the_verdict_ends(
    stiffness: float, shortest: tuple[float, float]
) -> None:
    limits = SpringVerdicts(STUDY).longest_ages(stiffness, shortest, (0.4, 0.3))
    width = limits[0] - shortest[0]
    assert limits[1] - shortest[1] == pytest.approx(width)
    assert 0.0 < width < 0.24

    def holds(wide: float) -> bool:
        longest = shortest[0] + wide, shortest[1] + wide
        judged = ts.verdicts(STUDY.dyad, stiffness, of_ages(shortest, longest))
        return judged.tier("age in a range").satisfied

    for wide in np.linspace(0.0, 0.24, 25).tolist():
        if abs(wide - width) > 2e-4:
            assert holds(wide) == (wide < width)


def test_law_ages_that_all_lie_in_the_verdict_need_no_search() -> None:
    verdicts = SpringVerdicts(STUDY)
    assert verdicts.longest_ages(60.0, (0.05, 0.05), (0.06, 0.055)) == pytest.approx((0.06, 0.06))
    # A constant age at which the spring is unstable lies in no verdict.
    assert verdicts.longest_ages(142.5, (DELAY, DELAY), (DELAY, DELAY)) == (0.0, 0.0)


def test_law_a_damper_under_sampled_controllers_has_no_verdict_on_ages() -> None:
    verdicts = SpringVerdicts(STUDY.replace(coupling={"stiffness": 60.0, "damping": 2.0}))
    assert np.isnan(verdicts.longest_ages(60.0, (0.05, 0.05), (0.06, 0.06))).all()


def test_law_a_promised_buffer_makes_no_recorded_delay_constant(tmp_path: Path) -> None:
    """The ages behind it are those that were played, and they varied."""
    (tmp_path / "t.csv").write_text("time_s,delay_ms\n0,20\n1,260\n2,20\n")
    network = {"trace": "t.csv", "delay": 0.05}
    ages = (0.05, 0.05), (0.26, 0.26)
    words = [
        SpringVerdicts(STUDY.replace(network={**network, "playout_buffer": promised})).status(
            45.0, 0.05, *ages
        )
        for promised in (False, True)
    ]
    assert words == ["not proven", "not proven"]


def test_cross_controllers_that_are_rehearsed_slowly_are_judged_so() -> None:
    """Continuous controllers on paper, sampled every 25 ms in the laboratory."""
    sampled = ts.Study.paper().replace(controller={"sample_period": 0.025}, network={"delay": 0.05})
    on_paper = sampled.replace(controller={"sample_period": 0.0}, laboratory={"sample_period": 0.025})
    ages = (0.05, 0.05), (0.05, 0.05)
    for stiffness in (60.0, 130.0):
        word = SpringVerdicts(on_paper).status(stiffness, 0.05, *ages)
        assert word == ts.decide(sampled, stiffness).status
    assert word == "unstable"
