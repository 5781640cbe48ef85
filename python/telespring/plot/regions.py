"""What a map of stability shows: where the answer of `telespring.decide` is that a dyad is stable."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from telespring._core import stiffness_limit
from telespring._types import FloatArray
from telespring.model import Dyad, DyadAxis, Network, OperatorRange
from telespring.show.figures.maps import HORIZON, MapColumn, stable_depth
from telespring.theory.verdicts import Verdicts, delay_limit, verdicts

__all__ = ["MapQuestion", "map_extent"]

#: Columns of a map over the stiffness, and rows over the delay.
_POINTS = 400
#: Over ranges of operators a column or row takes milliseconds: fewer are judged.
_RANGE_POINTS = 100
#: A map without a condition reaches to this one-way delay, s: a slow connection between continents.
_LONGEST = 0.25
_STIFFEST = 1e7
#: Room beyond what must be on the map, and how much farther it may reach for a limit than for the condition.
_ROOM, _MOST_STIFFNESS, _MOST_DELAY = 1.25, 20.0, 6.0

Boundaries = list[tuple[str, FloatArray]]


@dataclass(frozen=True)
class MapQuestion:
    """What is asked at every point of a map.

    A delay here is the shortest one, the mean of both ways; jitter and gaps come on top of it.

    Attributes
    ----------
    dyad
        Robots, and operators unless these are ranges.
    network
        The proportion of both delays, and the timing of network and controllers.
    ranges
        Ranges of both operators; None for the dyad's own.
    has_playout_buffer
        Whether a playout buffer makes the delay constant.
    """

    dyad: Dyad
    network: Network
    ranges: tuple[OperatorRange, OperatorRange] | None
    has_playout_buffer: bool

    @property
    def extra(self) -> float:
        """By how much a delay may be longer, s: jitter and gaps."""
        return 0.5 * sum(self.network.jitters) + self.network.max_gap

    @property
    def is_varying(self) -> bool:
        """Whether the delay varies, with nothing that makes it constant."""
        return not self.network.is_constant and not self.has_playout_buffer

    @property
    def is_sampled(self) -> bool:
        """Whether the controllers sample."""
        return self.network.sample_period > 0.0

    def at(self, delay: float) -> Network:
        """Return the network at another delay, s, in the same proportion of both ways."""
        forward, backward = self.network.delay
        mean = 0.5 * (forward + backward)
        shares = (1.0, 1.0) if mean == 0.0 else (forward / mean, backward / mean)
        own = self.network
        timing = own.jitters, own.max_gap, own.sample_period, own.computing_time
        return Network((shares[0] * delay, shares[1] * delay), *timing)

    def grid(
        self, extent: tuple[float, float], mark: tuple[float | None, float | None]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the stiffnesses, N/m, and delays, s, that are judged, those of the condition among them."""
        points = _POINTS if self.ranges is None else _RANGE_POINTS
        stiffness = np.linspace(0.0, extent[0], points + 1)[1:]
        delay = np.linspace(0.0, extent[1], _POINTS + 1)
        if mark[0]:
            stiffness = np.union1d(stiffness, mark[0])
        if mark[1]:
            delay = np.union1d(delay, mark[1])
        return stiffness, delay

    def constant(self, stiffness: FloatArray, delays: FloatArray) -> Boundaries:
        """Find how far the points (delay, stiffness) lie inside what is stable at a constant delay, s.

        With jitter and gaps it is the delay behind a playout buffer. With a label for each axis;
        over ranges of operators for all axes together.
        """
        if self.ranges is not None:
            limits = np.array([self._delay_limit(float(k)) for k in stiffness])
            limits = np.minimum(limits, self.extra + 2.0 * delays[-1])
            depth = limits - self.extra - delays[:, None]
            return [("limit for every operator and axis", _lower_of_neighbours(depth))]
        found = []
        for axis in self.dyad:
            behind = delays + self.extra
            horizon = HORIZON * float(behind[-1])
            columns = [MapColumn(k, self._stable(axis, k, horizon)) for k in stiffness.tolist()]
            depth = stable_depth(columns, behind)
            # Whole periods are steps; a line between two of them would pass over a corner.
            found.append(
                (f"boundary of axis {axis.name}", _lower_of_neighbours(depth) if self.is_sampled else depth)
            )
        return found

    def varying(self, stiffness: FloatArray, delays: FloatArray) -> FloatArray:
        """Find by how much the stiffness may be larger while the delay varies, N/m, (delay, stiffness)."""
        every = 1 if self.ranges is None else _POINTS // _RANGE_POINTS
        judged = np.union1d(delays[::every], delays[-1])
        limits = [min(self._varying_limit(float(delay)), 2.0 * stiffness[-1]) for delay in judged]
        # The limit falls as the delay grows: that of the next longer delay judged holds.
        following = np.take(
            limits, np.minimum(np.searchsorted(judged, delays, side="right"), judged.size - 1)
        )
        return following[:, None] - stiffness

    def judge(self, delay: float) -> Verdicts:
        """Return the verdicts at a delay, s, whose bounds are for every stiffness."""
        return verdicts(self.dyad, 1.0, self.at(delay), operator_range=self.ranges)

    def stiffness_limit(self, delay: float) -> float:
        """Return the largest stiffness that a map shows as a limit at a delay, N/m; may be infinite."""
        judged = self.judge(delay)
        constant = stiffness_limit(judged)
        allowed = judged.stiffness_allowed if self.is_varying else None
        return constant if allowed is None else max(constant, allowed.stiffness)

    def longest_stable(self, stiffness: float) -> float:
        """Return the first delay at which a stiffness is unstable, s, jitter and gaps left out."""
        return self._delay_limit(stiffness) - self.extra

    def _delay_limit(self, stiffness: float) -> float:
        return delay_limit(self.dyad, stiffness, self.network, self.ranges).delay

    def _varying_limit(self, delay: float) -> float:
        allowed = self.judge(delay).stiffness_allowed
        return 0.0 if allowed is None else allowed.stiffness

    def _stable(self, axis: DyadAxis, stiffness: float, horizon: float) -> list[tuple[float, float]]:
        """List the stable delays of an axis, s; controllers that sample must be stable in both models."""
        intervals = axis.stable_delays(stiffness, horizon)
        if not self.is_sampled:
            return intervals
        period, computing = self.network.sample_period, self.network.computing_time
        forward, backward = self.network.delay
        behind = (forward + self.extra, backward + self.extra)
        # A list that is cut at a whole period must end beyond the map.
        sampled = axis.sampled_stable_delays(stiffness, period, computing, behind, horizon + 2.0 * period)
        return [
            (max(one[0], other[0]), min(one[1], other[1]))
            for one in intervals
            for other in sampled
            if max(one[0], other[0]) < min(one[1], other[1])
        ]


def _lower_of_neighbours(depth: FloatArray) -> FloatArray:
    """Lower every column to its neighbours: a line between two is then above neither of their limits."""
    padded = np.pad(depth, ((0, 0), (1, 1)), mode="edge")
    return np.minimum(np.minimum(padded[:, :-2], padded[:, 2:]), depth)


def map_extent(asked: MapQuestion, mark: tuple[float | None, float | None]) -> tuple[float, float]:
    """Choose the largest stiffness, N/m, and delay, s, of a map: for the condition and its limits."""
    stiffness, delay = mark
    longest = 0.0
    if stiffness:
        most = asked.longest_stable(stiffness)
        if delay:
            most = min(most, _MOST_DELAY * delay)
        longest = most if math.isfinite(most) else 0.0
    if delay:
        longest = max(longest, delay, 0.0 if stiffness else 2.0 * delay)
    longest = min(_ROOM * longest, 100.0) if longest > 0.0 else _LONGEST
    widest = asked.stiffness_limit(longest / 6.0 if delay is None else delay)
    if stiffness:
        most = widest if delay is not None or not math.isfinite(widest) else min(widest, 2.0 * stiffness)
        widest = max(stiffness, min(most, _MOST_STIFFNESS * stiffness))
    elif not 0.0 < widest < math.inf:
        widest = _no_limit(asked, longest)
    return min(_ROOM * widest, _STIFFEST), longest


def _no_limit(asked: MapQuestion, longest: float) -> float:
    """Choose a largest stiffness where no limit is at the delay: that of a longer delay, or any."""
    limit = asked.stiffness_limit(0.5 * longest)
    return limit if 0.0 < limit < math.inf else 500.0
