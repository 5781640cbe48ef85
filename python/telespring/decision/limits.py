"""What a dyad may use: the stiffness at given delays, and the delay at a given stiffness."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from telespring._core import LONGEST_DELAY, RESERVE, SOFTEST, STIFFEST, constant_delay, stiffness_limit
from telespring.decision.bisection import largest_usable
from telespring.decision.question import Question, are_axes_independent
from telespring.decision.uncertainty import RobotUncertainty
from telespring.decision.usable import (
    RobotErrors,
    is_usable,
    largest_stiffness_with_reserve,
    longest_with_reserve,
    recommended_delay,
    recommended_stiffness,
)
from telespring.decision.varying_delay import VaryingDelay, usable_delay_while_varying, varying_delay
from telespring.theory.verdicts import Verdicts

if TYPE_CHECKING:
    from telespring.study.robot_file import RobotRecord

__all__ = ["COMMON_DELAYS", "DelayLimits", "Limits", "StiffnessLimits", "limits"]

#: One-way delays that are listed where none is given, s.
COMMON_DELAYS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)

#: A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
_PROBE = 1.0
#: Stiffness or delay with the reserve.
_MORE = 1.0 + RESERVE
#: Where there is no limit, errors of the robots are examined at this stiffness, N/m.
_STIFFEST = 1e5


@dataclass(frozen=True)
class DelayLimits:
    """What one delay allows.

    Attributes
    ----------
    question
        The question at this delay.
    verdicts
        The bounds of every tier, with the network in question; its stiffness means nothing.
    stiffness_limit
        Every smaller stiffness is stable at this constant delay, N/m, sampled controllers included.
    usable_stiffness
        The largest stiffness that keeps the reserve of stiffness and delay, N/m, with the probability that
        `decide` asks for if the robots have errors: `decide` calls it stable. Infinite if there is no
        limit, 0 if there is none.
    varying
        What holds without a playout buffer; None if the delay does not vary. Its status means nothing.
    """

    question: Question
    verdicts: Verdicts
    stiffness_limit: float
    usable_stiffness: float
    varying: VaryingDelay | None = None

    @property
    def delay(self) -> tuple[float, float]:
        """Forward and backward one-way delay of the network, s, as stated."""
        return self.question.network_as_stated.delay

    @property
    def constant_delay(self) -> tuple[float, float]:
        """The delay that is judged, s: with jitter or gaps that behind a playout buffer."""
        return constant_delay(self.verdicts)

    @property
    def recommended_stiffness(self) -> float:
        """The usable stiffness, N/m, as far as laboratories use one: `decide` accepts it without question."""
        return recommended_stiffness(self.usable_stiffness)

    @property
    def soft_springs_fail_by_sampling(self) -> bool:
        """Whether sampling alone makes every soft spring unstable, so that no stiffness is low enough.

        A held force feeds a handle without damping of its own with a power in proportion to k; the partner
        takes power in proportion to k² only. A stiffer spring may be stable.
        """
        continuous = self.verdicts.tier("constant delay").stiffness_bound
        return (
            self.stiffness_limit == 0.0
            and self.is_sampled_proven
            and continuous is not None
            and continuous > 0.0
        )

    @property
    def is_sampled_proven(self) -> bool:
        """Whether the limit with sampled controllers is at most 5 % low; if not, a search was cut off."""
        return all(axis.sampled_proven is not False for axis in self.verdicts.axes)

    @property
    def buffered(self) -> bool:
        """Whether only a playout buffer makes the delay constant."""
        return self.constant_delay != self.verdicts.network.delay


@dataclass(frozen=True)
class StiffnessLimits:
    """What one stiffness allows.

    Attributes
    ----------
    stiffness
        In N/m.
    delay_limit
        Shorter one-way delays are stable, s; infinite if none destabilises, 0 if none is stable.
    delay_limit_proven
        Whether that is at most 5 % and a period low; if not, a search over ranges of operators was cut off.
    usable_delay
        The longest one-way delay that keeps the reserve of stiffness and delay, s, with the probability that
        `decide` asks for if the robots have errors: `decide` calls it stable.
    usable_delay_while_varying
        The same without a playout buffer, jitter and gaps on top of it; None if the delay does not vary.
    """

    stiffness: float
    delay_limit: float
    delay_limit_proven: bool
    usable_delay: float
    usable_delay_while_varying: float | None = None

    @property
    def recommended_delay(self) -> float:
        """The usable delay, s, as far as networks have one: `decide` accepts it without question."""
        return recommended_delay(self.usable_delay)

    @property
    def recommended_delay_while_varying(self) -> float | None:
        """The same without a playout buffer; None if the delay does not vary."""
        usable = self.usable_delay_while_varying
        return None if usable is None else recommended_delay(usable)


@dataclass(frozen=True)
class Limits:
    """What a dyad may use.

    Attributes
    ----------
    axes
        Names of the axes.
    delays
        What each delay allows; the one in question, or common ones if none is.
    is_delay_given
        Whether a delay was in question.
    stiffness
        What the stiffness in question allows; None if none is.
    over_operator_ranges
        Whether the limits are the worst over ranges of operators.
    robots_have_errors
        Whether errors of the robots limit what may be used.
    axes_independent
        Whether identification found the axes of both robots independent; None if it is not known. If it
        is False, the limits hold axis by axis only.
    has_playout_buffer
        Whether a playout buffer is promised, which makes the delay constant.
    robots_without_errors
        The robots, 1 or 2, whose masses and dampings have no errors.
    robot_records
        What identification recorded about robots 1 and 2.
    free
        The limits with free handles, which only the robots' own springs hold; None if the handles are free,
        or if it was not requested.
    """

    axes: tuple[str, ...]
    delays: tuple[DelayLimits, ...]
    is_delay_given: bool
    stiffness: StiffnessLimits | None
    over_operator_ranges: bool
    robots_have_errors: bool = False
    axes_independent: bool | None = None
    has_playout_buffer: bool = False
    robots_without_errors: tuple[int, ...] = (1, 2)
    robot_records: tuple[RobotRecord | None, RobotRecord | None] = (None, None)
    free: Limits | None = None


def limits(
    question: Question,
    stiffness: float | None = None,
    *,
    delays: Sequence[float] | None = None,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None),
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
    compare_free: bool = False,
) -> Limits:
    """Find the stiffness that may be used at a delay, or at several, or the delay at a stiffness.

    Parameters
    ----------
    question
        The dyad, what holds it, and its network.
    stiffness
        Also find the delay that this stiffness allows, N/m.
    delays
        One-way delays to list instead of the network's own, s, such as `COMMON_DELAYS`.
    uncertainty, records
        As for `telespring.decision.decide.decide`.
    compare_free
        Whether to answer the question for free handles too, if they are held.

    Returns
    -------
    Limits
        The limits, and what may be used with a reserve of 5 %.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of range.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.decision.decide import decide
    >>> question = Question(ts.hman(), ts.Network(0.1, sample_period=0.001))
    >>> found = limits(question).delays[0]
    >>> round(found.stiffness_limit, 1), round(found.usable_stiffness, 1)
    (99.7, 95.0)
    >>> decide(question, 0.999 * found.usable_stiffness).status
    'stable'
    """
    questions = [question] if delays is None else [question.at_network_delay(delay) for delay in delays]
    free = None
    if compare_free and question.is_held:
        free = limits(question.released(), stiffness, delays=delays, uncertainty=uncertainty, records=records)
    errors = RobotErrors.of(uncertainty, records)
    return Limits(
        axes=tuple(str(name) for name in question.dyad.axes),
        delays=tuple(_delay_limits(each, errors) for each in questions),
        is_delay_given=delays is None,
        stiffness=None if stiffness is None else _stiffness_limits(question, stiffness, errors),
        over_operator_ranges=question.operator_ranges is not None,
        robots_have_errors=errors.known,
        axes_independent=are_axes_independent(records),
        has_playout_buffer=question.has_playout_buffer,
        robots_without_errors=tuple(i for i, known in enumerate(uncertainty, start=1) if known is None),
        robot_records=records,
        free=free,
    )


def _delay_limits(question: Question, errors: RobotErrors) -> DelayLimits:
    judged = question.judge(_PROBE)
    limit = stiffness_limit(judged)
    most = largest_stiffness_with_reserve(question, judged)
    if math.isinf(most):
        # Without a limit nothing is to be kept, but errors may give one.
        usable = math.inf if errors.allow(question, question.judge(_STIFFEST)) else _STIFFEST
        most = usable
    if math.isfinite(most):
        usable = largest_usable(lambda stiffness: is_usable(question, stiffness, errors), most, least=SOFTEST)
    return DelayLimits(
        question,
        judged,
        stiffness_limit=limit,
        usable_stiffness=usable,
        varying=varying_delay(question, judged, errors.robots),
    )


def _stiffness_limits(question: Question, stiffness: float, errors: RobotErrors) -> StiffnessLimits:
    at_once = question.at_delay(0.0)
    limit = at_once.delay_limit(at_once.judge(stiffness))
    stiffer = at_once.delay_limit(at_once.judge(min(_MORE * stiffness, STIFFEST)))
    most = longest_with_reserve(limit, stiffer)

    def is_delay_usable(delay: float) -> bool:
        return is_usable(question.at_delay(delay), stiffness, errors)

    if math.isinf(most):
        longest = question.at_delay(LONGEST_DELAY)
        usable = math.inf if errors.allow(longest, longest.judge(stiffness)) else LONGEST_DELAY
        most = usable
    if math.isfinite(most):
        usable = largest_usable(is_delay_usable, min(most, LONGEST_DELAY / _MORE))
    # Jitter and gaps are part of the delay behind a playout buffer, as is all that makes a motion older.
    nearby = question.at_network_delay(0.0)
    extra = max(nearby.network.buffered)
    return StiffnessLimits(
        stiffness,
        delay_limit=max(0.0, limit.delay - extra),
        delay_limit_proven=limit.proven,
        usable_delay=max(0.0, usable - extra),
        usable_delay_while_varying=None
        if not nearby.is_varying
        else usable_delay_while_varying(question, stiffness, LONGEST_DELAY, errors.robots),
    )
