"""The rule of the answer against single verdicts: command and page ask the core for it, this file not."""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path

import pytest

import telespring as ts
from telespring.decision.decide import decide, decide_case
from telespring.decision.question import Question
from telespring.study.robot_file import RobotRecord
from test_page_answers import needs, on_the_page, random_study

MORE = (1.0, 1.02, 1.035, 1.05)


def is_stable(study: ts.Study, stiffness: float, delay: float) -> bool:
    """Whether the operators of a study are stable at multiples of its stiffness and of its constant delay."""
    network = study.network
    later = (delay * network.buffered[0], delay * network.buffered[1])
    constant = ts.Network(later, sample_period=network.sample_period, computing_time=network.computing_time)
    judged = ts.verdicts(study.dyad, stiffness * study.stiffness, constant)
    return judged.tier("constant delay").satisfied and judged.sampled_stable is not False


def at_constant_delay(study: ts.Study) -> str:
    """Answer for a constant delay by verdicts one at a time."""
    if not is_stable(study, 1.0, 1.0):
        return "unstable"
    keeps = all(is_stable(study, more, 1.0) and is_stable(study, 1.0, more) for more in MORE)
    return "stable" if keeps else "marginal"


def while_varying(study: ts.Study) -> str:
    """Answer without a buffer: what a tier proves, and whether one of the constant delays is unstable."""
    network, k = study.network, study.stiffness

    def allowed(share: float) -> tuple[float, str]:
        delays = (share * network.delay[0], share * network.delay[1])
        timing = network.jitters, network.max_gap, network.sample_period, network.computing_time
        found = ts.verdicts(study.dyad, k, ts.Network(delays, *timing)).stiffness_allowed
        return (0.0, "") if found is None else (found.stiffness, found.tier)

    most, tier = allowed(1.0)
    if k < most:
        nearby = [allowed(share)[0] for share in (0.95, 1.05)] if tier == "age in a range" else []
        return "stable" if 1.05 * k < most and all(k < each for each in nearby) else "marginal"
    for late in (0.0, 1.0):
        delays = tuple(own + late * more for own, more in zip(network.delay, network.jitters, strict=True))
        judged = ts.verdicts(
            study.dyad, k, ts.Network(delays, 0.0, 0.0, network.sample_period, network.computing_time)
        )
        if not judged.tier("constant delay").satisfied or judged.sampled_stable is False:
            return "unstable"
    return "not proven"


def expected(study: ts.Study) -> str:
    varies = not study.network.is_constant and not study.has_playout_buffer
    return while_varying(study) if varies else at_constant_delay(study)


@cache
def studies(count: int = 40, seed: int = 3) -> list[ts.Study]:
    """Draw studies; half of them near a limit, where the reserve decides, and some that vary."""
    draw = random.Random(seed)
    found: list[ts.Study] = []
    while len(found) < count:
        # what is lost leaves the ages without a bound, of which single verdicts know nothing
        study = random_study(draw).replace(network={"loss": 0.0})
        if len(found) % 4 == 0:
            study = study.replace(network={"jitter": draw.uniform(0.2, 1.0) * study.delay[0]})
            allowed = ts.verdicts(study.dyad, study.stiffness, study.network).stiffness_allowed
            if allowed is not None and 0.1 < allowed.stiffness < 1e4:
                study = study.replace(coupling={"stiffness": allowed.stiffness * draw.uniform(0.9, 1.2)})
        limit = ts.delay_limit(study.dyad, study.stiffness, study.network).delay
        if len(found) % 2 and 1e-3 < limit < 1.0 and study.network.is_constant:
            study = study.replace(network={"delay": limit * draw.uniform(0.9, 1.02)})
        judged = ts.verdicts(study.dyad, study.stiffness, study.network)
        bounds = [judged.tier("constant delay").stiffness_bound] + [
            axis.sampled_stiffness_bound for axis in judged.axes
        ]
        # Beyond a limit it may be stable in an island, whose near end counts, too.
        if is_stable(study, 1.0, 1.0) and study.stiffness >= min(each for each in bounds if each is not None):
            continue
        found.append(study)
    return found


def test_cross_the_commands_answer_is_that_of_single_verdicts() -> None:
    words = set()
    for study in studies():
        answer = decide_case(Question.of_study(study), study.stiffness)
        assert answer.status == expected(study), study.to_toml()
        assert answer.varying is not None or answer.constant_delay_status == at_constant_delay(study)
        words.add(answer.status)
    assert words == {"stable", "marginal", "unstable", "not proven"}


def test_cross_the_pages_answer_is_that_of_single_verdicts(root: Path) -> None:
    needs(root)
    for study, page in zip(studies(), on_the_page(root, studies()), strict=True):
        assert page["status"] == expected(study), study.to_toml()


COUPLED = RobotRecord(False, (), None, None)


@pytest.mark.parametrize(
    ("stiffness", "network", "alone", "coupled"),
    [
        (71.2, {"delay": 0.1}, "stable", "not proven"),
        (97.0, {"delay": 0.1}, "marginal", "not proven"),
        (110.0, {"delay": 0.1}, "unstable", "unstable"),
        (60.0, {"delay": 0.08, "jitter": 0.02}, "stable", "not proven"),
        (140.0, {"delay": 0.08, "jitter": 0.02}, "unstable", "unstable"),
    ],
)
def test_law_coupled_axes_take_away_what_is_proven_but_not_what_is_unstable(
    stiffness: float, network: dict[str, float], alone: str, coupled: str
) -> None:
    study = ts.Study.paper().replace(network=network, controller={"sample_period": 0.001})
    question = Question.of_study(study)
    assert decide(question, stiffness).status == alone
    assert decide(question, stiffness, records=(COUPLED, None)).status == coupled
