"""Whether a dyad is stable over a network, by what margin, and what to change.

The screen, `--json` and the report all read the `Decision` made here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from telespring.decision.uncertainty import MarginUncertainty, RobotUncertainty, margin_uncertainty
from telespring.model import Dyad, DyadAxis, OperatorRange
from telespring.theory.criteria import Crossing, decay_stiffness
from telespring.theory.verdicts import AxisVerdict, Tier, Verdict, Verdicts, verdicts

if TYPE_CHECKING:
    from telespring.decision.arm_stability import ArmStability
    from telespring.study.robot_file import RobotRecord

__all__ = ["AxisDecision", "Decision", "decide"]


@dataclass(frozen=True)
class AxisDecision:
    """The margins of one axis.

    Over ranges of operators the verdict, and with it the stiffnesses, the maximum delay and `stable`, is the
    worst; what belongs to one operator (intervals, crossings, spectral abscissa, the paper's values) is that
    of the middle of the ranges.

    Attributes
    ----------
    verdict
        The verdict of every tier on this axis.
    critical_stiffness_paper
        By Eq. 5, N/m.
    maximum_delay_paper
        By Eqs. 5 to 9 as printed, s; NaN if the paper has no formula (operators, coupling damper).
    stable_delays
        All stable intervals of the one-way delay up to the horizon, s.
    stable_around
        The stable interval that contains the delay, s, cut off at the horizon or at twice the delay if that
        is more; None if none does.
    spectral_abscissa
        Largest real part of the characteristic roots without the rigid-body root, 1/s.
    crossings
        Where roots cross the imaginary axis.
    """

    verdict: AxisVerdict
    critical_stiffness_paper: float
    maximum_delay_paper: float
    stable_delays: tuple[tuple[float, float], ...]
    stable_around: tuple[float, float] | None
    spectral_abscissa: float
    crossings: tuple[Crossing, ...]

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
        continuous = next(tier.satisfied for tier in self.verdict.tiers if tier.tier == "constant delay")
        return continuous and self.verdict.sampled_stable is not False

    def _bound(self, name: Tier) -> float:
        bound = next(tier.stiffness_bound for tier in self.verdict.tiers if tier.tier == name)
        return math.nan if bound is None else bound


@dataclass(frozen=True)
class Decision:
    """The answer for one dyad, stiffness and network.

    Attributes
    ----------
    verdicts
        The verdicts of all tiers and of the paper, with the stiffness and network in question.
    axes
        The margins axis by axis.
    horizon
        Stable intervals are listed up to this one-way delay, s.
    added_damping
        More than this damping, N·s/m, must be added to both robots for a stable constant delay; 0 if it is
        stable now, infinite if no damping is known to suffice.
    over_operator_ranges
        Whether operators are ranges: `AxisDecision` says which values are then the worst over them.
    decay_rate
        The rate, 1/s, at which every motion but the common drift should decay; None if none was given.
    decay_stiffness
        Ranges of stiffness, N/m, that decay so on all axes, ascending; an infinite end is no limit. They
        hold for continuous controllers and the operators in the middle of their ranges.
    uncertainty
        How well the margins are known and how probable stability is, where the masses and dampings of the
        robots have errors; None if they do not, or if the axes of a robot are not independent.
    robots_without_errors
        The robots, 1 or 2, whose masses and dampings have no errors.
    robot_records
        What identification recorded about robots 1 and 2.
    arms
        Stability in the study's own arms; None if it was not requested.
    """

    verdicts: Verdicts
    axes: tuple[AxisDecision, ...]
    horizon: float
    added_damping: float
    over_operator_ranges: bool
    decay_rate: float | None = None
    decay_stiffness: tuple[tuple[float, float], ...] = ()
    uncertainty: MarginUncertainty | None = None
    robots_without_errors: tuple[int, ...] = (1, 2)
    robot_records: tuple[RobotRecord | None, RobotRecord | None] = (None, None)
    arms: ArmStability | None = None

    @property
    def stiffness(self) -> float:
        """The stiffness in question, N/m."""
        return self.verdicts.stiffness

    @property
    def delay(self) -> tuple[float, float]:
        """Forward and backward one-way delay of the network, s."""
        return self.verdicts.network.delay

    @property
    def constant_delay(self) -> tuple[float, float]:
        """The delay that is judged, s: the network's, or with jitter or gaps that behind a playout buffer."""
        return self._constant_delay_verdict.buffer_delay or self.delay

    @property
    def mean_delay(self) -> float:
        """Half of the round trip, s: all that stability depends on."""
        return 0.5 * sum(self.constant_delay)

    @property
    def buffered(self) -> bool:
        """Whether only a playout buffer makes the delay constant."""
        return self.constant_delay != self.delay

    @property
    def sampled_stable(self) -> bool | None:
        """Whether sampled controllers are stable; None without a sample period."""
        return self.verdicts.sampled_stable

    @property
    def continuous_stable(self) -> bool:
        """Whether continuous controllers are stable at this constant delay for every operator."""
        return self._constant_delay_verdict.satisfied

    @property
    def stable(self) -> bool:
        """Whether this constant delay is stable for every operator, sampled controllers included."""
        return self.continuous_stable and self.sampled_stable is not False

    @property
    def stiffness_limit(self) -> float:
        """Every smaller stiffness is stable at this delay, sampled controllers included, N/m; may be 0."""
        sampled = [axis.sampled_stiffness_bound for axis in self.verdicts.axes]
        bounds = [self._constant_delay_verdict.stiffness_bound, *sampled]
        return min((bound for bound in bounds if bound is not None), default=math.nan)

    @property
    def delay_limit(self) -> float:
        """Every shorter one-way delay is stable, s; 0 if none is.

        Under continuous controllers if the dyad is stable, under its own controllers if it is not.
        """
        if not self.stable:
            return self.verdicts.remedies.delay or 0.0
        return min(axis.maximum_delay for axis in self.axes)

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

    @property
    def axes_independent(self) -> bool | None:
        """Whether identification found the axes of both robots independent; None if it is not known.

        If it is False, no verdict here holds: all of them treat the axes separately.
        """
        return _are_recorded_axes_independent(self.robot_records)

    @property
    def _constant_delay_verdict(self) -> Verdict:
        return self.verdicts.tier("constant delay")


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
    """Judge one dyad, stiffness and network, and compute the margins.

    Parameters
    ----------
    dyad
        The two robots and what holds them.
    stiffness
        Stiffness of the virtual spring, N/m.
    delay
        One-way delay each way, s, or the pair (forward, backward).
    jitter, max_gap, sample_period, computing_time
        What adds to the delay, s: its variation, the longest wait for a newer sample, the period of the
        controllers, and the time from reading the samples to applying the force.
    operator_ranges
        A study's ranges of operators, over which the verdicts are the worst; None for the dyad's own.
    horizon
        List stable intervals up to this one-way delay, s. The default is 1 s, or twice the delay if that
        is more.
    decay_rate
        Also compute the stiffnesses at which every motion decays at least this fast, 1/s.
    uncertainty
        Errors of the robots' masses and dampings, as `telespring.Study.uncertainty` gives them.
    records
        What identification recorded, as `robot_record` reads it.

    Returns
    -------
    Decision
        Verdicts and margins.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of range.
    """
    # Checks every value before anything is derived from it.
    judged = verdicts(
        dyad,
        stiffness,
        delay,
        jitter=jitter,
        max_gap=max_gap,
        sample_period=sample_period,
        computing_time=computing_time,
        operator_range=operator_ranges,
    )
    constant = judged.tier("constant delay")
    forward, backward = constant.buffer_delay or judged.network.delay
    mean = 0.5 * (forward + backward)
    horizon = horizon if horizon is not None else max(1.0, 2.0 * mean)
    damping = 0.0
    if not constant.satisfied or judged.sampled_stable is False:
        damping = judged.remedies.damping or math.inf
    certain = uncertainty == (None, None) or _are_recorded_axes_independent(records) is False
    return Decision(
        verdicts=judged,
        axes=tuple(
            _decide_axis(axis, verdict, stiffness, (forward, backward), horizon)
            for axis, verdict in zip(dyad, judged.axes, strict=True)
        ),
        horizon=horizon,
        added_damping=damping,
        over_operator_ranges=operator_ranges is not None,
        decay_rate=decay_rate,
        decay_stiffness=() if decay_rate is None else tuple(decay_stiffness(dyad, mean, decay_rate)),
        uncertainty=None
        if certain
        else margin_uncertainty(dyad, uncertainty, stiffness, (forward, backward)),
        robots_without_errors=tuple(i for i, known in enumerate(uncertainty, start=1) if known is None),
        robot_records=records,
    )


def _are_recorded_axes_independent(records: tuple[RobotRecord | None, RobotRecord | None]) -> bool | None:
    independent = [None if record is None else record.independent for record in records]
    return False if False in independent else None if None in independent else True


def _contains(interval: tuple[float, float], delay: float) -> bool:
    """Whether a stable interval contains a delay; its ends are crossings, except a start at 0."""
    start, end = interval
    return (start < delay or start == 0.0) and delay < end


def _decide_axis(
    axis: DyadAxis,
    verdict: AxisVerdict,
    stiffness: float,
    delay: tuple[float, float],
    horizon: float,
) -> AxisDecision:
    mean = 0.5 * sum(delay)
    around = axis.stable_delays(stiffness, max(horizon, 2.0 * mean))
    return AxisDecision(
        verdict=verdict,
        critical_stiffness_paper=DyadAxis(*axis.parameters).critical_stiffness("paper"),
        maximum_delay_paper=_maximum_delay_paper(axis, stiffness),
        stable_delays=tuple(axis.stable_delays(stiffness, horizon)),
        stable_around=next((interval for interval in around if _contains(interval, mean)), None),
        spectral_abscissa=axis.spectral_abscissa(stiffness, delay),
        crossings=tuple(axis.crossings(stiffness)),
    )


def _maximum_delay_paper(axis: DyadAxis, stiffness: float) -> float:
    if not axis.is_plain:
        return math.nan
    if axis.dampings == (0.0, 0.0):
        # Eq. 5 allows no stiffness here, and the fraction in Eq. 9 is 0/0: no sign, no angle, no delay.
        return 0.0
    return axis.maximum_delay(stiffness, "paper")
