"""Is this dyad stable, by what margin, and what may it use instead: the answer as plain data.

The terminal table, `--json` and the report all read the `Decision` made here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

import telespring as ts
from telespring import paper
from telespring.axes import Axis, axes_of, finite_or_none

__all__ = ["TIERS", "AxisDecision", "Decision", "Remedies", "TierDescription", "Verdict", "decide"]


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
            "axis": self.axis,
            "satisfied": self.satisfied,
            "assumption_met": self.assumption_met,
            "assumption": self.assumption,
            "available": self.available,
        }


@dataclass(frozen=True)
class AxisDecision:
    """The margins of one axis.

    Attributes
    ----------
    axis
        The axis' name.
    critical_stiffness, critical_stiffness_paper
        Exact and by Eq. 5, N/m.
    maximum_delay
        End of the first stable interval, one way, s; infinite where no delay destabilises.
    maximum_delay_paper
        By Eqs. 5 to 9 as printed, s; NaN where the paper has no formula (operators, damper).
    maximum_stiffness
        Below it every stiffness is stable at this delay, N/m; infinite at zero delay.
    stable_delays
        All stable intervals up to the horizon, s.
    spectral_abscissa
        Largest real part of the characteristic roots without the rigid-body root, 1/s.
    crossings
        Where roots meet the imaginary axis: delay, frequency, direction.
    stable
        True where the delay lies in a stable interval.
    """

    axis: str
    critical_stiffness: float
    critical_stiffness_paper: float
    maximum_delay: float
    maximum_delay_paper: float
    maximum_stiffness: float
    stable_delays: tuple[tuple[float, float], ...]
    spectral_abscissa: float
    crossings: tuple[dict[str, Any], ...]
    stable: bool

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
            "crossings": list(self.crossings),
            "stable": self.stable,
        }


@dataclass(frozen=True)
class Remedies:
    """What to change, one thing at a time, so that the constant delay asked for is stable.

    Attributes
    ----------
    stiffness
        Every smaller stiffness is stable at this delay on all axes, N/m; infinite at zero delay.
    delay
        Every shorter one-way delay is stable at this stiffness on all axes, s; may be infinite.
    added_damping
        Damping to add to both robots, N·s/m; 0 where nothing is missing.
    """

    stiffness: float
    delay: float
    added_damping: float


@dataclass(frozen=True)
class Decision:
    """The whole answer for one dyad, stiffness and network.

    Attributes
    ----------
    stiffness
        The stiffness asked about, N/m.
    delay
        Forward and backward one-way delay, s.
    horizon
        Stable intervals are listed up to this one-way delay, s.
    axes, verdicts, remedies
        The parts of the answer.
    delay_budget
        What the age of the oldest sample in use is made of, forward and backward: name to s.
    stiffness_allowed, allowing_verdict
        The largest stiffness, N/m, that any verdict gives whose assumption this network meets as it is,
        and that verdict's name; None where none does.
    paper_agrees
        True where the paper's verdict on this constant delay is the exact one.
    sampled_stable
        Whether the dyad with sampled controllers is stable too; None without a sample period.
    over_operator_ranges
        True where operators are ranges: the verdicts are then the worst over them, while the margins
        of the axes are those of the middle.
    """

    stiffness: float
    delay: tuple[float, float]
    horizon: float
    axes: tuple[AxisDecision, ...]
    verdicts: tuple[Verdict, ...]
    delay_budget: tuple[dict[str, float], dict[str, float]]
    remedies: Remedies
    stiffness_allowed: float | None
    allowing_verdict: str | None
    paper_agrees: bool
    sampled_stable: bool | None
    over_operator_ranges: bool

    @property
    def mean_delay(self) -> float:
        """Half of the round trip, s: all that stability depends on."""
        return 0.5 * sum(self.delay)

    @property
    def stable(self) -> bool:
        """True where every axis is stable at this constant delay."""
        return all(axis.stable for axis in self.axes)

    @property
    def worst_axis(self) -> AxisDecision:
        """The axis whose slowest root is farthest to the right."""
        return max(self.axes, key=lambda axis: axis.spectral_abscissa)

    def verdict(self, name: str) -> Verdict:
        """Find the verdict of that name, a key of `TIERS`."""
        return next(verdict for verdict in self.verdicts if verdict.name == name)

    def to_json(self) -> dict[str, Any]:
        """Give the answer in SI units; None stands for infinity or for what does not exist."""
        remedies = self.remedies
        return {
            "stiffness": self.stiffness,
            "delay": {"forward": self.delay[0], "backward": self.delay[1], "mean": self.mean_delay},
            "stable": self.stable,
            "worst_axis": self.worst_axis.axis,
            "horizon": self.horizon,
            "axes": [axis.to_json() for axis in self.axes],
            "verdicts": {verdict.description.key: verdict.to_json() for verdict in self.verdicts},
            "stiffness_allowed": (
                None if self.stiffness_allowed is None else finite_or_none(self.stiffness_allowed)
            ),
            "stiffness_allowed_unbounded": self.stiffness_allowed == math.inf,
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
        }


def decide(
    dyad: ts.Dyad,
    stiffness: float,
    delay: float | tuple[float, float],
    *,
    jitter: float = 0.0,
    max_gap: float = 0.0,
    sample_period: float = 0.0,
    computing_time: float = 0.0,
    operator_ranges: tuple[ts.OperatorRange, ts.OperatorRange] | None = None,
    horizon: float | None = None,
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
    judged = ts.verdicts(
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
    mean = 0.5 * sum(both)
    horizon = horizon if horizon is not None else max(1.0, 2.0 * mean)
    axes = axes_of(dyad)
    return Decision(
        stiffness=stiffness,
        delay=both,
        horizon=horizon,
        axes=tuple(_decide_axis(dyad, axis, stiffness, delay, mean, horizon) for axis in axes),
        verdicts=tuple(_verdicts(judged, [axis.name for axis in axes])),
        delay_budget=(_budget(judged.delay_budget[0]), _budget(judged.delay_budget[1])),
        stiffness_allowed=None if judged.stiffness_allowed is None else judged.stiffness_allowed.stiffness,
        allowing_verdict=None if judged.stiffness_allowed is None else judged.stiffness_allowed.tier,
        paper_agrees=judged.paper.agrees,
        sampled_stable=judged.sampled_stable,
        over_operator_ranges=operator_ranges is not None,
        remedies=Remedies(
            stiffness=min(axis.maximum_stiffness(mean) for axis in axes),
            delay=min(float(axis.maximum_delay(stiffness)) for axis in axes),
            added_damping=max(axis.minimum_damping(stiffness, mean) for axis in axes),
        ),
    )


def _decide_axis(
    dyad: ts.Dyad,
    axis: Axis,
    stiffness: float,
    delay: float | tuple[float, float],
    mean: float,
    horizon: float,
) -> AxisDecision:
    return AxisDecision(
        axis=axis.name,
        critical_stiffness=axis.critical_stiffness(),
        critical_stiffness_paper=axis.critical_stiffness("paper"),
        maximum_delay=float(axis.maximum_delay(stiffness)),
        maximum_delay_paper=(
            paper.maximum_delay(*axis.parameters, stiffness).delay if axis.is_plain else math.nan
        ),
        maximum_stiffness=axis.maximum_stiffness(mean),
        stable_delays=tuple(axis.stable_delays(stiffness, horizon)),
        spectral_abscissa=float(ts.spectral_abscissa(dyad, stiffness, delay, axis=axis.index)),
        crossings=tuple(axis.crossings(stiffness)),
        stable=axis.is_stable(stiffness, mean),
    )


def _verdicts(judged: ts.Verdicts, axis_names: list[str]) -> list[Verdict]:
    """Put the four tiers, the strongest promise last, and the paper's verdict into one form."""
    tiers = [
        Verdict(
            name=tier.tier,
            stiffness_allowed=math.nan if tier.stiffness_bound is None else float(tier.stiffness_bound),
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
        axis=axis_names[judged.paper.critical_axis],
        satisfied=bool(judged.paper.stable),
        assumption_met=constant.assumption_met,
        assumption=constant.assumption,
    )
    return sorted([*tiers, paper_verdict], key=lambda verdict: order.index(verdict.name))


def _budget(parts: ts.DelayBudget) -> dict[str, float]:
    return {
        name: float(getattr(parts, name)) for name in ("network", "jitter", "gap", "sampling", "computing")
    }
