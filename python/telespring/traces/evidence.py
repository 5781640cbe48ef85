"""What a recording can prove: how rare an event it may have missed, and whether its units are likely."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from telespring._core import Trace, usual_range
from telespring._errors import InvalidInput
from telespring.traces.playouts import MOSTLY, SHARES

if TYPE_CHECKING:
    from telespring._types import TraceDoubt

__all__ = ["LEAST_DURATION", "LEAST_PACKETS", "TraceEvidence", "check_evidence"]

#: The probability with which a recording may have missed what it is said to have met.
_MISSED = 0.05


def _packets_to_meet(share: float) -> int:
    """Return how many packets meet what befalls more than 1 − `share` of them, but for a probability of 5 %.

    Wilks (1941): the longest of n delays exceeds the quantile p with the probability 1 − pⁿ.
    """
    return math.ceil(math.log(_MISSED) / math.log(share))


#: What is said of 99 % of the packets, or of the time, needs so many, and a time of which 1 % is 0.1 s.
LEAST_PACKETS, LEAST_DURATION = _packets_to_meet(MOSTLY), 10.0
#: The same for 99.9 %, the rarest share that a play-out waits for.
_ENOUGH_PACKETS, _ENOUGH_DURATION = _packets_to_meet(SHARES[-2]), 100.0
#: 1000 times 10 ms may be a little less than 10 s.
_ROUNDING = 1.0 - 1e-9
#: Between two packets, s; what happens in between is unknown.
_SLOW = 0.1
#: Delays that are all shorter are those of one building, or in another unit, s.
_SHORT_DELAY = 0.001


@dataclass(frozen=True)
class TraceEvidence:
    """How much was recorded of one way, and what that cannot show.

    Attributes
    ----------
    packets
        The number of packets sent.
    duration
        The time over which they were sent, pauses of the sender left out, s.
    missed_share
        What befalls each packet with this probability may have been missed, with a probability of 5 %: 3 in
        the number of packets (the rule of three).
    missed_every
        The same of what comes once in this time on average, s: a third of the duration.
    doubts
        "short": fewer packets or less time than 99.9 % needs. "slow": more than 0.1 s between two packets.
        "delays below 1 ms": they may be in another unit.
    """

    packets: int
    duration: float
    missed_share: float
    missed_every: float
    doubts: tuple[TraceDoubt, ...]


def check_evidence(trace: Trace, *, allow_unusual: bool = False) -> TraceEvidence:
    """Say what the recording of one way can prove; refuse one that can prove nothing, or has another unit.

    Examples
    --------
    >>> import telespring as ts
    >>> check_evidence(ts.Trace([0.02 * n for n in range(3000)], [0.03] * 3000)).doubts
    ('short',)
    """
    shown = trace.statistics()
    if not allow_unusual:
        _check_units(shown.interval, shown.median)
    packets, duration = shown.sent, trace.duration
    if packets < LEAST_PACKETS or duration < _ROUNDING * LEAST_DURATION:
        hint = " If the times are in s, name the column time_s." if shown.interval < 1e-4 else ""
        raise InvalidInput(
            "trace",
            f"{packets} packets in {duration:.3g} s",
            f"at least {LEAST_PACKETS} packets in {LEAST_DURATION:g} s are required: fewer say nothing about "
            f"{100 * MOSTLY:g} % of the time",
            f"Record for longer: two minutes or more.{hint}",
        )
    doubts: list[TraceDoubt] = []
    if packets < _ENOUGH_PACKETS or duration < _ROUNDING * _ENOUGH_DURATION:
        doubts.append("short")
    if shown.interval > _SLOW:
        doubts.append("slow")
    if shown.maximum < _SHORT_DELAY:
        doubts.append("delays below 1 ms")
    three = -math.log(_MISSED)
    return TraceEvidence(packets, duration, three / packets, duration / three, tuple(doubts))


def _check_units(interval: float, delay: float) -> None:
    """Refuse what no network has: then the unit in the name of a column is another one."""
    longest = usual_range("delay")[1]
    for name, what, value in (
        ("time", f"{interval:g} s between two packets", interval),
        ("delay", f"half of the delays are {delay:g} s or longer", delay),
    ):
        if value <= longest:
            continue
        # the unit in which the number would be usual
        unit = next(
            unit for unit, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)) if value * factor <= longest
        )
        raise InvalidInput(
            f"trace, column {name}",
            what,
            f"usual are up to {longest:g} s",
            f"If the column is in {unit}, name it {name}_{unit}. If it is right, allow unusual values "
            "(--allow-unusual).",
        )
