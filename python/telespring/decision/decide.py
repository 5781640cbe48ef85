"""Whether a dyad is stable over a network, by what margin, and what to change.

The screen, `--json` and the report all read the `Decision` made here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from telespring import _core
from telespring._core import constant_delay, is_axis_stable, is_instability_proven, is_stable, stiffness_limit
from telespring._html import table
from telespring._types import Status
from telespring.decision.changes import Changes, Guarantee, find_changes, find_guarantees
from telespring.decision.question import Question, are_axes_independent, constant_delay_tier
from telespring.decision.uncertainty import MarginUncertainty, RobotUncertainty, margin_uncertainty
from telespring.decision.usable import RobotErrors
from telespring.decision.varying_delay import VaryingDelay, limit_with_errors
from telespring.model import DyadAxis
from telespring.theory.criteria import Crossing, decay_stiffness
from telespring.theory.verdicts import AxisVerdict, OperatorPoint, Tier, Verdicts

if TYPE_CHECKING:
    from telespring.decision.arm_stability import ArmStability
    from telespring.study.robot_file import RobotRecord

__all__ = ["AxisDecision", "Decision", "OperatorMargins", "decide", "decide_case"]


@dataclass(frozen=True)
class OperatorMargins:
    """The margins of one axis with one pair of operators.

    Attributes
    ----------
    operators
        What holds the handles of robots 1 and 2.
    critical_stiffness_paper
        By Eq. 5, N/m.
    maximum_delay_paper
        By Eqs. 5 to 9 as printed, s; NaN if the paper has no formula (operators, coupling damper).
    stable_delays
        All stable intervals of the one-way delay up to the horizon, s.
    sampled_stable_delays
        The same with sampled controllers: the mean delay, both ways in their proportion; an interval
        excludes its start and includes its end. None without a sample period.
    stable_around
        The stable interval that contains the delay, s, with the controllers in question, cut off at the
        horizon or at twice the delay if that is more; None if none does.
    spectral_abscissa
        Largest real part of the characteristic roots without the rigid-body root, 1/s.
    crossings
        Where roots cross the imaginary axis.
    """

    operators: tuple[OperatorPoint, OperatorPoint]
    critical_stiffness_paper: float
    maximum_delay_paper: float
    stable_delays: tuple[tuple[float, float], ...]
    sampled_stable_delays: tuple[tuple[float, float], ...] | None
    stable_around: tuple[float, float] | None
    spectral_abscissa: float
    crossings: tuple[Crossing, ...]


@dataclass(frozen=True)
class AxisDecision:
    """The margins of one axis.

    All that is here holds for every operator in question; what belongs to one pair of operators is in
    `worst_case`.

    Attributes
    ----------
    verdict
        The verdict of every tier on this axis, the worst over ranges of operators.
    worst_case
        The margins with the operators that allow the least stiffness at this delay; if the operators are
        not ranges, with those.
    """

    verdict: AxisVerdict
    worst_case: OperatorMargins

    @property
    def name(self) -> str:
        """Name of the axis."""
        return self.verdict.name

    @property
    def critical_stiffness(self) -> float:
        """Below it no constant delay destabilises, N/m."""
        return self._bound("any constant delay")

    @property
    def maximum_stiffness(self) -> float:
        """Below it every stiffness is stable at this delay, N/m; infinite without delay."""
        return self._bound("constant delay")

    @property
    def maximum_delay(self) -> float:
        """End of the first stable interval, one way, s; infinite if no delay destabilises."""
        return self.verdict.maximum_delay

    @property
    def sampled_abscissa(self) -> float | None:
        """Rate of the slowest mode under sampled controllers, 1/s; None without a sample period."""
        return None if self.verdict.sampled is None else self.verdict.sampled.abscissa_equivalent

    @property
    def stable(self) -> bool:
        """Whether the delay is stable for every operator, under sampled controllers too if they sample."""
        return is_axis_stable(self.verdict)

    def _bound(self, name: Tier) -> float:
        bound = next(tier.stiffness_bound for tier in self.verdict.tiers if tier.tier == name)
        return math.nan if bound is None else bound


@dataclass(frozen=True, repr=False)
class Decision:
    """The answer for one dyad, stiffness and network.

    The margins are those at a constant delay: with jitter or gaps that behind a playout buffer. What holds
    without one is in `varying`.

    Attributes
    ----------
    question
        What is answered, with the network in question.
    answer
        What the core decides: status, reserve, and what holds while the delay varies.
    axes
        The margins axis by axis.
    horizon
        Stable intervals are listed up to this one-way delay, s.
    added_damping
        More than this damping, N·s/m, must be added to both robots for a stable constant delay; 0 if it is
        stable now, infinite if no damping is known to suffice.
    decay_rate
        The rate, 1/s, at which every motion but the common drift should decay; None if none was given.
    decay_stiffness
        Ranges of stiffness, N/m, that decay so on all axes, ascending; an infinite end is no limit. They
        hold for continuous controllers and, over ranges of operators, for the worst case of each axis.
    uncertainty
        How well the margins are known and how probable stability is, where the masses and dampings of the
        robots have errors; None if they do not, or if the axes of a robot are not independent. Over ranges of
        operators for the worst case of each axis.
    robots_without_errors
        The robots, 1 or 2, whose masses and dampings have no errors.
    robot_records
        What identification recorded about robots 1 and 2.
    free
        The decision on the same question with free handles; None if the handles are free, or if it was not
        requested.
    changes
        What to change, where this answer or that for free handles is not "stable"; None where both are, or
        where the axes of a robot are not independent, so that nothing is proven.
    guarantees
        What is stable on more networks than the one in question, where both answers are "stable".
    arms
        Stability in the study's own arms; None if it was not requested.
    """

    question: Question
    answer: _core.Decision
    axes: tuple[AxisDecision, ...]
    horizon: float
    added_damping: float
    decay_rate: float | None = None
    decay_stiffness: tuple[tuple[float, float], ...] = ()
    uncertainty: MarginUncertainty | None = None
    robots_without_errors: tuple[int, ...] = (1, 2)
    robot_records: tuple[RobotRecord | None, RobotRecord | None] = (None, None)
    free: Decision | None = None
    changes: Changes | None = None
    guarantees: tuple[Guarantee, ...] = ()
    arms: ArmStability | None = None

    def __repr__(self) -> str:
        values = " ".join(f"{name}={value!r}" for name, value in self._in_short().items())
        return f"<Decision {values}>"

    def _repr_html_(self) -> str:
        margins = [
            {
                "axis": axis.name,
                "critical_stiffness": axis.critical_stiffness,
                "maximum_stiffness": axis.maximum_stiffness,
                "maximum_delay": axis.maximum_delay,
            }
            for axis in self.axes
        ]
        return table("Decision", {**self._in_short(), "axes": margins})

    def _in_short(self) -> dict[str, object]:
        return {
            "status": self.status,
            "stiffness": self.stiffness,
            "delay": self.constant_delay,
            "stiffness_limit": self.stiffness_limit,
            "delay_limit": self.delay_limit,
        }

    @property
    def status(self) -> Status:
        """The answer in one word: "stable", "marginal", "unstable" or "not proven".

        A playout buffer that nobody promised does not count. Where something is not judged
        (`question.unjudged`), nothing is proven.
        """
        return self.answer.status

    @property
    def worst_status(self) -> Status:
        """The answer for free and held handles together, the worse of both."""
        return _core.worst_status([each.status for each in (self, self.free) if each is not None])

    @property
    def constant_delay_status(self) -> Status:
        """The answer at a constant delay, which with jitter or gaps needs a playout buffer.

        Where no buffer can make the delay constant, it is `status`.
        """
        return self.answer.constant_delay_status

    @property
    def verdicts(self) -> Verdicts:
        """The verdicts of all tiers and of the paper, with the stiffness and network in question."""
        return self.answer.verdicts

    @property
    def varying(self) -> VaryingDelay | None:
        """The answer without a playout buffer; None if the delay does not vary."""
        return self.answer.varying

    @property
    def keeps_stiffness_reserve(self) -> bool:
        """Whether it stays stable with 5 % more stiffness."""
        return self.answer.keeps_stiffness_reserve

    @property
    def keeps_delay_reserve(self) -> bool:
        """Whether it stays stable with 5 % more delay."""
        return self.answer.keeps_delay_reserve

    @property
    def keeps_reserve(self) -> bool:
        """Whether it has the reserve of stiffness and delay, and is probable enough if robots have errors."""
        return self.answer.keeps_reserve

    @property
    def is_proven(self) -> bool:
        """Whether nothing that was not examined may decide: coupled axes, roots that were not counted."""
        return self.answer.is_proven

    @property
    def is_instability_proven(self) -> bool:
        """Whether some operator in question is unstable; if not, a search over ranges was cut off."""
        return is_instability_proven(self.verdicts)

    @property
    def delay_limit(self) -> float:
        """Shorter one-way delays are stable, s, with the controllers in question.

        0 if none is, infinite if no delay destabilises. The mean of both ways, which grow in proportion.
        """
        return self.answer.delay_limit.delay

    @property
    def delay_limit_attained(self) -> bool:
        """Whether the limit of the delay is itself stable: sampled controllers see whole periods only."""
        return self.answer.delay_limit.attained

    @property
    def delay_limit_proven(self) -> bool:
        """Whether the limit is at most 5 % and a period low; if not, a search over ranges was cut off."""
        return self.answer.delay_limit.proven

    @property
    def over_operator_ranges(self) -> bool:
        """Whether operators are ranges."""
        return self.question.operator_ranges is not None

    @property
    def has_playout_buffer(self) -> bool:
        """Whether a playout buffer is promised, which makes the delay constant."""
        return self.question.has_playout_buffer

    @property
    def stiffness(self) -> float:
        """The stiffness in question, N/m."""
        return self.verdicts.stiffness

    @property
    def delay(self) -> tuple[float, float]:
        """Forward and backward one-way delay of the network, s, as stated."""
        return self.question.network_as_stated.delay

    @property
    def constant_delay(self) -> tuple[float, float]:
        """The delay that is judged, s: the network's, or with jitter or gaps that behind a playout buffer."""
        return constant_delay(self.verdicts)

    @property
    def mean_delay(self) -> float:
        """Half of the round trip, s: all that stability depends on, except for rounding to sample periods."""
        return 0.5 * sum(self.constant_delay)

    @property
    def buffered(self) -> bool:
        """Whether only a playout buffer makes the delay constant."""
        return self.constant_delay != self.verdicts.network.delay

    @property
    def is_bounded(self) -> bool:
        """Whether the ages of the motion in use have a bound."""
        return self.question.is_bounded

    @property
    def is_as_stated(self) -> bool:
        """Whether delay, jitter and gap are all that makes the ages: a playout buffer takes them up."""
        return self.question.is_as_stated

    @property
    def sampled_stable(self) -> bool | None:
        """Whether sampled controllers are stable; None without a sample period."""
        return self.verdicts.sampled_stable

    @property
    def continuous_stable(self) -> bool:
        """Whether continuous controllers are stable at this constant delay for every operator."""
        return self.verdicts.tier("constant delay").satisfied

    @property
    def stable(self) -> bool:
        """Whether this constant delay is stable for every operator, sampled controllers included."""
        return is_stable(self.verdicts)

    @property
    def stiffness_limit(self) -> float:
        """Every smaller stiffness is stable at this delay, sampled controllers included, N/m; may be 0."""
        return stiffness_limit(self.verdicts)

    @property
    def worst_axis(self) -> AxisDecision:
        """An unstable axis if there is one, else any; of these the one that decays slowest."""
        return max(
            self.axes,
            key=lambda axis: (
                not axis.stable,
                axis.worst_case.spectral_abscissa if axis.sampled_abscissa is None else axis.sampled_abscissa,
            ),
        )

    @property
    def axes_independent(self) -> bool | None:
        """Whether identification found the axes of both robots independent; None if it is not known.

        If it is False, no verdict here holds: all of them treat the axes separately.
        """
        return are_axes_independent(self.robot_records)


def decide(
    question: Question,
    stiffness: float,
    *,
    horizon: float | None = None,
    decay_rate: float | None = None,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None),
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
    compare_free: bool = False,
    attack_seed: int | None = None,
) -> Decision:
    """Judge a stiffness in a question, and compute the margins.

    Parameters
    ----------
    question
        The dyad, what holds it, and its network.
    stiffness
        Stiffness of the virtual spring, N/m.
    horizon
        List stable intervals up to this one-way delay, s. The default is 1 s, or twice the delay if that
        is more.
    decay_rate
        Also compute the stiffnesses at which every motion decays at least this fast, 1/s.
    uncertainty
        Errors of the robots' masses and dampings, as `telespring.Study.uncertainty` gives them.
    records
        What identification recorded, as `robot_record` reads it.
    compare_free
        Whether to answer the question for free handles too, if they are held.
    attack_seed
        Also search, from seeded starts, from which stiffness on a delay that varies as the network's may make
        the motion grow; about a second, and more where the ages are spread wide.

    Returns
    -------
    Decision
        Verdicts and margins.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of range.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.decision.question import Question
    >>> question = Question(ts.hman(), ts.Network(0.1, sample_period=0.001))
    >>> [decide(question, k).status for k in (71.2, 97.0, 110.0)]
    ['stable', 'marginal', 'unstable']
    """
    decision = decide_case(
        question,
        stiffness,
        horizon=horizon,
        decay_rate=decay_rate,
        uncertainty=uncertainty,
        records=records,
        attack_seed=attack_seed,
    )
    cases = [question]
    if compare_free and question.is_held:
        cases.append(question.released())
        free = decide_case(
            cases[1],
            stiffness,
            horizon=decision.horizon,
            uncertainty=uncertainty,
            records=records,
            attack_seed=attack_seed,
        )
        decision = replace(decision, free=free)
    errors = RobotErrors.of(uncertainty, records)
    answers = [each for each in (decision, decision.free) if each is not None]
    if decision.axes_independent is False or question.unjudged:
        return decision
    if all(each.status == "stable" for each in answers):
        return replace(decision, guarantees=find_guarantees(cases, stiffness, errors))
    return replace(decision, changes=find_changes(cases, stiffness, errors))


def decide_case(
    question: Question,
    stiffness: float,
    *,
    horizon: float | None = None,
    decay_rate: float | None = None,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None),
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
    attack_seed: int | None = None,
) -> Decision:
    """Judge a stiffness for one way of holding the handles, without what to change, which takes longest.

    Everything is as for `decide`.
    """
    # Without jitter and gaps nothing varies that could attack.
    seed = None if question.network.is_constant or not question.is_bounded else attack_seed
    # Checks every value before anything is derived from it.
    judged = question.judge(stiffness, seed)
    forward, backward = constant_delay(judged)
    mean = 0.5 * (forward + backward)
    horizon = horizon if horizon is not None else max(1.0, 2.0 * mean)
    worst = question.held_by(judged)
    are_coupled = are_axes_independent(records) is False
    known = None
    if uncertainty != (None, None) and not are_coupled:
        known = margin_uncertainty(
            worst, uncertainty, stiffness, (forward, backward), sampling=question.sampling
        )
    answer = question.core.decision(
        judged,
        _core.Knowledge(
            has_coupled_axes=are_coupled,
            stable_probability=None if known is None else known.stable.value,
            varying_stiffness_limit=limit_with_errors(question, uncertainty),
            is_attack_searched=seed is not None,
        ),
    )
    return Decision(
        question,
        answer,
        axes=tuple(
            AxisDecision(
                verdict,
                _operator_margins(axis, verdict, stiffness, (forward, backward), horizon, question.sampling),
            )
            for axis, verdict in zip(worst, judged.axes, strict=True)
        ),
        horizon=horizon,
        added_damping=0.0 if is_stable(judged) else judged.remedies.damping or math.inf,
        decay_rate=decay_rate,
        decay_stiffness=() if decay_rate is None else tuple(decay_stiffness(worst, mean, decay_rate)),
        uncertainty=known,
        robots_without_errors=tuple(i for i, each in enumerate(uncertainty, start=1) if each is None),
        robot_records=records,
    )


def _contains(interval: tuple[float, float], delay: float, *, has_end: bool) -> bool:
    """Whether a stable interval contains a delay; it excludes its start, unless that is 0."""
    start, end = interval
    return (start < delay or start == 0.0) and (delay <= end * (1.0 + 1e-9) if has_end else delay < end)


def _operator_margins(
    axis: DyadAxis,
    verdict: AxisVerdict,
    stiffness: float,
    delay: tuple[float, float],
    horizon: float,
    sampling: tuple[float, float],
) -> OperatorMargins:
    mean, is_sampled = 0.5 * sum(delay), sampling[0] > 0.0
    # Once, up to the farther end; the list ends at the horizon.
    farthest = max(horizon, 2.0 * mean)
    intervals = axis.stable_delays(stiffness, farthest)
    sampled = axis.sampled_stable_delays(stiffness, *sampling, delay, farthest) if is_sampled else []
    around = sampled if is_sampled else intervals
    return OperatorMargins(
        operators=constant_delay_tier(verdict).operators,
        critical_stiffness_paper=DyadAxis(*axis.parameters).critical_stiffness("paper"),
        maximum_delay_paper=_maximum_delay_paper(axis, stiffness),
        stable_delays=_up_to(horizon, intervals),
        sampled_stable_delays=_up_to(horizon, sampled) if is_sampled else None,
        stable_around=next((each for each in around if _contains(each, mean, has_end=is_sampled)), None),
        spectral_abscissa=axis.spectral_abscissa(stiffness, delay),
        crossings=tuple(axis.crossings(stiffness)),
    )


def _up_to(horizon: float, intervals: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    return tuple((start, min(end, horizon)) for start, end in intervals if start < horizon)


def _maximum_delay_paper(axis: DyadAxis, stiffness: float) -> float:
    if not axis.is_plain:
        return math.nan
    if axis.dampings == (0.0, 0.0):
        # Eq. 5 allows no stiffness here, and the fraction in Eq. 9 is 0/0: no sign, no angle, no delay.
        return 0.0
    return axis.maximum_delay(stiffness, "paper")
