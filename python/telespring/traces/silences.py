"""How often a network falls silent for so long that a live session lets the force go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from telespring._core import Trace

__all__ = ["SILENCE", "Silences", "find_silences"]

#: After so long without a packet the force of a live session is zero (`safety.silence`), s.
SILENCE = 0.15


@dataclass(frozen=True)
class Silences:
    """How often nothing comes for at least `limit`.

    Attributes
    ----------
    limit
        After so long without a packet a live session has no force, s.
    count
        How often that happens.
    longest
        The longest time without a packet, s.
    share
        The share of the time without a force, the time of the ramps not counted.
    """

    limit: float
    count: int
    longest: float
    share: float


def find_silences(trace: Trace, period: float, limit: float = SILENCE) -> Silences:
    """Find the silences of a session with a packet every `period` s over the trace.

    A packet has the delay and the fate of the recorded packet that was sent last before it.

    Examples
    --------
    Of 10 s, nothing comes for half a second:

    >>> import telespring as ts
    >>> time = [0.01 * n for n in range(1000)]
    >>> trace = ts.Trace(time, [float("nan") if 3 <= at < 3.5 else 0.02 for at in time])
    >>> found = find_silences(trace, 0.001)
    >>> found.count, round(found.longest, 3), round(found.share, 3)
    (1, 0.501, 0.035)
    """
    sent = trace.time[0] + period * np.arange(int(trace.duration / period) + 1)
    row = np.searchsorted(trace.time, sent + 1e-9, side="right") - 1
    came = np.sort((sent + trace.delay[row])[~trace.lost[row]])
    # what was lost at the beginning or at the end of the recording is a silence, too
    first = sent[0] + (float(np.min(trace.delay[~trace.lost])) if came.size else 0.0)
    gaps = np.diff([first, *came, max(sent[-1], first, *came[-1:])])
    # stamps are rounded
    silent = gaps[gaps >= limit * (1.0 - 1e-9)]
    span = trace.duration or period
    return Silences(limit, len(silent), float(gaps.max(initial=0.0)), float(np.sum(silent - limit) / span))
