"""What `decide` calls stable: proven, with the reserve and, if the robots have errors, probable enough."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from typing import TYPE_CHECKING, NamedTuple

from telespring._core import LEAST_PROBABILITY, RESERVE, WITHIN, constant_delay, stiffness_limit, usual_range
from telespring.decision.question import Question, are_axes_independent
from telespring.decision.uncertainty import RobotUncertainty, stable_probability

if TYPE_CHECKING:
    from telespring.study.robot_file import RobotRecord
    from telespring.theory.verdicts import DelayLimit, Verdicts

__all__ = [
    "LONGEST_USUAL_DELAY",
    "SOFTEST_USUAL",
    "STIFFEST_USUAL",
    "RobotErrors",
    "is_usable",
    "largest_stiffness_with_reserve",
    "longest_with_reserve",
    "recommended_delay",
    "recommended_stiffness",
    "round_limit",
]

#: What laboratories use, and `decide` accepts without question: stiffness, N/m, and one-way delay, s.
SOFTEST_USUAL, STIFFEST_USUAL = usual_range("stiffness")
LONGEST_USUAL_DELAY = usual_range("delay")[1]

#: Stiffness or delay with the reserve.
_MORE = 1.0 + RESERVE


class RobotErrors(NamedTuple):
    """The errors of both robots; `known` is False where they cannot be carried over."""

    robots: tuple[RobotUncertainty | None, RobotUncertainty | None]
    known: bool

    @classmethod
    def of(
        cls,
        robots: tuple[RobotUncertainty | None, RobotUncertainty | None],
        records: tuple[RobotRecord | None, RobotRecord | None],
    ) -> RobotErrors:
        """Return the errors of robots, of which `records` say whether their axes are independent."""
        return cls(robots, robots != (None, None) and are_axes_independent(records) is not False)

    def allow(self, question: Question, judged: Verdicts) -> bool:
        """Return whether the verdict is probable enough to be called stable."""
        if not self.known:
            return True
        probability = stable_probability(
            question.held_by(judged),
            self.robots,
            judged.stiffness,
            constant_delay(judged),
            sampling=question.sampling,
        )
        return probability.value >= LEAST_PROBABILITY


def is_usable(question: Question, stiffness: float, errors: RobotErrors) -> bool:
    """Return whether `decide` calls a stiffness, N/m, stable at the constant delay, the axes apart."""
    judged = question.judge(stiffness)
    return question.core.is_usable(judged) and errors.allow(question, judged)


def largest_stiffness_with_reserve(question: Question, judged: Verdicts) -> float:
    """Return the stiffness, N/m, up to which 5 % more of it, and 5 % more delay, stay within their limits."""
    forward, backward = constant_delay(judged)
    later = question.at_delay((_MORE * forward, _MORE * backward)).judge(judged.stiffness)
    return min(stiffness_limit(judged) / _MORE, stiffness_limit(later)) * WITHIN


def longest_with_reserve(limit: DelayLimit, stiffer: DelayLimit) -> float:
    """Return the delay, s, up to which 5 % more of it, and 5 % more stiffness, stay within their limits.

    `limit` is that of the stiffness, `stiffer` that of 5 % more.
    """
    own = limit.delay / _MORE if limit.attained else limit.delay / _MORE * WITHIN
    return min(own, _clean(stiffer.delay) if stiffer.attained else stiffer.delay * WITHIN)


def _clean(value: float) -> float:
    """Return a number without what computing has rounded: 51 periods of 1 ms are 0.051 s."""
    return float(f"{value:.14g}")


def recommended_stiffness(usable: float) -> float:
    """Return what may be recommended of a stiffness up to which all may be used, N/m: what laboratories use.

    Examples
    --------
    >>> recommended_stiffness(190.4), recommended_stiffness(111000.0), recommended_stiffness(0.05)
    (190.4, 20000.0, 0.0)
    """
    return 0.0 if usable < SOFTEST_USUAL else min(usable, STIFFEST_USUAL)


def recommended_delay(usable: float) -> float:
    """Return what may be recommended of a delay up to which all may be used, s: what networks have."""
    return min(usable, LONGEST_USUAL_DELAY)


def round_limit(value: float, *, up: bool = False) -> float:
    """Round to the four significant digits that people type, to the safe side.

    Examples
    --------
    >>> round_limit(190.4837), round_limit(1.60212, up=True), round_limit(0.029999999999999999)
    (190.4, 1.603, 0.03)
    """
    rounding = ROUND_CEILING if up else ROUND_FLOOR
    return float(Context(prec=4, rounding=rounding).plus(Decimal(repr(_clean(value)))))
