"""What a dyad may use: the stiffness at given delays, and the delay at a given stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from telespring.decision.question import (
    Question,
    constant_delay,
    refuse_unusual,
    stiffness_limit,
)
from telespring.decision.reserve import RESERVE
from telespring.model import Dyad, Network, OperatorRange
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
    """

    verdicts: Verdicts
    stiffness_limit: float
    usable_stiffness: float

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
    """

    stiffness: float
    delay_limit: float
    usable_delay: float


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
    free
        The limits with free handles; None if the handles are free, or if it was not requested.
    """

    axes: tuple[str, ...]
    delays: tuple[DelayLimits, ...]
    is_delay_given: bool
    stiffness: StiffnessLimits | None
    over_operator_ranges: bool
    free: Limits | None = None


def limits(
    dyad: Dyad,
    delay: float | tuple[float, float] | None = None,
    stiffness: float | None = None,
    *,
    jitter: float = 0.0,
    max_gap: float = 0.0,
    sample_period: float = 0.001,
    computing_time: float = 0.0,
    operator_ranges: tuple[OperatorRange, OperatorRange] | None = None,
    compare_free: bool = False,
    allow_unusual: bool = False,
) -> Limits:
    """Find the stiffness that may be used at a delay, or at common delays, or the delay at a stiffness.

    Parameters
    ----------
    dyad
        The two robots and what holds them.
    delay
        One-way delay each way, s, or the pair (forward, backward); None lists `COMMON_DELAYS`.
    stiffness
        Also find the delay that this stiffness allows, N/m.
    jitter, max_gap, sample_period, computing_time, operator_ranges, compare_free, allow_unusual
        As for `telespring.decision.decide.decide`.

    Returns
    -------
    Limits
        The limits, and what may be used with a reserve of 5 %.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of range, or no laboratory has it.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.decision.decide import decide
    >>> found = limits(ts.hman(), 0.1).delays[0]
    >>> round(found.stiffness_limit, 1), round(found.usable_stiffness, 1)
    (99.7, 95.0)
    >>> decide(ts.hman(), 0.999 * found.usable_stiffness, 0.1).status
    'stable'
    """
    asked: Sequence[float | tuple[float, float]] = COMMON_DELAYS if delay is None else (delay,)
    networks = [Network(each, jitter, max_gap, sample_period, computing_time) for each in asked]
    if not allow_unusual:
        refuse_unusual(dyad, networks[0], operator_ranges, stiffness)
    questions = [Question(dyad, network, operator_ranges) for network in networks]
    free = None
    if compare_free and questions[0].is_held:
        free = limits(
            Dyad(*dyad.robots, coupling_damping=dyad.coupling_damping),
            delay,
            stiffness,
            jitter=jitter,
            max_gap=max_gap,
            sample_period=sample_period,
            computing_time=computing_time,
            allow_unusual=True,
        )
    return Limits(
        axes=tuple(str(name) for name in dyad.axes),
        delays=tuple(_delay_limits(question) for question in questions),
        is_delay_given=delay is not None,
        stiffness=None if stiffness is None else _stiffness_limits(questions[0], stiffness),
        over_operator_ranges=operator_ranges is not None,
        free=free,
    )


def _delay_limits(question: Question) -> DelayLimits:
    judged = question.judge(_PROBE)
    forward, backward = constant_delay(judged)
    more = 1.0 + RESERVE
    later = question.at_delay((more * forward, more * backward)).judge(_PROBE)
    limit = stiffness_limit(judged)
    return DelayLimits(
        judged, stiffness_limit=limit, usable_stiffness=min(limit / more, stiffness_limit(later))
    )


def _stiffness_limits(question: Question, stiffness: float) -> StiffnessLimits:
    at_once = question.at_delay(0.0)
    more = 1.0 + RESERVE
    limit = at_once.delay_limit(at_once.judge(stiffness))
    stiffer = at_once.delay_limit(at_once.judge(more * stiffness))
    usable = min(limit / more, stiffer)
    extra = question.network.jitter + question.network.max_gap
    # Jitter and gaps are part of the delay behind a playout buffer.
    return StiffnessLimits(stiffness, max(0.0, limit - extra), max(0.0, usable - extra))
