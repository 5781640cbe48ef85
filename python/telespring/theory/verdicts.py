"""The four verdicts on a dyad over a network, next to the paper's.

===  =======================  ============================================================
1    any network              anything with bounded gaps
2    bounded varying delay    any variation, loss and reordering, no sample older than a bound
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
    OperatorPoint,
    PaperVerdict,
    Remedies,
    SampledSpectrum,
    StiffnessAllowed,
    StiffnessMargin,
    Verdict,
    Verdicts,
)
from telespring._types import Delay, Tier

if TYPE_CHECKING:
    from telespring.model import Dyad, OperatorRange

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
    "Tier",
    "Verdict",
    "Verdicts",
    "verdicts",
]


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
    """Decide whether a dyad is stable at a stiffness over a network: in four tiers, and as the paper does.

    No partner sample in use is older than T_i = delay_i + jitter + max_gap + sample_period +
    computing_time. Tiers 3 and 4 hold for constant delays; with jitter or gaps they need a playout buffer.
    The verdict on a sampled controller is reported separately.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        The constant part of the one-way delay, s, or the pair (forward, backward).
    jitter : float
        The largest additional delay of a packet, s.
    max_gap : float
        The longest wait for a newer partner sample, s, losses included.
    sample_period : float
        Sample period of both controllers, s; 0 is a continuous controller.
    computing_time : float
        From reading the samples to applying the force, s, within the same period.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Operators that replace the dyad's own, one range for both or one each. Bounds, `satisfied`,
        `maximum_delay`, `sampled_stable` and the remedies then hold for every operator of the range, the
        worst of which need not be at a corner. Tiers 1 and 2 have a known worst operator; for tiers 3 and 4
        and the sampled dyad a search excludes roots on the imaginary axis for all operators at once, and ends
        within 1 % of the truth. `proven` is False where it was cut off, and for tier 1 of sampled controllers
        with a coupling damper, or with a computing time and weakly grounded handles: the verdict is then
        never `satisfied` unless a proof for this stiffness was found. `least_found` is the smallest bound of
        one pair of operators, `worst_operators`. `sampled_proven` is also False where the sampled bound may
        be more than 5 % low, at sample periods near the motion's own, and `maximum_delay_proven` where
        `maximum_delay` may be; `least_maximum_delay` is the smallest found for one pair of operators.

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
    Tier 2: the form of E. Nuño, L. Basañez, R. Ortega, Automatica, 2011, section 3. Ranges of operators: the
    zero-exclusion principle, B. R. Barmish, New Tools for Robustness of Linear Systems, 1994. The
    paper: M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
    Delayed Haptic Dyadic Interactions Mediated by Robots", Eqs. 5 to 11.

    Examples
    --------
    >>> import telespring as ts
    >>> verdicts = ts.verdicts(ts.hman(), 71.2, 0.1, sample_period=0.001)
    >>> [verdict.tier for verdict in verdicts.tiers if verdict.satisfied]
    ['bounded varying delay', 'constant delay']
    >>> verdicts.stiffness_allowed.tier, verdicts.stiffness_allowed.stiffness > 71.2
    ('constant delay', True)
    >>> ts.verdicts(ts.hman(), 30.0, 0.1).to_dict()["paper"]["maximum_delay"] is None  # any delay
    True

    Whatever the grip between a free handle and 300 N/m:

    >>> grip = ts.OperatorRange(ts.Operator(), ts.Operator(stiffness=300.0))
    >>> held = ts.verdicts(ts.hman(), 30.0, 0.1, operator_range=grip)
    >>> constant = held.tier("constant delay")
    >>> constant.satisfied, constant.proven
    (True, True)
    """
    network = core.Network(delay, jitter, max_gap, sample_period, computing_time)
    return core.verdicts(dyad, stiffness, network, operator_range)
