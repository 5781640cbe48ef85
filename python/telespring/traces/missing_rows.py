"""Packets without a row: lost ones, or ones that nobody sent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from telespring._core import Trace

__all__ = ["MissingRows", "complete_trace"]

#: A step of more periods than this is not one step of the sender.
_ONE_STEP = 1.5
#: Times in whole ms are not exact in s: 24 ms are not more than 1.5 times 16 ms.
_ROUNDING = 1.0 + 1e-9
#: Unless told otherwise, a step of up to so many seconds, or periods, lost its packets.
_LONGEST_LOSS, _PERIODS_OF_LOSS = 1.0, 10.0


@dataclass(frozen=True)
class MissingRows:
    """How the steps between two rows were understood that are longer than 1.5 usual ones.

    Attributes
    ----------
    period
        The usual step: the median time between two rows, s.
    longest_loss
        Longer steps count as pauses of the sender, s.
    steps
        The number of steps whose missing packets count as lost.
    lost
        The number of packets that count as lost in them.
    pauses
        The number of steps that count as pauses of the sender; they are closed.
    longest_pause
        The longest of them, s; 0 without one.
    """

    period: float
    longest_loss: float
    steps: int
    lost: int
    pauses: int
    longest_pause: float


def complete_trace(trace: Trace, longest_loss: float | None = None) -> tuple[Trace, MissingRows | None]:
    """Insert the lost packets that have no row; None where no row is missing, or the trace records losses.

    Examples
    --------
    >>> import telespring as ts
    >>> trace = ts.Trace([0.0, 0.01, 0.02, 0.03, 0.06, 9.06], [0.02] * 6)
    >>> complete, missing = complete_trace(trace)
    >>> missing.lost, missing.pauses, len(complete)
    (2, 1, 8)
    """
    period = trace.statistics().interval
    steps = np.diff(trace.time)
    is_long = steps > _ONE_STEP * period * _ROUNDING
    if trace.losses_recorded or period == 0.0 or not is_long.any():
        return trace, None
    if longest_loss is None:
        longest_loss = max(_LONGEST_LOSS, _PERIODS_OF_LOSS * period)
    is_pause = is_long & (steps > longest_loss)
    complete = trace.with_missing_rows(period * _ROUNDING, max(longest_loss, _ONE_STEP * period * _ROUNDING))
    found = MissingRows(
        period=period,
        longest_loss=longest_loss,
        steps=int((is_long & ~is_pause).sum()),
        lost=len(complete) - len(trace),
        pauses=int(is_pause.sum()),
        longest_pause=float(steps[is_pause].max(initial=0.0)),
    )
    return complete, found
