"""Is this dyad stable, by what margin, and what may it use instead: the answer as plain data.

The terminal table, `--json` and the report all read the `Decision` made here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring.decision.uncertainty import MarginUncertainty, RobotUncertainty, margin_uncertainty
from telespring.model import Dyad, OperatorRange
from telespring.study.editing import RobotRecord
from telespring.theory import criteria, spectrum, verdicts
from telespring.theory.axis import Axis, axes_of, finite_or_none, free_axis, holds
from telespring.theory.criteria import decay_stiffness
from telespring.theory.verdicts import AxisVerdict, DelayBudget, Verdicts

if TYPE_CHECKING:
    from telespring.decision.arms import InArms

__all__ = [
    "TIERS",
    "AxisDecision",
    "Decay",
    "Decision",
    "Remedies",
    "TierDescription",
    "Verdict",
    "decide",
]


@dataclass(frozen=True)
class TierDescription:
    """What one verdict lets the network do, and its rule, in words."""

    key: str
    network: str
    rule: str
    #: The rule in the symbols of NOTATION.md, for a narrow column; T is the age of the oldest sample.
    formula: str


#: The verdicts by name, strongest promise last; the paper's stands beside them.
TIERS: dict[str, TierDescription] = {
    "constant delay": TierDescription(
        "constant_delay",
        "one known constant delay",
        "the delay lies in a stable interval of this stiffness",
        "δ in a stable interval",
    ),
    "any constant delay": TierDescription(
        "any_constant_delay",
        "any constant delay (a playout buffer makes it constant)",
        "the stiffness is below the critical stiffness",
        "k < kₘ exact",
    ),
    "bounded varying delay": TierDescription(
        "bounded_varying_delay",
        "any variation up to a known longest age of a sample",
        (
            "twice the mean damping √(b₁b₂) exceeds the stiffness times the age of the "
            "oldest samples, there and back"
        ),
        "k < 2√(b₁b₂)/(T₁+T₂)",
    ),
    "any network": TierDescription(
        "any_network",
        "anything at all, with bounded gaps",
        "no robot overshoots a partner that is held still: stiffness ≤ b²/(4m) for a free handle",
        "k ≤ b²/(4m) if free",
    ),
    "paper": TierDescription(
        "paper",
        "the paper's claim (Eqs. 5 to 9): one constant delay",
        "the stiffness is at most that of Eq. 5, or the delay is below that of Eq. 6",
        "k ≤ Eq. 5, or δ < Eq. 6",
    ),
}


@dataclass(frozen=True)
class Verdict:
    """One of the four verdicts, or the paper's.

    Attributes
    ----------
    name
        A key of `TIERS`.
    stiffness_allowed
        Largest stiffness that this verdict allows, N/m; infinite where it sets no bound, NaN where
        it is not available.
    attained
        True where that stiffness is itself allowed.
    axis
        The axis that bounds it, or None where none does.
    satisfied
        True where the stiffness asked for is allowed.
    assumption_met
        True where the network asked for is of the kind that the verdict assumes.
    assumption
        The same in words: "met", "met behind playout buffer" (which makes the delay constant), "not met".
    available
        False where the verdict cannot be given for this dyad, such as a coupling damper in tier 2.
    """

    name: str
    stiffness_allowed: float
    attained: bool
    axis: str | None
    satisfied: bool
    assumption_met: bool
    assumption: str
    available: bool = True

    @property
    def description(self) -> TierDescription:
        """The verdict in words."""
        return TIERS[self.name]

    def to_json(self) -> dict[str, Any]:
        """Give SI values; None for an infinite bound (then `stiffness_unbounded` is true)."""
        return {
            "name": self.name,
            "network": self.description.network,
            "rule": self.description.rule,
            "stiffness_allowed": finite_or_none(self.stiffness_allowed),
            "stiffness_unbounded": math.isinf(self.stiffness_allowed),
            "attained": self.attained,
            "axis": self.axis,
            "satisfied": self.satisfied,
            "assumption_met": self.assumption_met,
            "assumption": self.assumption,
            "available": self.available,
        }


@dataclass(frozen=True)
class AxisDecision:
    """The margins of one axis.

    Over ranges of operators the stiffnesses, the maximum delay and `stable` are the worst; what belongs to
    one operator (intervals, crossings, spectral abscissa, the paper's delay) is that of the middle.

    Attributes
    ----------
    axis
        The axis' name.
    critical_stiffness, critical_stiffness_paper
        Exact and by Eq. 5, N/m.
    maximum_delay
        End of the first stable interval, one way, s; infinite where no delay destabilises.
    stable_around
        The stable interval that holds the delay, s, cut off at the horizon or twice the delay if that is
        more; None where none does.
    maximum_delay_paper
        By Eqs. 5 to 9 as printed, s; NaN where the paper has no formula (operators, damper).
    maximum_stiffness
        Below it every stiffness is stable at this delay, N/m; infinite at zero delay.
    stable_delays
        All stable intervals up to the horizon, s.
    spectral_abscissa
        Largest real part of the characteristic roots without the rigid-body root, 1/s.
    sampled_abscissa
        The same for the slowest multiplier of sampled controllers, the worst over the operators, 1/s; None
        without a sample period.
    crossings
        Where roots meet the imaginary axis: delay, frequency, direction.
    stable
        True where the delay is stable for every operator, under sampled controllers too if they sample.
    continuous_stable
        The same for continuous controllers.
    """

    axis: str
    critical_stiffness: float
    critical_stiffness_paper: float
    maximum_delay: float
    maximum_delay_paper: float
    maximum_stiffness: float
    stable_delays: tuple[tuple[float, float], ...]
    stable_around: tuple[float, float] | None
    spectral_abscissa: float
    sampled_abscissa: float | None
    crossings: tuple[dict[str, Any], ...]
    stable: bool
    continuous_stable: bool

    def to_json(self) -> dict[str, Any]:
        """Give SI values; None for infinity, with a `..._unbounded` flag beside it."""
        return {
            "axis": self.axis,
            "critical_stiffness": finite_or_none(self.critical_stiffness),
            "critical_stiffness_unbounded": math.isinf(self.critical_stiffness),
            "critical_stiffness_paper": finite_or_none(self.critical_stiffness_paper),
            "maximum_delay": finite_or_none(self.maximum_delay),
            "maximum_delay_unbounded": math.isinf(self.maximum_delay),
            "maximum_delay_paper": finite_or_none(self.maximum_delay_paper),
            "maximum_delay_paper_unbounded": math.isinf(self.maximum_delay_paper),
            "maximum_stiffness": finite_or_none(self.maximum_stiffness),
            "maximum_stiffness_unbounded": math.isinf(self.maximum_stiffness),
            "stable_delays": [list(interval) for interval in self.stable_delays],
            "spectral_abscissa": finite_or_none(self.spectral_abscissa),
            "sampled_abscissa": None
            if self.sampled_abscissa is None
            else finite_or_none(self.sampled_abscissa),
            "crossings": list(self.crossings),
            "stable": self.stable,
        }


@dataclass(frozen=True)
class Remedies:
    """What to change, one thing at a time, so that the constant delay asked for is stable.

    All are the worst over the operators. Sampled controllers limit the stiffness too; delay and damping
    are those of continuous controllers.

    Attributes
    ----------
    stiffness
        Every smaller stiffness is stable at this delay on all axes, N/m; infinite at zero delay, 0 where
        none is.
    delay
        Every shorter one-way delay is stable at this stiffness on all axes, s, jitter and gaps included;
        may be infinite, 0 where none is.
    added_damping
        More than this damping, N·s/m, must be added to both robots; 0 where nothing is missing.
    """

    stiffness: float
    delay: float
    added_damping: float


@dataclass(frozen=True)
class Decay:
    """The stiffnesses at which every motion dies away at a wanted rate.

    They are those of continuous controllers, for the operators in the middle of their ranges.

    Attributes
    ----------
    rate
        Every motion but the common drift decays at least this fast, 1/s.
    stiffness
        Ranges of stiffness, N/m, that do so on all axes, ascending; an infinite end is no limit.
    """

    rate: float
    stiffness: tuple[tuple[float, float], ...]

    def to_json(self) -> dict[str, Any]:
        """Give SI values; None for the end of a range without limit."""
        return {
            "rate": self.rate,
            "stiffness": [[low, finite_or_none(high)] for low, high in self.stiffness],
        }


@dataclass(frozen=True)
class Decision:
    """The whole answer for one dyad, stiffness and network.

    Attributes
    ----------
    stiffness
        The stiffness asked about, N/m.
    delay
        Forward and backward one-way delay of the network, s.
    constant_delay
        The constant delay that is judged, forward and backward, s: that of the network, or with jitter
        or gaps the one behind the playout buffer.
    horizon
        Stable intervals are listed up to this one-way delay, s.
    axes, verdicts, remedies
        The parts of the answer.
    delay_budget
        What the age of the oldest sample in use is made of, forward and backward: name to s.
    stiffness_allowed, stiffness_allowed_attained, allowing_verdict
        The largest stiffness, N/m, that any verdict gives whose assumption this network meets as it is,
        whether that stiffness is itself allowed, and the verdict's name; None where none does.
    paper_agrees
        True where the paper's verdict on this constant delay is the exact one.
    sampled_stable
        Whether the dyad with sampled controllers is stable too; None without a sample period.
    over_operator_ranges
        True where operators are ranges: what is then the worst over them is said at `AxisDecision`.
    decay
        The stiffnesses that decay as fast as was asked; None where nothing was asked.
    uncertainty
        How well the margins are known and how probable stability is, where the robots' masses and dampings
        carry errors; None where they do not, or where a robot's axes are not independent.
    axes_independent
        False where identification found the axes of a robot coupled: then no verdict axis by axis holds for
        it. True where it found both independent, None where that is not known.
    warnings
        What to know about the robots before trusting the answer, as sentences.
    """

    stiffness: float
    delay: tuple[float, float]
    constant_delay: tuple[float, float]
    horizon: float
    axes: tuple[AxisDecision, ...]
    verdicts: tuple[Verdict, ...]
    delay_budget: tuple[dict[str, float], dict[str, float]]
    remedies: Remedies
    stiffness_allowed: float | None
    stiffness_allowed_attained: bool
    allowing_verdict: str | None
    paper_agrees: bool
    sampled_stable: bool | None
    over_operator_ranges: bool
    decay: Decay | None
    uncertainty: MarginUncertainty | None
    axes_independent: bool | None = None
    warnings: tuple[str, ...] = ()
    in_arms: InArms | None = None

    @property
    def mean_delay(self) -> float:
        """Half of the round trip, s: all that stability depends on."""
        return 0.5 * sum(self.constant_delay)

    @property
    def buffered(self) -> bool:
        """True where only a playout buffer makes the delay constant."""
        return self.constant_delay != self.delay

    @property
    def continuous_stable(self) -> bool:
        """True where the constant delay is stable for every operator if the controllers are continuous."""
        return self.verdict("constant delay").satisfied

    @property
    def stable(self) -> bool:
        """True where the constant delay is stable for every operator, sampled controllers included."""
        return self.continuous_stable and self.sampled_stable is not False

    @property
    def worst_axis(self) -> AxisDecision:
        """An unstable axis if there is one, else any; of these the one that decays slowest."""
        return max(
            self.axes,
            key=lambda axis: (
                not axis.stable,
                axis.spectral_abscissa if axis.sampled_abscissa is None else axis.sampled_abscissa,
            ),
        )

    def verdict(self, name: str) -> Verdict:
        """Find the verdict of that name, a key of `TIERS`."""
        return next(verdict for verdict in self.verdicts if verdict.name == name)

    def to_json(self) -> dict[str, Any]:
        """Give the answer in SI units; None stands for infinity or for what does not exist."""
        remedies = self.remedies
        return {
            "stiffness": self.stiffness,
            "delay": {"forward": self.delay[0], "backward": self.delay[1], "mean": 0.5 * sum(self.delay)},
            "constant_delay": {
                "forward": self.constant_delay[0],
                "backward": self.constant_delay[1],
                "mean": self.mean_delay,
                "buffered": self.buffered,
            },
            "stable": self.stable,
            "worst_axis": self.worst_axis.axis,
            "horizon": self.horizon,
            "axes": [axis.to_json() for axis in self.axes],
            "verdicts": {verdict.description.key: verdict.to_json() for verdict in self.verdicts},
            "stiffness_allowed": (
                None if self.stiffness_allowed is None else finite_or_none(self.stiffness_allowed)
            ),
            "stiffness_allowed_unbounded": self.stiffness_allowed == math.inf,
            "stiffness_allowed_attained": self.stiffness_allowed_attained,
            "allowing_verdict": self.allowing_verdict,
            "paper_agrees": self.paper_agrees,
            "sampled_stable": self.sampled_stable,
            "over_operator_ranges": self.over_operator_ranges,
            "delay_budget": {
                direction: {**parts, "total": sum(parts.values())}
                for direction, parts in zip(("forward", "backward"), self.delay_budget, strict=True)
            },
            "remedies": {
                "stiffness": finite_or_none(remedies.stiffness),
                "stiffness_unbounded": math.isinf(remedies.stiffness),
                "delay": finite_or_none(remedies.delay),
                "delay_unbounded": math.isinf(remedies.delay),
                "added_damping": finite_or_none(remedies.added_damping),
            },
            "decay": None if self.decay is None else self.decay.to_json(),
            "uncertainty": None if self.uncertainty is None else self.uncertainty.to_json(),
            "axes_independent": self.axes_independent,
            "warnings": list(self.warnings),
            "in_arms": None if self.in_arms is None else self.in_arms.to_json(),
        }


def decide(
    dyad: Dyad,
    stiffness: float,
    delay: float | tuple[float, float],
    *,
    jitter: float = 0.0,
    max_gap: float = 0.0,
    sample_period: float = 0.0,
    computing_time: float = 0.0,
    operator_ranges: tuple[OperatorRange, OperatorRange] | None = None,
    horizon: float | None = None,
    decay_rate: float | None = None,
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None] = (None, None),
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
) -> Decision:
    """Answer for one dyad, stiffness and network.

    Parameters
    ----------
    dyad
        The two robots and what holds them.
    stiffness
        Stiffness of the virtual spring, N/m.
    delay
        One-way delay each way, s, or the pair (forward, backward).
    jitter, max_gap, sample_period, computing_time
        What may come on top of the delay, s: its variation, the longest wait for a newer sample, the
        period of the controllers, and from reading the samples to applying the force.
    operator_ranges
        A study's ranges of operators, over which the verdicts are the worst; None for the dyad's own.
    horizon
        List stable intervals up to this one-way delay, s; 1 s, or twice the delay if that is more,
        unless told.
    decay_rate
        Also find the stiffnesses at which every motion decays at least this fast, 1/s.
    uncertainty
        Errors of the robots' masses and dampings, as `telespring.Study.uncertainty` gives them.
    records
        What identification found besides, as `telespring.study.editing.robot_record` reads it.

    Returns
    -------
    Decision
        Verdicts, margins, delay budget and remedies.

    Raises
    ------
    telespring.InvalidInput
        Where a value is out of its range.
    """
    # Checks every value at the door, before anything is derived from it.
    judged = verdicts.verdicts(
        dyad,
        stiffness,
        delay,
        jitter=jitter,
        max_gap=max_gap,
        sample_period=sample_period,
        computing_time=computing_time,
        operator_range=operator_ranges,
    )
    forward, backward = np.broadcast_to(delay, 2).tolist()
    both = (forward, backward)
    constant = judged.tier("constant delay").buffer_delay or both
    mean = 0.5 * sum(constant)
    horizon = horizon if horizon is not None else max(1.0, 2.0 * mean)
    axes = axes_of(dyad)
    allowed = judged.stiffness_allowed
    independent = _independent(records)
    return Decision(
        stiffness=stiffness,
        delay=both,
        constant_delay=constant,
        horizon=horizon,
        axes=tuple(
            _decide_axis(dyad, axis, found, stiffness, constant, horizon)
            for axis, found in zip(axes, judged.axes, strict=True)
        ),
        verdicts=tuple(_verdicts(judged, [axis.name for axis in axes])),
        delay_budget=(_budget(judged.delay_budget[0]), _budget(judged.delay_budget[1])),
        stiffness_allowed=None if allowed is None else allowed.stiffness,
        stiffness_allowed_attained=allowed is not None and allowed.attained,
        allowing_verdict=None if allowed is None else allowed.tier,
        paper_agrees=judged.paper.agrees,
        sampled_stable=judged.sampled_stable,
        over_operator_ranges=operator_ranges is not None,
        remedies=_remedies(judged, axes, stiffness, mean),
        decay=None if decay_rate is None else Decay(decay_rate, _decaying(axes, mean, decay_rate)),
        uncertainty=None
        if uncertainty == (None, None) or independent is False
        else margin_uncertainty(dyad, uncertainty, stiffness, constant),
        axes_independent=independent,
        warnings=tuple(_robot_warnings(uncertainty, records)),
    )


def _independent(records: tuple[RobotRecord | None, RobotRecord | None]) -> bool | None:
    found = [None if record is None else record.independent for record in records]
    return False if False in found else None if None in found else True


def _robot_warnings(
    uncertainty: tuple[RobotUncertainty | None, RobotUncertainty | None],
    records: tuple[RobotRecord | None, RobotRecord | None],
) -> list[str]:
    told = []
    coupled = [i for i, record in enumerate(records, start=1) if record and record.independent is False]
    if coupled:
        whose = "both robots" if len(coupled) == 2 else f"robot {coupled[0]}"
        told.append(
            f"The axes of {whose} are NOT independent. All verdicts and margins here go axis by axis and do "
            "not hold for such a robot; the probability of stability is not given."
        )
    for i, record in enumerate(records, start=1):
        told += [f"Robot {i}, when it was identified: {text}" for text in (record.warnings if record else ())]
    exact = [i for i, known in enumerate(uncertainty, start=1) if known is None]
    if len(exact) == 1 and not coupled:
        told.append(
            f"Robot {exact[0]} carries no errors and is counted as known exactly; the intervals and the "
            f"probability show the errors of robot {3 - exact[0]} alone."
        )
    return told


def _decide_axis(
    dyad: Dyad,
    axis: Axis,
    judged: AxisVerdict,
    stiffness: float,
    delay: tuple[float, float],
    horizon: float,
) -> AxisDecision:
    mean = 0.5 * sum(delay)
    tiers = {tier.tier: tier for tier in judged.tiers}
    satisfied = tiers["constant delay"].satisfied
    around = axis.stable_delays(stiffness, max(horizon, 2.0 * mean))
    return AxisDecision(
        axis=axis.name,
        critical_stiffness=_number(tiers["any constant delay"].stiffness_bound),
        critical_stiffness_paper=free_axis(*axis.parameters).critical_stiffness("paper"),
        maximum_delay=judged.maximum_delay,
        maximum_delay_paper=_maximum_delay_paper(axis, stiffness),
        maximum_stiffness=_number(tiers["constant delay"].stiffness_bound),
        stable_delays=tuple(axis.stable_delays(stiffness, horizon)),
        stable_around=next((interval for interval in around if holds(interval, mean)), None),
        spectral_abscissa=float(spectrum.spectral_abscissa(dyad, stiffness, delay, axis=axis.index)),
        sampled_abscissa=None if judged.sampled is None else judged.sampled.abscissa_equivalent,
        crossings=tuple(crossing.to_dict() for crossing in axis.crossings(stiffness)),
        stable=satisfied and (judged.sampled is None or judged.sampled.stable),
        continuous_stable=satisfied,
    )


def _number(bound: float | None) -> float:
    return math.nan if bound is None else float(bound)


def _maximum_delay_paper(axis: Axis, stiffness: float) -> float:
    if not axis.is_plain:
        return math.nan
    if axis.dampings == (0.0, 0.0):
        # Eq. 5 promises nothing here, and the fraction in Eq. 9 is 0/0: no sign, no angle, no delay.
        return 0.0
    return float(criteria.maximum_delay(*axis.parameters, stiffness, method="paper"))


def _remedies(judged: Verdicts, axes: list[Axis], stiffness: float, mean: float) -> Remedies:
    """Gather what helps on all axes: one that is stable now may be so in a later stable interval only."""
    satisfied = judged.tier("constant delay").satisfied
    sampled = [axis.sampled_stiffness_bound for axis in judged.axes]
    softest = min(
        _number(judged.tier("constant delay").stiffness_bound),
        *(math.inf if bound is None else bound for bound in sampled),
    )
    damping = 0.0
    if not satisfied:
        damping = max(
            judged.remedies.damping or 0.0, *(axis.minimum_damping(stiffness, mean) for axis in axes)
        )
    return Remedies(
        stiffness=softest,
        delay=min(axis.maximum_delay for axis in judged.axes),
        added_damping=damping,
    )


def _decaying(axes: list[Axis], mean: float, rate: float) -> tuple[tuple[float, float], ...]:
    """Intersect the ranges of stiffness, N/m, in which every axis decays at this rate, 1/s."""
    common = [(0.0, math.inf)]
    for axis in axes:
        mine = decay_stiffness(*axis.parameters, mean, rate, **axis.keywords)
        overlaps = [(max(a, c), min(b, d)) for a, b in common for c, d in mine]
        common = [(low, high) for low, high in overlaps if low < high]
    return tuple(sorted(common))


def _verdicts(judged: Verdicts, axis_names: list[str]) -> list[Verdict]:
    """Put the four tiers, the strongest promise last, and the paper's verdict into one form."""
    tiers = [
        Verdict(
            name=tier.tier,
            stiffness_allowed=math.nan if tier.stiffness_bound is None else float(tier.stiffness_bound),
            attained=tier.attained,
            axis=None if tier.worst_axis is None else axis_names[tier.worst_axis],
            satisfied=bool(tier.satisfied),
            assumption_met=tier.assumption_met,
            assumption=tier.assumption,
            available=tier.stiffness_bound is not None,
        )
        for tier in judged.tiers
    ]
    order = list(TIERS)
    constant = next(tier for tier in tiers if tier.name == "constant delay")
    paper_verdict = Verdict(
        name="paper",
        stiffness_allowed=float(judged.paper.critical_stiffness),
        attained=True,
        axis=axis_names[judged.paper.critical_axis],
        satisfied=bool(judged.paper.stable),
        assumption_met=constant.assumption_met,
        assumption=constant.assumption,
    )
    return sorted([*tiers, paper_verdict], key=lambda verdict: order.index(verdict.name))


def _budget(parts: DelayBudget) -> dict[str, float]:
    return {
        name: float(getattr(parts, name)) for name in ("network", "jitter", "gap", "sampling", "computing")
    }
