"""What to change to be stable with the reserve; every change is a number that was judged itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from telespring._core import RESERVE, STIFFEST, WITHIN, constant_delay, is_stable, is_within, usual_range
from telespring.decision.bisection import largest_usable
from telespring.decision.question import Question
from telespring.decision.usable import (
    SOFTEST_USUAL,
    STIFFEST_USUAL,
    RobotErrors,
    is_usable,
    largest_stiffness_with_reserve,
    longest_with_reserve,
    round_limit,
)
from telespring.decision.varying_delay import varying_delay
from telespring.model import Dyad, Network, Robot
from telespring.theory.verdicts import Tier

__all__ = ["WIDER_TIERS", "Changes", "Guarantee", "find_changes", "find_guarantees"]

#: The tiers whose networks include all networks of a tier.
WIDER_TIERS: dict[Tier, tuple[Tier, ...]] = {
    "any constant delay": ("any network",),
    "age in a range": ("bounded varying delay", "any network"),
    "bounded varying delay": ("any network",),
}
#: Sample periods that are tried, as shares of the given one.
_SHORTER = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
#: Dampings that are tried, as multiples of the least that may be enough, and halvings between two of them.
_MORE_DAMPING = (1.0, 1.02, 1.1, 1.3, 2.0, 4.0, 10.0)
_HALVINGS = 4
#: A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
_PROBE = 1.0


@dataclass(frozen=True)
class Changes:
    """Single changes, each of which `decide` calls stable: with the reserve, and probable enough.

    They hold with free handles, too, if that is part of the question. Each value has the four digits that are
    shown, and was judged as it is. None where no such change was found.

    Attributes
    ----------
    varying_stiffness
        Without a playout buffer, this stiffness or less, N/m; None if the delay does not vary, or if a
        buffer is promised.
    is_buffer_enough
        Whether a playout buffer alone is such a change. The changes that follow are for a constant delay: if
        the delay varies, that behind a buffer.
    stiffness
        This stiffness or less, N/m.
    delay
        These one-way delays of the network or less, forward and backward, s; jitter and gaps come on top.
    added_damping
        This damping or more, N·s/m, added to both robots.
    sample_period
        This sample period of both controllers, s.
    """

    varying_stiffness: float | None = None
    is_buffer_enough: bool = False
    stiffness: float | None = None
    delay: tuple[float, float] | None = None
    added_damping: float | None = None
    sample_period: float | None = None


@dataclass(frozen=True)
class Guarantee:
    """A stiffness that is stable on more networks than the one in question, with the reserve.

    Attributes
    ----------
    tier
        What those networks may do.
    stiffness
        This stiffness or less, N/m, of four digits; the stiffness in question if that is proven already.
    needs_buffer
        Whether a playout buffer is necessary for it.
    is_proven_now
        Whether the stiffness in question need not change.
    """

    tier: Tier
    stiffness: float
    needs_buffer: bool
    is_proven_now: bool


def find_changes(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> Changes:
    """Find what to change where not all cases, free and held handles, are stable with the reserve.

    Examples
    --------
    >>> import telespring as ts
    >>> mine = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
    >>> question = Question(mine, ts.Network(0.04, sample_period=0.001))
    >>> found = find_changes([question], 250.0, RobotErrors((None, None), known=False))
    >>> found.stiffness, found.delay
    (190.4, (0.029, 0.029))
    """
    varying, is_enough = None, False
    if cases[0].is_varying and not cases[0].has_playout_buffer:
        varying = _varying_stiffness(cases, stiffness, errors)
        if not cases[0].is_as_stated:
            # No buffer takes up what is lost, queued or forged.
            return Changes(varying)
        is_enough = _are_usable(cases, stiffness, errors)
    if is_enough:
        return Changes(varying, is_buffer_enough=True)
    return Changes(
        varying,
        stiffness=_softer(cases, errors),
        delay=_nearer(cases, stiffness, errors),
        added_damping=_damped(cases, stiffness, errors),
        sample_period=_sampled_faster(cases, stiffness, errors),
    )


def _are_usable(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> bool:
    return all(is_usable(question, stiffness, errors) for question in cases)


def _largest_rounded(is_good: Callable[[float], bool], most: float, *, least: float = 0.0) -> float | None:
    """Return the largest value of four digits that was found good."""
    found = largest_usable(
        lambda value: round_limit(value) >= least and is_good(round_limit(value)), most, least=least
    )
    return round_limit(found) or None


def _softer(cases: Sequence[Question], errors: RobotErrors) -> float | None:
    most = min(largest_stiffness_with_reserve(each, each.judge(_PROBE)) for each in cases)
    return _largest_rounded(
        lambda k: _are_usable(cases, k, errors), min(most, STIFFEST_USUAL), least=SOFTEST_USUAL
    )


def _varying_stiffness(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> float | None:
    found = round_limit(min(_usable_while_varying(cases, stiffness, errors), STIFFEST_USUAL))
    return found if found >= SOFTEST_USUAL else None


def _usable_while_varying(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> float:
    """Return the stiffness up to which all cases are stable while the delay varies, N/m."""
    found = [varying_delay(each, each.judge(stiffness), errors.robots) for each in cases]
    return min(0.0 if each is None else each.usable_stiffness for each in found)


def _nearer(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> tuple[float, float] | None:
    network = cases[0].network
    extra, mean = 0.5 * sum(network.jitters) + network.max_gap, 0.5 * sum(network.delay)
    if mean == 0.0:
        return None
    longest = min(_longest(each, stiffness) for each in cases)
    timing = network.jitters, network.max_gap, network.sample_period, network.computing_time

    def rounded(share: float) -> tuple[float, float]:
        forward, backward = (round_limit(share * delay) if share > 0.0 else 0.0 for delay in network.delay)
        return forward, backward

    def is_good(share: float) -> bool:
        delay = rounded(share)
        changed = [replace(each, network=Network(delay, *timing)) for each in cases]
        return all(_has_no_limit_before(each, stiffness) for each in changed) and _are_usable(
            changed, stiffness, errors
        )

    found = largest_usable(is_good, min(1.0, (longest - extra) / mean))
    return rounded(found) if found > 0.0 else None


def _longest(question: Question, stiffness: float) -> float:
    stiffer = question.judge(min((1.0 + RESERVE) * stiffness, STIFFEST))
    return longest_with_reserve(
        question.delay_limit(question.judge(stiffness)), question.delay_limit(stiffer)
    )


def _has_no_limit_before(question: Question, stiffness: float) -> bool:
    """Whether every shorter delay is stable, too."""
    judged = question.judge(stiffness)
    return is_within(0.5 * sum(constant_delay(judged)), question.delay_limit(judged))


def _damped(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> float | None:
    least = max((_least_damping(each, stiffness) for each in cases), default=0.0)
    if np.isinf(least):
        return None
    own = max(float(np.max(robot.damping)) for robot in cases[0].dyad.robots)
    most = usual_range("damping")[1] - own
    least = max(least, 1e-3 * own, 1e-3)

    def is_good(added: float) -> bool:
        return added <= most and _are_usable(
            [_with_damping(each, added) for each in cases], stiffness, errors
        )

    below = None
    for factor in _MORE_DAMPING:
        enough = round_limit(factor * least, up=True)
        if is_good(enough):
            break
        below = enough
    else:
        return None
    for _ in range(_HALVINGS if below is not None else 0):
        assert below is not None
        middle = round_limit(0.5 * (below + enough), up=True)
        below, enough = (below, middle) if is_good(middle) else (middle, enough)
    return enough


def _least_damping(question: Question, stiffness: float) -> float:
    """Return a damping, N·s/m, that makes 5 % more stiffness and delay stable; infinite without a rule."""
    forward, backward = constant_delay(question.judge(stiffness))
    later = question.at_delay(((1.0 + RESERVE) * forward, (1.0 + RESERVE) * backward))
    judged = later.judge(min((1.0 + RESERVE) * stiffness, STIFFEST))
    # No remedy is given for what is stable, nor where no rule gives one.
    return 0.0 if is_stable(judged) else judged.remedies.damping or np.inf


def _with_damping(question: Question, added: float) -> Question:
    one, other = (
        Robot(robot.mass, np.asarray(robot.damping) + added, axes=robot.axes)
        for robot in question.dyad.robots
    )
    return replace(question, dyad=Dyad(one, other, question.dyad.operators, question.dyad.coupling_damping))


def _sampled_faster(cases: Sequence[Question], stiffness: float, errors: RobotErrors) -> float | None:
    network = cases[0].network
    if network.sample_period == 0.0 or not all(
        each.judge(stiffness).tier("constant delay").satisfied for each in cases
    ):
        return None
    for share in _SHORTER:
        period = round_limit(share * network.sample_period)
        if period < max(network.computing_time, 1e-5):
            break
        timing = network.delay, network.jitters, network.max_gap, period, network.computing_time
        if _are_usable([replace(each, network=Network(*timing)) for each in cases], stiffness, errors):
            return period
    return None


def find_guarantees(
    cases: Sequence[Question], stiffness: float, errors: RobotErrors
) -> tuple[Guarantee, ...]:
    """Find what is stable on more networks than the one in question, in all cases, free and held handles.

    The network with more freedom comes later. "Any constant delay" has no rule for controllers that sample.

    Examples
    --------
    >>> import telespring as ts
    >>> mine = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
    >>> question = Question(mine, ts.Network(0.04, sample_period=0.001))
    >>> [found] = find_guarantees([question], 150.0, RobotErrors((None, None), known=False))
    >>> found.tier, found.stiffness
    ('any network', 7.133)
    """
    network = cases[0].network
    is_varying = cases[0].is_varying and not cases[0].has_playout_buffer
    found: list[Guarantee] = []
    for verdicts in zip(*(reversed(each.judge(stiffness).tiers) for each in cases), strict=True):
        tier = verdicts[0].tier
        bounds = [each.stiffness_bound for each in verdicts if each.stiffness_bound is not None]
        is_satisfied = all(each.satisfied for each in verdicts)
        assumption_met = all(each.assumption_met for each in verdicts)
        if (
            tier == "constant delay"
            # Without jitter and gaps only the hold of a sample varies its age: the network is the same.
            or (tier == "age in a range" and network.is_constant)
            or (tier == "any constant delay" and network.sample_period > 0.0)
            or len(bounds) < len(cases)
            or (is_satisfied and assumption_met)
        ):
            continue
        needs_buffer = is_varying and not assumption_met
        if not cases[0].is_bounded or (needs_buffer and not cases[0].is_as_stated):
            continue
        k = (
            stiffness
            if is_satisfied
            else round_limit(min(min(bounds) / (1.0 + RESERVE) * WITHIN, STIFFEST_USUAL))
        )
        if k < SOFTEST_USUAL:
            continue
        if is_varying and not needs_buffer:
            is_good = k <= _usable_while_varying(cases, stiffness, errors)
        else:
            is_good = _are_usable(cases, k, errors)
        if is_good:
            found.append(Guarantee(tier, k, needs_buffer, is_satisfied))
    return _without_less(found)


def _without_less(found: list[Guarantee]) -> tuple[Guarantee, ...]:
    """Leave out what allows no more than a network with more freedom."""
    return tuple(
        each
        for each in found
        if not any(
            wider.tier in WIDER_TIERS.get(each.tier, ())
            and wider.stiffness >= each.stiffness
            and not wider.needs_buffer
            for wider in found
        )
    )
