"""The four verdicts on a dyad, side by side with the paper's.

===  =======================  ============================================================
1    any network              anything with bounded gaps
2    bounded varying delay    any variation, loss and reordering, no sample older than a bound
3    any constant delay       one constant delay, however long
4    constant delay           one known constant delay
===  =======================  ============================================================

The tiers are not nested: the stiffness allowed is the largest that any of them gives whose assumption
the network keeps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from telespring import _core
from telespring._types import Delay

if TYPE_CHECKING:
    from telespring.model import Dyad, Network, OperatorRange

__all__ = [
    "AxisTier",
    "AxisVerdict",
    "DelayBudget",
    "OperatorPoint",
    "PaperVerdict",
    "Remedies",
    "SampledSpectrum",
    "StiffnessAllowed",
    "StiffnessMargin",
    "Verdict",
    "Verdicts",
    "verdicts",
]

Tier: TypeAlias = Literal["any network", "bounded varying delay", "any constant delay", "constant delay"]
Unavailable: TypeAlias = Literal[
    "coupling damping with grounded operator",
    "coupling damping with computing time",
    "coupling damping",
    "no rule",
]


@dataclass(frozen=True)
class OperatorPoint:
    """One operator on one axis.

    Attributes
    ----------
    mass : float
        Mass, kg.
    damping : float
        Damping, N·s/m.
    stiffness : float
        Stiffness to the ground, N/m.
    """

    mass: float
    damping: float
    stiffness: float


@dataclass(frozen=True)
class StiffnessMargin:
    """How far a stiffness is from a bound.

    Attributes
    ----------
    ratio : float
        Bound over stiffness: above 1 is inside.
    difference : float
        Bound minus stiffness, N/m.
    """

    ratio: float
    difference: float


@dataclass(frozen=True)
class Verdict:
    """The verdict of one tier on the whole dyad.

    Attributes
    ----------
    tier : str
        "any network", "bounded varying delay", "any constant delay" or "constant delay".
    stiffness_bound : float or None
        The largest stiffness, N/m, every smaller one included; inf where nothing limits it, None where
        the tier has no rule for this dyad.
    attained : bool
        Whether that stiffness is itself allowed.
    satisfied : bool
        Whether the stiffness in question keeps the rule on every axis, for every operator examined. A
        constant delay may be stable above the bound, in a later stable interval.
    margin : StiffnessMargin or None
        How far the stiffness is from the bound.
    worst_axis : int or None
        The axis with the least bound, counted from 0.
    worst_operators : pair of OperatorPoint or None
        The operators with the least bound on that axis.
    assumption : {"met", "met behind playout buffer", "not met"}
        Whether the network keeps what the tier assumes: as it is, or only behind a buffer that holds
        every packet until the same delay is over.
    buffer_delay : (float, float) or None
        That delay, s, forward and backward: delay plus jitter plus longest gap.
    unavailable : str or None
        Why the tier has no rule, where it has none.
    """

    tier: Tier
    stiffness_bound: float | None
    attained: bool
    satisfied: bool
    margin: StiffnessMargin | None
    worst_axis: int | None
    worst_operators: tuple[OperatorPoint, OperatorPoint] | None
    assumption: Literal["met", "met behind playout buffer", "not met"]
    buffer_delay: tuple[float, float] | None
    unavailable: Unavailable | None

    @property
    def assumption_met(self) -> bool:
        """Whether the bare network keeps what the tier assumes."""
        return self.assumption == "met"


@dataclass(frozen=True)
class StiffnessAllowed:
    """A stiffness and the tier that allows it.

    Attributes
    ----------
    stiffness : float
        Every smaller stiffness, N/m, is allowed; inf where nothing limits it.
    attained : bool
        Whether this very stiffness is allowed too.
    tier : str
        The tier that gives it.
    """

    stiffness: float
    attained: bool
    tier: Tier


@dataclass(frozen=True)
class PaperVerdict:
    """What Du, Kulkarni, Kager and Campolo say.

    Attributes
    ----------
    critical_stiffness : float
        Their critical stiffness over all axes, N/m (Eq. 11 with Eq. 5).
    critical_axis : int
        The axis with that stiffness, counted from 0.
    maximum_delay : float
        Their maximum delay over all axes, s (Eq. 11 with Eqs. 6 to 9); inf where the stiffness is at
        most the critical one.
    delay_axis : int
        The axis with that delay.
    stable : bool
        Whether they call the dyad stable.
    agrees : bool
        Whether the exact verdict on this constant delay is the same.
    """

    critical_stiffness: float
    critical_axis: int
    maximum_delay: float
    delay_axis: int
    stable: bool
    agrees: bool


@dataclass(frozen=True)
class DelayBudget:
    """Where the age of a partner sample comes from, one direction, s.

    Attributes
    ----------
    network : float
        The constant part of the one-way delay.
    jitter : float
        The most that a packet may be later than that.
    gap : float
        The longest wait for a newer sample.
    sampling : float
        The hold of the force over one sample period.
    computing : float
        From reading the samples to applying the force.
    total : float
        Their sum: no partner sample in use is older.
    """

    network: float
    jitter: float
    gap: float
    sampling: float
    computing: float
    total: float


@dataclass(frozen=True)
class SampledSpectrum:
    """The slowest multiplier of one axis under sampled controllers.

    Attributes
    ----------
    radius : float
        The largest abs(z), the rigid-body multiplier left out.
    abscissa_equivalent : float
        ln(radius) over the sample period, 1/s: to compare with the spectral abscissa.
    frequency : float
        abs(arg z) over the sample period, rad/s.
    stable : bool
        Whether the radius is below 1.
    certificate : {"complete", "upper bound", "incomplete"}
        Whether a count proves that none lies outside, the radius only bounds them all, or the count
        ended before it could decide.
    """

    radius: float
    abscissa_equivalent: float
    frequency: float
    stable: bool
    certificate: Literal["complete", "upper bound", "incomplete"]


@dataclass(frozen=True)
class AxisTier:
    """One tier on one axis.

    Attributes
    ----------
    tier : str
        Which tier.
    stiffness_bound : float or None
        The largest stiffness, N/m; None where the tier has no rule.
    attained : bool
        Whether that stiffness is itself allowed.
    satisfied : bool
        Whether the stiffness in question keeps the rule, for every operator examined.
    operators : pair of OperatorPoint
        The operators with the least bound.
    """

    tier: Tier
    stiffness_bound: float | None
    attained: bool
    satisfied: bool
    operators: tuple[OperatorPoint, OperatorPoint]


@dataclass(frozen=True)
class AxisVerdict:
    """One axis in detail.

    Attributes
    ----------
    name : str
        Its name.
    grounded : bool
        Whether an operator, or one in the range, holds a handle to the ground.
    tiers : tuple of AxisTier
        The four tiers, 1 to 4.
    paper_critical_stiffness : float
        Eq. 5 of the paper, N/m.
    paper_maximum_delay : float
        Eq. 6 of the paper, s; 0 where its Eq. 9 breaks down.
    maximum_delay : float
        End of the first stable interval, s, the shortest over the operators examined.
    sampled : SampledSpectrum or None
        The slowest multiplier under sampled controllers, the worst over the operators; None without a
        sample period.
    sampled_stiffness_bound : float or None
        The largest stiffness, N/m, up to the bound of tier 4 that the sampled dyad keeps.
    """

    name: str
    grounded: bool
    tiers: tuple[AxisTier, ...]
    paper_critical_stiffness: float
    paper_maximum_delay: float
    maximum_delay: float
    sampled: SampledSpectrum | None
    sampled_stiffness_bound: float | None


@dataclass(frozen=True)
class Remedies:
    """What to change so that the constant delay is stable, one thing at a time.

    Attributes
    ----------
    stiffness : float or None
        Lower the stiffness below this, N/m.
    delay : float or None
        Bring the mean one-way delay below this, s.
    damping : float or None
        Add more than this damping to each robot, N·s/m.
    """

    stiffness: float | None
    delay: float | None
    damping: float | None


@dataclass(frozen=True)
class Verdicts:
    """The four verdicts, the paper's beside them, and what follows.

    Attributes
    ----------
    stiffness : float
        The stiffness in question, N/m.
    network : Network
        The network in question.
    tiers : tuple of Verdict
        Tiers 1 to 4.
    any_passive_operator : float or None
        The bound of tier 2 from the robots' own damping, N/m: it holds for every passive operator. None
        with a coupling damper.
    sampled_stable : bool or None
        Whether the sampled dyad is stable at this constant delay on every axis; None without a sample
        period.
    paper : PaperVerdict
        What the paper says.
    stiffness_allowed : StiffnessAllowed or None
        The largest stiffness over the tiers whose assumption the bare network keeps. Sampling counts:
        tiers 3 and 4 give no more than the sampled dyad bears at this delay.
    stiffness_allowed_behind_buffer : StiffnessAllowed or None
        The same with the playout buffer in place that makes the delay constant.
    delay_budget : (DelayBudget, DelayBudget)
        Where the age of a partner sample comes from, forward and backward.
    axes : tuple of AxisVerdict
        Every axis.
    operators_examined : int
        How many pairs of operators were examined per axis: one without a range.
    remedies : Remedies
        What to change, where tier 4 is not satisfied.
    """

    stiffness: float
    network: Network
    tiers: tuple[Verdict, ...]
    any_passive_operator: float | None
    sampled_stable: bool | None
    paper: PaperVerdict
    stiffness_allowed: StiffnessAllowed | None
    stiffness_allowed_behind_buffer: StiffnessAllowed | None
    delay_budget: tuple[DelayBudget, DelayBudget]
    axes: tuple[AxisVerdict, ...]
    operators_examined: int
    remedies: Remedies

    def tier(self, name: Tier) -> Verdict:
        """Find the verdict of one tier by its name."""
        return next(verdict for verdict in self.tiers if verdict.tier == name)

    def to_dict(self) -> dict[str, Any]:
        """Give everything as nested dicts and lists that `json.dumps(..., allow_nan=False)` takes.

        Keys are the attributes' names, numbers in SI units. JSON has no infinity: where a number is
        infinite its place holds None. A `stiffness_bound` of None is infinite where `unavailable` is
        None and absent where it gives a reason; `worst_axis` is None only where it is absent.

        Returns
        -------
        dict
            The verdicts, JSON-ready.

        Examples
        --------
        >>> import telespring as ts
        >>> ts.verdicts(ts.hman(), 30.0, 0.1).to_dict()["paper"]["maximum_delay"] is None  # any delay
        True
        """
        ready: dict[str, Any] = _json_ready(self)
        return ready


def _json_ready(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, tuple):
        return [_json_ready(item) for item in value]
    if is_dataclass(value):
        return {field.name: _json_ready(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, _core.Network):
        names = ("delay", "jitter", "max_gap", "sample_period", "computing_time")
        return {name: _json_ready(getattr(value, name)) for name in names}
    return value


def _pair(found: tuple[Mapping[str, float], Mapping[str, float]]) -> tuple[OperatorPoint, OperatorPoint]:
    first, second = found
    return OperatorPoint(**first), OperatorPoint(**second)


def _verdict(found: dict[str, Any]) -> Verdict:
    margin, operators = found["margin"], found["worst_operators"]
    found["margin"] = None if margin is None else StiffnessMargin(**margin)
    found["worst_operators"] = None if operators is None else _pair(operators)
    return Verdict(**found)


def _allowed(found: dict[str, Any] | None) -> StiffnessAllowed | None:
    return None if found is None else StiffnessAllowed(**found)


def _axis(found: dict[str, Any]) -> AxisVerdict:
    found["tiers"] = tuple(
        AxisTier(**{**tier, "operators": _pair(tier["operators"])}) for tier in found["tiers"]
    )
    found["sampled"] = None if found["sampled"] is None else SampledSpectrum(**found["sampled"])
    return AxisVerdict(**found)


def verdicts(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    jitter: float = 0.0,
    max_gap: float = 0.0,
    sample_period: float = 0.0,
    computing_time: float = 0.0,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None = None,
) -> Verdicts:
    """Judge a dyad at a stiffness over a network, in four tiers and as the paper does.

    No partner sample in use is older than T_i = delay_i + jitter + max_gap + sample_period +
    computing_time. Tiers 3 and 4 hold for constant delays: with jitter or gaps, behind a playout
    buffer. A sampled controller's own verdict stands beside them.

    Parameters
    ----------
    dyad : Dyad
        The robots and what holds them.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        The constant part of the one-way delay, s, or the pair (forward, backward).
    jitter : float
        The most that a packet may be later than that, s.
    max_gap : float
        The longest wait for a newer partner sample, s, losses included.
    sample_period : float
        The period of both controllers, s; 0 is a continuous controller.
    computing_time : float
        From reading the samples to applying the force, s, within the same period.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Take the place of the dyad's own operators, one for both or one each: every verdict is then the
        worst over the range, tiers 1 and 2 exactly, tiers 3 and 4 over corners and a refined grid.

    Returns
    -------
    Verdicts
        Tiers with bounds, margins and worst axis, the paper's verdict, the stiffness allowed, the delay
        budget and the remedies.

    Raises
    ------
    InvalidInput
        Where a value is out of its range or a range does not have the dyad's axes.

    References
    ----------
    Tier 2: the form of E. Nuño, L. Basañez, R. Ortega, Automatica, 2011, section 3. The
    paper: M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
    Delayed Haptic Dyadic Interactions Mediated by Robots", Eqs. 5 to 11.

    Examples
    --------
    >>> import telespring as ts
    >>> found = ts.verdicts(ts.hman(), 71.2, 0.1, sample_period=0.001)
    >>> [verdict.tier for verdict in found.tiers if verdict.satisfied]
    ['bounded varying delay', 'constant delay']
    >>> found.stiffness_allowed.tier, bool(found.stiffness_allowed.stiffness > 71.2)
    ('constant delay', True)
    """
    network = _core.Network(delay, jitter, max_gap, sample_period, computing_time)
    found = _core.verdicts(dyad, stiffness, network, operator_range)
    forward, backward = found["delay_budget"]
    return Verdicts(
        stiffness=found["stiffness"],
        network=found["network"],
        tiers=tuple(_verdict(tier) for tier in found["tiers"]),
        any_passive_operator=found["any_passive_operator"],
        sampled_stable=found["sampled_stable"],
        paper=PaperVerdict(**found["paper"]),
        stiffness_allowed=_allowed(found["stiffness_allowed"]),
        stiffness_allowed_behind_buffer=_allowed(found["stiffness_allowed_behind_buffer"]),
        delay_budget=(DelayBudget(**forward), DelayBudget(**backward)),
        axes=tuple(_axis(axis) for axis in found["axes"]),
        operators_examined=found["operators_examined"],
        remedies=Remedies(**found["remedies"]),
    )
