"""What is proven while the delay varies, where no playout buffer makes it constant.

The core judges it (`telespring::decision::VaryingDelay`); what errors of the robots take away is found here.
"""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from telespring._core import LEAST_PROBABILITY, RESERVE, STIFFEST, Knowledge, VaryingDelay
from telespring.decision.bisection import largest_usable
from telespring.model import Dyad, Operator, OperatorRange, Robot

if TYPE_CHECKING:
    from telespring.decision.question import Question
    from telespring.decision.uncertainty import RobotUncertainty
    from telespring.theory.verdicts import Tier, Verdicts

__all__ = ["VaryingDelay", "limit_with_errors", "usable_delay_while_varying", "varying_delay"]

_LIGHTEST = 1e-4
#: A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
_PROBE = 1.0


def varying_delay(
    question: Question,
    judged: Verdicts,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None),
) -> VaryingDelay | None:
    """Judge a question without a playout buffer; None if its delay does not vary.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.decision.question import Question
    >>> question = Question(ts.hman(), ts.Network(0.08, jitter=0.02, sample_period=0.001))
    >>> [varying_delay(question, question.judge(k)).status for k in (80.0, 88.0, 95.0, 140.0)]
    ['stable', 'marginal', 'not proven', 'unstable']
    """
    return question.core.varying(
        judged,
        Knowledge(
            has_coupled_axes=False,
            stable_probability=None,
            varying_stiffness_limit=limit_with_errors(question, uncertainty),
            is_attack_searched=False,
        ),
    )


def limit_with_errors(
    question: Question, uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None]
) -> float | None:
    """Return what is proven for all robots but a few while the delay varies, N/m.

    None if the robots have no errors, or if the delay does not vary.
    """
    if uncertainty == (None, None) or not question.is_varying:
        return None
    worse = _worse_robots(question, uncertainty)
    if worse is None:
        return 0.0
    # The worst robots of tiers 1 and 2 are known; for the age in a range all of them are judged at once.
    found = worse.judge(_PROBE)
    if not question.is_bounded:
        return found.tier("any network").stiffness_bound or 0.0
    every = _every_robot(question, uncertainty).judge(_PROBE)
    tiers = found.tier("any network"), found.tier("bounded varying delay"), every.tier("age in a range")
    return max(tier.stiffness_bound or 0.0 for tier in tiers)


def _every_robot(
    question: Question, uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None]
) -> Question:
    """Return the question for all robots but a few, at most 5 %: masses and dampings from low to high.

    The robots are the lightest and least damped ones, and the operators have what others have more.
    """
    deviations = _deviations(question, sides=2)
    robots, ranges = [], []
    for i, (robot, known) in enumerate(zip(question.dyad.robots, uncertainty, strict=True)):
        mass, damping = np.asarray(robot.mass), np.asarray(robot.damping)
        more_mass, more_damping = np.zeros_like(mass), np.zeros_like(damping)
        if known is not None:
            more_mass = deviations * np.asarray(known.mass_sd)
            more_damping = deviations * np.asarray(known.damping_sd)
        lightest = np.maximum(mass - more_mass, np.minimum(mass, _LIGHTEST))
        least = np.maximum(damping - more_damping, 0.0)
        robots.append(Robot(lightest, least, axes=robot.axes))
        held = question.operator_ranges
        low, high = (question.dyad.operators[i],) * 2 if held is None else (held[i].low, held[i].high)
        narrow = Operator(
            *(np.broadcast_to(each, mass.shape) for each in (low.mass, low.damping, low.stiffness))
        )
        wider = Operator(
            high.mass + (mass + more_mass - lightest),
            high.damping + (damping + more_damping - least),
            np.broadcast_to(high.stiffness, mass.shape),
        )
        ranges.append(OperatorRange(narrow, wider))
    dyad = Dyad(robots[0], robots[1], None, question.dyad.coupling_damping)
    return replace(question, dyad=dyad, operator_ranges=(ranges[0], ranges[1]))


def _deviations(question: Question, sides: int) -> float:
    """Return within how many standard errors all parameters are but in 5 % of cases, on one or both sides."""
    parameters = 2 * sum(len(robot.axes) for robot in question.dyad.robots)
    return NormalDist().inv_cdf(1.0 - (1.0 - LEAST_PROBABILITY) / (sides * parameters))


def _worse_robots(
    question: Question, uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None]
) -> Question | None:
    """Return the question for robots that are heavier and less damped than all but a few: at most 5 %.

    More damping never harms in the tier of a bounded delay, nor does less mass in that of any network. A
    sampled coupling damper breaks that: it may destabilise a light and well damped robot, such as one with
    (b + c)·h/m near 1. None is then proven to be the worst: the answer is None.
    """
    if uncertainty == (None, None):
        return question
    if question.network.sample_period > 0.0 and np.any(question.dyad.coupling_damping):
        return None
    deviations = _deviations(question, sides=1)
    robots = []
    for robot, known in zip(question.dyad.robots, uncertainty, strict=True):
        mass, damping = robot.mass, robot.damping
        if known is not None:
            mass = mass + deviations * np.asarray(known.mass_sd)
            damping = np.maximum(damping - deviations * np.asarray(known.damping_sd), 0.0)
        robots.append(Robot(np.maximum(mass, _LIGHTEST), damping, axes=robot.axes))
    dyad = Dyad(robots[0], robots[1], question.dyad.operators, question.dyad.coupling_damping)
    return replace(question, dyad=dyad)


def usable_delay_while_varying(
    question: Question,
    stiffness: float,
    longest: float,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None),
) -> float:
    """Find the one-way delay, s, up to `longest`, to which a stiffness is proven while the delay varies.

    Jitter and gaps come on top of it. It keeps the reserve; infinite if the delay does not matter, 0 if no
    delay is short enough.
    """
    ranges = question.operator_ranges
    worse = _worse_robots(question, uncertainty)
    if worse is None:
        return 0.0
    cases = [((1.0 + RESERVE) * stiffness, question), (stiffness, worse)]

    def with_delay(delay: float, tier: Tier) -> bool:
        for k, asked in cases:
            # In the tier that the delay decides the worst operators are those with the least damping.
            if ranges is not None and tier == "bounded varying delay":
                asked = asked.with_operators((ranges[0].low, ranges[1].low))
            # A stiffness beyond what is judged follows from the bound of its tier.
            asked = asked.at_network_delay(delay)
            judged = asked.judge(min(k, STIFFEST)).tier(tier)
            if not asked.is_bounded and tier != "any network":
                return False
            if not judged.satisfied or (k > STIFFEST and k > (judged.stiffness_bound or 0.0)):
                return False
        return True

    longest -= max(question.at_network_delay(0.0).network.buffered)  # the later way counts
    if longest <= 0.0:
        return 0.0
    if with_delay(longest, "any network"):
        return math.inf
    return largest_usable(lambda delay: with_delay(delay, "bounded varying delay"), longest, resolution=1e-9)
