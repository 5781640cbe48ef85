"""The five verdicts on a dyad over a network, next to the paper's.

===  =======================  ============================================================
1    any network              anything with bounded gaps
2    bounded varying delay    any variation, loss and reordering, no sample older than a bound
5    age in a range           any variation and loss, all ages in a range, played in order
3    any constant delay       one constant delay, however long
4    constant delay           one known constant delay
===  =======================  ============================================================

The tiers are not nested: the stiffness allowed is the largest that any tier allows whose assumption the
network fulfils.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import telespring._core as core
from telespring._core import (
    AxisTier,
    AxisVerdict,
    DelayBudget,
    DelayLimit,
    OperatorPoint,
    PaperVerdict,
    Remedies,
    SampledSpectrum,
    StiffnessAllowed,
    StiffnessMargin,
    Verdict,
    Verdicts,
)
from telespring._errors import InvalidInput
from telespring._types import Delay, Tier

if TYPE_CHECKING:
    from telespring.model import Dyad, Network, OperatorRange

__all__ = [
    "AxisTier",
    "AxisVerdict",
    "DelayBudget",
    "DelayLimit",
    "OperatorPoint",
    "PaperVerdict",
    "Remedies",
    "SampledSpectrum",
    "StiffnessAllowed",
    "StiffnessMargin",
    "Tier",
    "Verdict",
    "Verdicts",
    "delay_limit",
    "is_stable_over_delays",
    "is_stable_over_stiffnesses",
    "verdicts",
]


def verdicts(
    dyad: Dyad,
    stiffness: float,
    delay: Delay | Network,
    jitter: Delay = 0.0,
    max_gap: float = 0.0,
    sample_period: float = 0.0,
    computing_time: float = 0.0,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None = None,
    attack_seed: int | None = None,
) -> Verdicts:
    """Decide whether a dyad is stable at a stiffness over a network: in five tiers, and as the paper does.

    No partner sample in use is older than T_i = delay_i + jitter + max_gap + sample_period +
    computing_time. Tier 5, "age in a range", also uses that none is younger than delay_i + computing_time,
    and needs a play-out that drops samples that were overtaken, as telespring's does. Tiers 3 and 4 hold for
    constant delays; with jitter or gaps they need a playout buffer.
    The verdict on a sampled controller is reported separately, and only with a sample period: controllers are
    continuous unless one is given. (`telespring.decide` samples every 1 ms unless it is told otherwise.)

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float, (float, float) or Network
        The constant part of the one-way delay, s, or the pair (forward, backward); or a network, which has
        all that follows up to the computing time.
    jitter : float or (float, float)
        The largest additional delay of a packet, s, or the pair (forward, backward).
    max_gap : float
        The longest wait for a newer partner sample, s, losses included.
    sample_period : float
        Sample period of both controllers, s; 0, the default, is a continuous controller.
    computing_time : float
        From reading the samples to applying the force, s, within the same period.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Operators that replace the dyad's own, one range for both or one each. Bounds, `satisfied`,
        `maximum_delay`, `sampled_stable` and the remedies then hold for every operator of the range, the
        worst of which need not be at a corner. Tiers 1 and 2 have a known worst operator; for tiers 3 and 4
        and the sampled dyad a search excludes roots on the imaginary axis for all operators at once, and ends
        within 1 % of the truth. `proven` is False where it was cut off, or where the bound may be more than
        5 % below the truth; a bound that is given holds all the same. Tier 1 of sampled controllers has no
        bound over free handles with a coupling damper, nor with a computing time over grounded handles some
        of which may be free: `unavailable` is then "not proven over the range". `least_found` is the smallest
        bound of one pair of operators, `worst_operators`. `sampled_proven` is also False where the sampled
        bound may be more than 5 % low, at sample periods near the motion's own, and `maximum_delay_proven`
        where `maximum_delay` may be; `least_maximum_delay` is the smallest found for one pair of operators.
        Tier 5 is proven for all operators at once; over wide ranges it may be low, then `proven` is False.
    attack_seed : int, optional
        Search, from seeded starts, a network that keeps the ages in their range and the order of the samples
        and still makes the motion grow. The `attack` of tier 5 is then the lowest stiffness, N/m, at which
        one was seen to: the truth lies between the bound and it. Takes up to some seconds.

    Returns
    -------
    Verdicts
        Tiers with bounds, margins and worst axis, the paper's verdict, the stiffness allowed, the delay
        budget and the remedies.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a range does not have the dyad's axes.

    References
    ----------
    Tier 2: the form of E. Nuño, L. Basañez, R. Ortega, Automatica, 2011, section 3. Tier 5: the family of
    C.-Y. Kao, B. Lincoln, "Simple stability criteria for systems with time-varying delays", Automatica 40,
    2004; docs/age-range.md has the proof. Ranges of operators: the
    zero-exclusion principle, B. R. Barmish, New Tools for Robustness of Linear Systems, 1994. The
    paper: M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
    Delayed Haptic Dyadic Interactions Mediated by Robots", Eqs. 5 to 11.

    Examples
    --------
    >>> import telespring as ts
    >>> verdicts = ts.verdicts(ts.hman(), 71.2, 0.1, sample_period=0.001)
    >>> [verdict.tier for verdict in verdicts.tiers if verdict.satisfied]
    ['bounded varying delay', 'age in a range', 'constant delay']
    >>> verdicts.stiffness_allowed.tier, verdicts.stiffness_allowed.stiffness > 71.2
    ('constant delay', True)
    >>> ts.verdicts(ts.hman(), 30.0, 0.1).to_dict()["paper"]["maximum_delay"] is None  # any delay
    True
    >>> ts.verdicts(ts.hman(), 71.2, ts.Network(0.1, sample_period=0.001)) == verdicts
    True

    With 10 ms of jitter, and what an attack reaches:

    >>> varying = ts.verdicts(ts.hman(), 71.2, 0.09, jitter=0.01, attack_seed=1).tier("age in a range")
    >>> varying.satisfied, varying.stiffness_bound < varying.attack < 1.05 * varying.stiffness_bound
    (True, True)

    Whatever the grip between a free handle and 300 N/m:

    >>> grip = ts.OperatorRange(ts.Operator(), ts.Operator(stiffness=300.0))
    >>> held = ts.verdicts(ts.hman(), 30.0, 0.1, operator_range=grip)
    >>> constant = held.tier("constant delay")
    >>> constant.satisfied, constant.proven
    (True, True)
    """
    if isinstance(delay, core.Network):
        _refuse_beside_a_network(
            jitter=jitter, max_gap=max_gap, sample_period=sample_period, computing_time=computing_time
        )
        network = delay
    else:
        network = core.Network(delay, jitter, max_gap, sample_period, computing_time)
    return core.verdicts(dyad, stiffness, network, operator_range, attack_seed)


def delay_limit(
    dyad: Dyad,
    stiffness: float,
    network: Network,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None = None,
) -> DelayLimit:
    """Find the first delay at which a dyad becomes unstable, with the controllers that it has.

    The delays of both ways grow in the proportion that `network` gives them, behind its playout buffer
    where it has jitter or gaps (equal where it has no delay); the limit is the mean of both. A sampled
    controller uses a sample of its partner from its next tick on: each way counts in whole periods, rounded
    up, and the limit is the last whole number of them before a multiplier of the one-period map leaves the
    unit circle. The continuous dyad must be stable up to it, too. No period is tried: all crossings of the
    circle are roots of one polynomial. Beyond the limit a dyad may be stable again: `DyadAxis.stable_delays`
    and `DyadAxis.sampled_stable_delays` list all intervals.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    network : Network
        The proportion of both delays, s, and the timing of the controllers.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Operators that replace the dyad's own. The limit then holds for every operator of the range.
        `proven` is
        False where the search was cut off or the limit may be more than 5 % and a period below `least_found`.

    Returns
    -------
    DelayLimit
        `delay` in s, and whether it is `attained` (itself stable) and `proven`.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a range does not have the dyad's axes.

    Examples
    --------
    >>> import telespring as ts
    >>> round(ts.delay_limit(ts.hman(), 71.2, ts.Network(0.1)).delay, 4)
    0.1673
    >>> limit = ts.delay_limit(ts.hman(), 71.2, ts.Network((0.05, 0.15), sample_period=0.001))
    >>> round(limit.delay, 4), limit.attained
    (0.1647, True)
    """
    return core.delay_limit(dyad, stiffness, network, operator_range)


def is_stable_over_delays(
    dyad: Dyad,
    stiffness: float,
    network: Network,
    factors: tuple[float, float],
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None = None,
) -> bool:
    """Return whether a dyad is proven to be stable at every delay between two multiples of the network's.

    With the network's controllers, for every operator, and with nothing unstable in between: also beyond the
    first limit, where single verdicts at both ends would not show it.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    network : Network
        Both delays, s, and the timing of the controllers.
    factors : (float, float)
        The smallest and the largest multiple of both delays.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Operators that replace the dyad's own.

    Returns
    -------
    bool
        True only if it is proven.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a range does not have the dyad's axes.

    Examples
    --------
    >>> import telespring as ts
    >>> ts.is_stable_over_delays(ts.hman(), 71.2, ts.Network(0.1, sample_period=0.001), (0.95, 1.05))
    True
    """
    return core.is_stable_over_delays(dyad, stiffness, network, factors, operator_range)


def is_stable_over_stiffnesses(
    dyad: Dyad,
    stiffnesses: tuple[float, float],
    network: Network,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None = None,
) -> bool:
    """Return whether a dyad is proven to be stable at every stiffness of a range, N/m, over a network.

    With the network's controllers, for every operator, and with nothing unstable in between.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffnesses : (float, float)
        The smallest and the largest stiffness, N/m.
    network : Network
        Both delays, s, and the timing of the controllers.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Operators that replace the dyad's own.

    Returns
    -------
    bool
        True only if it is proven.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a range does not have the dyad's axes.

    Examples
    --------
    >>> import telespring as ts
    >>> ts.is_stable_over_stiffnesses(ts.hman(), (60.0, 80.0), ts.Network(0.1, sample_period=0.001))
    True
    """
    return core.is_stable_over_stiffnesses(dyad, stiffnesses, network, operator_range)


def _refuse_beside_a_network(**given: Delay) -> None:
    for name, value in given.items():
        if value != 0.0:
            raise InvalidInput(
                name, f"{value}", "the network already has it", f"Pass Network(delay, {name}={value}) alone."
            )
