"""What each play-out delay makes of a recorded trace: the ages as played, and the stiffness they allow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from telespring._core import PlayedTrace, Trace
from telespring.decision.limits import COMMON_DELAYS, limits
from telespring.decision.question import Question
from telespring.decision.usable import recommended_stiffness
from telespring.decision.varying_delay import varying_delay
from telespring.model import Network

if TYPE_CHECKING:
    from telespring._types import Tier
    from telespring.decision.uncertainty import RobotUncertainty
    from telespring.study.robot_file import RobotRecord

__all__ = [
    "MOSTLY",
    "SHARES",
    "PlayoutChoice",
    "RobotErrors",
    "best_playout",
    "judge_playouts",
    "longest_useful",
]

#: The shares of the packets that the play-outs wait for; the last is the longest delay.
SHARES = (0.5, 0.75, 0.9, 0.99, 0.999, 1.0)
#: The tiers that are asked, the strongest assumption first.
_TIERS: tuple[Tier, ...] = ("age in a range", "bounded varying delay", "any network")
#: Play-outs with this share of the largest stiffness, or time, are as good: the shortest of them is best.
_AS_GOOD = 0.95
#: Most of the time.
MOSTLY = 0.99
#: A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
_PROBE = 1.0
#: Differences of two ages below this are rounding, s.
_SAME = 1e-9


class RobotErrors(NamedTuple):
    """The errors of both robots, and what identification recorded about them."""

    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None)
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None)


@dataclass(frozen=True)
class PlayoutChoice:
    """A fixed play-out over a recorded trace, and what is proven with it.

    Attributes
    ----------
    delay
        The delay of the play-out, s: a whole number of sample periods.
    share
        The share of the packets that came which it waits for.
    in_time
        The share of the time at which the motion played is exactly as old as the delay, on the worse way.
    ages
        The smallest and the largest age of any sample in use, s, of forward and backward: the range
        [d − J, d + J] in which all lie.
    mostly_ages
        The same for 99 % of the time.
    bounds
        The stiffness below which every one is stable, N/m, by each tier whose assumption holds for these
        ages; infinite if there is no limit, None if the tier has no rule.
    stiffness_limit
        The largest of them, N/m.
    tier
        The tier that gives the largest usable stiffness; None if none has a rule.
    usable_stiffness
        The largest stiffness with a reserve of 5 % and, where the robots have errors, with the least
        probability that `decide` asks for, N/m; also if both hands let go.
    mostly_usable_stiffness
        The same for the ages of 99 % of the time. It is no proof; the guard takes the rest.
    """

    delay: float
    share: float
    in_time: float
    ages: tuple[tuple[float, float], tuple[float, float]]
    mostly_ages: tuple[tuple[float, float], tuple[float, float]]
    bounds: dict[Tier, float | None]
    stiffness_limit: float
    tier: Tier | None
    usable_stiffness: float
    mostly_usable_stiffness: float

    @property
    def is_constant(self) -> bool:
        """Whether all of the time was in time."""
        return self.in_time == 1.0

    @property
    def recommended_stiffness(self) -> float:
        """The usable stiffness, N/m, as far as laboratories use one."""
        return recommended_stiffness(self.usable_stiffness)

    @property
    def network(self) -> tuple[tuple[float, float], float]:
        """Delay of both ways and jitter, s, that say these ages to the verdicts."""
        return _delays_and_jitter(self.ages)


def judge_playouts(
    traces: tuple[Trace, Trace], question: Question, errors: RobotErrors, period: float
) -> tuple[PlayoutChoice, ...]:
    """Judge a play-out for each of `SHARES` over the ways forward and backward.

    `period` is the time between two packets of a session, s.
    """
    shares: dict[float, float] = {}
    for share in SHARES:
        longest = max(trace.quantile(share) for trace in traces)
        shares[round(math.ceil(longest / period - _SAME) * period, 12)] = share
    return tuple(_judge(delay, share, traces, question, errors, period) for delay, share in shares.items())


def longest_useful(traces: Sequence[Trace]) -> float:
    """Return the longest play-out that anybody would choose, s: half a second, or twice the median delay."""
    return max(*COMMON_DELAYS, *(2.0 * trace.quantile(0.5) for trace in traces))


def best_playout(choices: Sequence[PlayoutChoice], longest: float, *, guarded: bool = False) -> PlayoutChoice:
    """Choose among play-outs of up to `longest` s, for a bare spring or with the guard.

    Of those that allow at least 95 % of the largest usable stiffness (with the guard: for 99 % of the time),
    and then of those that are in time for at least 95 % of the longest time, the shortest.
    """

    def stiffness(choice: PlayoutChoice) -> float:
        return choice.mostly_usable_stiffness if guarded else choice.usable_stiffness

    useful = [choice for choice in choices if choice.delay <= longest] or [choices[0]]
    most = max(stiffness(choice) for choice in useful)
    stiff = [choice for choice in useful if stiffness(choice) >= _AS_GOOD * most]
    in_time = max(choice.in_time for choice in stiff)
    return next(choice for choice in stiff if choice.in_time >= _AS_GOOD * in_time)


def _judge(
    delay: float,
    share: float,
    traces: tuple[Trace, Trace],
    question: Question,
    errors: RobotErrors,
    period: float,
) -> PlayoutChoice:
    forward = traces[0].play(delay, period)
    # a table has one trace for both ways
    backward = forward if traces[1] is traces[0] else traces[1].play(delay, period)
    ages = forward.ages, backward.ages
    mostly = _mostly(forward), _mostly(backward)
    allowed = _allowed(question, ages, errors)
    return PlayoutChoice(
        delay,
        share,
        in_time=min(forward.in_time, backward.in_time),
        ages=ages,
        mostly_ages=mostly,
        bounds=allowed.bounds,
        stiffness_limit=allowed.stiffness_limit,
        tier=allowed.tier,
        usable_stiffness=allowed.usable_stiffness,
        mostly_usable_stiffness=_allowed(question, mostly, errors).usable_stiffness,
    )


def _delays_and_jitter(
    ages: tuple[tuple[float, float], tuple[float, float]],
) -> tuple[tuple[float, float], float]:
    (low, high), (other_low, other_high) = ages
    jitter = max(high - low, other_high - other_low)
    return (round(low, 9), round(other_low, 9)), (0.0 if jitter <= _SAME else round(jitter, 9))


@dataclass(frozen=True)
class _Allowed:
    bounds: dict[Tier, float | None]
    stiffness_limit: float
    tier: Tier | None
    usable_stiffness: float


def _allowed(
    question: Question, ages: tuple[tuple[float, float], tuple[float, float]], errors: RobotErrors
) -> _Allowed:
    """Find what these ages allow, whether the handles are held or not."""
    delays, jitter = _delays_and_jitter(ages)
    network = Network(
        delays,
        jitter=jitter,
        sample_period=question.network.sample_period,
        computing_time=question.network.computing_time,
    )
    asked = replace(question, network=network, has_playout_buffer=False)
    cases = [asked, asked.released()] if question.is_held else [asked]
    return min((_allowed_on(case, errors) for case in cases), key=lambda case: case.usable_stiffness)


def _allowed_on(question: Question, errors: RobotErrors) -> _Allowed:
    """Find what a network allows, by the tiers whose assumption it fulfils."""
    if question.network.is_constant:
        found = limits(question, uncertainty=errors.uncertainty, records=errors.records).delays[0]
        judged, limit, usable = found.verdicts, found.stiffness_limit, found.usable_stiffness
        bounds: dict[Tier, float | None] = {"constant delay": limit}
        tier: Tier | None = "constant delay"
    else:
        judged = question.judge(_PROBE)
        varying = varying_delay(question, judged, errors.uncertainty)
        assert varying is not None  # the delay varies
        bounds, tier = {}, varying.tier
        limit, usable = varying.stiffness_limit, varying.usable_stiffness
    for name in _TIERS:
        verdict = judged.tier(name)
        if verdict.assumption_met:
            bounds[name] = verdict.stiffness_bound
    return _Allowed(bounds, limit, tier, usable)


def _mostly(played: PlayedTrace) -> tuple[float, float]:
    """Return the smallest and the largest age, s, without the 1 % of the time furthest from the delay."""
    apart = np.maximum(np.abs(played.newest - played.delay), np.abs(played.oldest - played.delay))
    outside = int((1.0 - MOSTLY) * played.ticks)
    if apart.size <= outside:
        return played.delay, played.delay
    kept = np.argsort(apart, kind="stable")[: apart.size - outside]
    ages = (played.newest[kept].min(), played.oldest[kept].max())
    if apart.size == played.ticks:
        return float(ages[0]), float(ages[1])
    return min(float(ages[0]), played.delay), max(float(ages[1]), played.delay)
