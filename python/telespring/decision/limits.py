"""What a dyad may use: the stiffness at given delays, and the delay at a given stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from telespring.decision.question import LONGEST_DELAY, Question, constant_delay, stiffness_limit
from telespring.decision.reserve import RESERVE
from telespring.decision.varying_delay import VaryingDelay, usable_delay_while_varying, varying_delay
from telespring.model import Network
from telespring.theory.verdicts import Verdicts

__all__ = ["COMMON_DELAYS", "DelayLimits", "Limits", "StiffnessLimits", "limits"]

#: One-way delays that are listed where none is given, s.
COMMON_DELAYS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)

#: A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
_PROBE = 1.0


@dataclass(frozen=True)
class DelayLimits:
    """What one delay allows.

    Attributes
    ----------
    verdicts
        The bounds of every tier, with the network in question; its stiffness means nothing.
    stiffness_limit
        Every smaller stiffness is stable at this constant delay, N/m, sampled controllers included.
    usable_stiffness
        The largest stiffness that keeps the reserve of stiffness and delay, N/m; infinite if there is no
        limit, 0 if there is none.
    varying
        What holds without a playout buffer; None if the delay does not vary. Its status means nothing.
    """

    verdicts: Verdicts
    stiffness_limit: float
    usable_stiffness: float
    varying: VaryingDelay | None = None

    @property
    def delay(self) -> tuple[float, float]:
        """Forward and backward one-way delay of the network, s."""
        return self.verdicts.network.delay

    @property
    def constant_delay(self) -> tuple[float, float]:
        """The delay that is judged, s: with jitter or gaps that behind a playout buffer."""
        return constant_delay(self.verdicts)

    @property
    def buffered(self) -> bool:
        """Whether only a playout buffer makes the delay constant."""
        return self.constant_delay != self.delay


@dataclass(frozen=True)
class StiffnessLimits:
    """What one stiffness allows.

    Attributes
    ----------
    stiffness
        In N/m.
    delay_limit
        Shorter one-way delays are stable, s; infinite if none destabilises, 0 if none is stable.
    usable_delay
        The longest one-way delay that keeps the reserve of stiffness and delay, s.
    usable_delay_while_varying
        The same without a playout buffer, jitter and gaps on top of it; None if the delay does not vary.
    """

    stiffness: float
    delay_limit: float
    usable_delay: float
    usable_delay_while_varying: float | None = None


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
    has_playout_buffer
        Whether a playout buffer is promised, which makes the delay constant.
    free
        The limits with free handles; None if the handles are free, or if it was not requested.
    """

    axes: tuple[str, ...]
    delays: tuple[DelayLimits, ...]
    is_delay_given: bool
    stiffness: StiffnessLimits | None
    over_operator_ranges: bool
    has_playout_buffer: bool = False
    free: Limits | None = None


def limits(
    question: Question,
    stiffness: float | None = None,
    *,
    delays: Sequence[float] | None = None,
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
    network = question.network
    timing = network.jitter, network.max_gap, network.sample_period, network.computing_time
    asked: Sequence[float | tuple[float, float]] = (network.delay,) if delays is None else delays
    questions = [replace(question, network=Network(delay, *timing)) for delay in asked]
    free = None
    if compare_free and question.is_held:
        free = limits(question.with_operators(None), stiffness, delays=delays)
    return Limits(
        axes=tuple(str(name) for name in question.dyad.axes),
        delays=tuple(_delay_limits(each) for each in questions),
        is_delay_given=delays is None,
        stiffness=None if stiffness is None else _stiffness_limits(question, stiffness),
        over_operator_ranges=question.operator_ranges is not None,
        has_playout_buffer=question.has_playout_buffer,
        free=free,
    )


def _delay_limits(question: Question) -> DelayLimits:
    judged = question.judge(_PROBE)
    forward, backward = constant_delay(judged)
    more = 1.0 + RESERVE
    later = question.at_delay((more * forward, more * backward)).judge(_PROBE)
    limit = stiffness_limit(judged)
    return DelayLimits(
        judged,
        stiffness_limit=limit,
        usable_stiffness=min(limit / more, stiffness_limit(later)),
        varying=varying_delay(question, judged),
    )


def _stiffness_limits(question: Question, stiffness: float) -> StiffnessLimits:
    at_once = question.at_delay(0.0)
    more = 1.0 + RESERVE
    limit = at_once.delay_limit(at_once.judge(stiffness))
    stiffer = at_once.delay_limit(at_once.judge(more * stiffness))
    usable = min(limit / more, stiffer)
    extra = question.network.jitter + question.network.max_gap
    # Jitter and gaps are part of the delay behind a playout buffer.
    varying = None if extra == 0.0 else usable_delay_while_varying(question, stiffness, LONGEST_DELAY)
    return StiffnessLimits(stiffness, max(0.0, limit - extra), max(0.0, usable - extra), varying)
