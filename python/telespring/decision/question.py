"""One question about a dyad and its network, judged at any stiffness, delay and damping."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from telespring._core import check_usual
from telespring.decision.reserve import RESERVE
from telespring.decision.sampled_limits import damped, first_change, last_stable
from telespring.model import Dyad, Network, Operator, OperatorRange
from telespring.theory.verdicts import AxisTier, AxisVerdict, Verdicts, verdicts

__all__ = [
    "LONGEST_DELAY",
    "Question",
    "constant_delay",
    "constant_delay_tier",
    "is_instability_proven",
    "is_stable",
    "refuse_unusual",
    "stiffness_limit",
]

#: The longest one-way delay that can be judged, s.
_LONGEST_POSSIBLE = 100.0
#: Sampled controllers are judged up to this one-way delay, or the delay in question, where continuous
#: ones are stable at any, s.
LONGEST_DELAY = 1.0
#: Bisections of a limit that is known to a few periods.
_HALVINGS = 5


def is_stable(judged: Verdicts) -> bool:
    """Return whether the constant delay is stable for every operator, sampled controllers included."""
    return judged.tier("constant delay").satisfied and judged.sampled_stable is not False


def is_instability_proven(judged: Verdicts) -> bool:
    """Return whether some operator in question is unstable; if not, a search over ranges was cut off."""
    constant = judged.tier("constant delay")
    sampled = (axis.sampled for axis in judged.axes)
    return (not constant.satisfied and constant.proven) or any(
        each is not None and not each.stable for each in sampled
    )


def constant_delay(judged: Verdicts) -> tuple[float, float]:
    """Return the delay that is judged, s: the network's, or that behind the playout buffer."""
    return judged.tier("constant delay").buffer_delay or judged.network.delay


def constant_delay_tier(axis: AxisVerdict) -> AxisTier:
    """Return the verdict on one axis at one known constant delay."""
    return next(tier for tier in axis.tiers if tier.tier == "constant delay")


def stiffness_limit(judged: Verdicts) -> float:
    """Return the stiffness, N/m, below which every one is stable at the delay, sampling included."""
    sampled = [axis.sampled_stiffness_bound for axis in judged.axes]
    bounds = [judged.tier("constant delay").stiffness_bound, *sampled]
    return min((bound for bound in bounds if bound is not None), default=math.nan)


@dataclass(frozen=True)
class Question:
    """A dyad over a network, for one pair of operators or for ranges of them; the home of what is asked.

    Attributes
    ----------
    dyad
        The robots, and their operators unless these are ranges.
    network
        The network and the timing of the controllers.
    operator_ranges
        The ranges of both operators; None for the dyad's own.
    has_playout_buffer
        Whether both sides promise to hold every sample until it is as old as the latest one, which makes the
        delay constant.
    """

    dyad: Dyad
    network: Network
    operator_ranges: tuple[OperatorRange, OperatorRange] | None = None
    has_playout_buffer: bool = False

    @property
    def sampling(self) -> tuple[float, float]:
        """Sample period and computing time of the controllers, s."""
        return self.network.sample_period, self.network.computing_time

    @property
    def lag(self) -> float:
        """Mean age of a force that is held for a period, computing time included, s."""
        period, computing = self.sampling
        return 0.5 * period + computing

    @property
    def is_held(self) -> bool:
        """Whether anything holds a handle."""
        ranges = self.operator_ranges
        operators = self.dyad.operators if ranges is None else [each.high for each in ranges]
        values = ((each.mass, each.damping, each.stiffness) for each in operators)
        return any(bool(array.any()) for arrays in values for array in arrays)

    def with_operators(self, operators: tuple[Operator, Operator] | None) -> Question:
        """Return the question with these operators; None frees the handles."""
        dyad = Dyad(*self.dyad.robots, operators, self.dyad.coupling_damping)
        return replace(self, dyad=dyad, operator_ranges=None)

    def judge(self, stiffness: float) -> Verdicts:
        """Return the verdicts at this stiffness, N/m."""
        return verdicts(self.dyad, stiffness, self.network, operator_range=self.operator_ranges)

    def at_delay(self, delay: float | tuple[float, float]) -> Question:
        """Return the question at this constant delay, s."""
        period, computing = self.sampling
        return replace(self, network=Network(delay, sample_period=period, computing_time=computing))

    def held_by(self, judged: Verdicts) -> Dyad:
        """Return the dyad with the operators that allow the least stiffness at the delay, axis by axis."""
        if self.operator_ranges is None:
            return self.dyad
        pairs = [constant_delay_tier(axis).operators for axis in judged.axes]
        one, other = (
            Operator(
                [pair[side].mass for pair in pairs],
                [pair[side].damping for pair in pairs],
                [pair[side].stiffness for pair in pairs],
            )
            for side in range(2)
        )
        return Dyad(*self.dyad.robots, (one, other), self.dyad.coupling_damping)

    def keeps_stiffness_reserve(self, judged: Verdicts) -> bool:
        """Return whether the dyad is stable up to 5 % more stiffness."""
        k, limit = judged.stiffness, stiffness_limit(judged)
        if k < limit:
            return (1.0 + RESERVE) * k <= limit
        # Stable above a limit: in an island of stiffnesses, of which the ends are not known.
        constant = self.at_delay(constant_delay(judged))
        return all(is_stable(constant.judge(factor * k)) for factor in (1.0 - RESERVE, 1.0 + RESERVE))

    def keeps_delay_reserve(self, judged: Verdicts, delay_limit: float) -> bool:
        """Return whether the dyad is stable up to 5 % more delay."""
        forward, backward = constant_delay(judged)
        mean, period = 0.5 * (forward + backward), self.network.sample_period
        if mean < delay_limit:
            # Sampled controllers round each way up to a whole period, which only a verdict knows.
            if (1.0 + RESERVE) * mean + 2.0 * period < delay_limit or period == 0.0:
                return (1.0 + RESERVE) * mean < delay_limit
            more = ((1.0 + RESERVE) * forward, (1.0 + RESERVE) * backward)
            return is_stable(self.at_delay(more).judge(judged.stiffness))
        # In a later interval of stable delays a shorter delay may be unstable, too.
        return all(
            is_stable(self.at_delay((factor * forward, factor * backward)).judge(judged.stiffness))
            for factor in (1.0 - RESERVE, 1.0 + RESERVE)
        )

    def delay_limit(self, judged: Verdicts) -> float:
        """Return the one-way delay, s, below which every one is stable; infinite if none destabilises.

        Sampling takes damping and adds delay, both to first order in the period: the limit is that of the
        continuous dyad with this damping less, at every operator. Near it, or twice the longest delay in
        question, the sampled controllers themselves are judged.
        """
        continuous = min(axis.maximum_delay for axis in judged.axes)
        period, k = self.network.sample_period, judged.stiffness
        if period == 0.0 or continuous == 0.0:
            return continuous
        slower = damped(self.dyad, -k * self.lag)
        if slower is None:
            limit = 0.0
        else:
            question = replace(self, dyad=slower, network=Network(0.0))
            limit = min(axis.maximum_delay for axis in question.judge(k).axes) - self.lag
        limit = min(limit, continuous)

        def stable(delay: float) -> bool:
            return is_stable(self.at_delay(delay).judge(k))

        longest = min(max(LONGEST_DELAY, 2.0 * max(constant_delay(judged))), _LONGEST_POSSIBLE)
        if limit > longest:
            return limit if stable(longest) else first_change(stable, longest)
        low, high = limit - 4.0 * period, limit + period
        if not (low >= 0.0 and stable(low) and not stable(high)):
            return first_change(stable, max(high, period))
        return last_stable(stable, low, high, _HALVINGS)


def refuse_unusual(
    dyad: Dyad,
    network: Network,
    operator_ranges: tuple[OperatorRange, OperatorRange] | None = None,
    stiffness: float | None = None,
) -> None:
    """Refuse values that no laboratory has: their unit is probably wrong."""
    for number, robot in enumerate(dyad.robots, start=1):
        for i, (mass, damping) in enumerate(zip(robot.mass, robot.damping, strict=True)):
            check_usual("mass", f"robot{number}.mass[{i}]", float(mass))
            check_usual("damping", f"robot{number}.damping[{i}]", float(damping))
    ends = (
        dyad.operators
        if operator_ranges is None
        else [r for pair in operator_ranges for r in (pair.low, pair.high)]
    )
    for operator in ends:
        for quantity, values in (
            ("added mass", operator.mass),
            ("damping", operator.damping),
            ("ground stiffness", operator.stiffness),
        ):
            for value in values:
                check_usual(quantity, f"operator {quantity.split()[-1]}", float(value))
    if stiffness is not None:
        check_usual("stiffness", "stiffness", stiffness)
    for name, value in zip(("forward delay", "backward delay"), network.delay, strict=True):
        check_usual("delay", name, value)
    for name in ("jitter", "max_gap", "computing_time"):
        check_usual("time span", name, getattr(network, name))
    check_usual("controller period", "sample_period", network.sample_period)
