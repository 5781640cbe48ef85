"""What the network of a recorded session did to each packet, and the study that rehearses on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from telespring._core import Study, Trace
from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.replays.results import Replay
from telespring.replays.sites import SiteRecording, arrival_stamps

__all__ = ["NETWORK_FILES", "rehearsal_study", "session_traces", "way_trace", "write_traces"]

#: The ways forward, from robot 1 to robot 2, and backward, as they are written beside the study.
NETWORK_FILES = ("forward.csv", "backward.csv")


def way_trace(site: SiteRecording) -> Trace:
    """Return what happened to the packets on the way to a site, in the order of sending.

    A delay is from the measurement of a motion to the tick at which the site took it, by the partner's clock
    as the site estimated it at that time. A number that is missing between two that came is a packet that was
    lost.
    """
    stamps = arrival_stamps(site)
    offset = np.asarray(site.clock_offset, dtype=float)[np.asarray(site.arrival_tick)]
    is_known = stamps.is_packet & np.isfinite(offset)
    # of a packet that came twice, the first
    sequence, first = np.unique(stamps.sequence[is_known], return_index=True)
    if len(sequence) < 2:
        raise InvalidInput(
            f"site {site.side}",
            f"{len(sequence)} packet(s) whose time of sending is known",
            "a rehearsal on the session's network needs at least two on each way that was recorded",
            "Record a session in which both sides ran.",
        )
    sent = stamps.sent[is_known][first].astype(np.int64)
    arrived = np.asarray(site.arrival_time)[is_known][first].astype(np.int64)
    # whole nanoseconds since the first packet: the clocks may read days
    since = sent - sent[0]
    shift = np.round(1e9 * offset[is_known][first]).astype(np.int64)
    delay = np.maximum(0, arrived - (sent - shift))
    numbers = (sequence - sequence[0]).astype(np.int64)
    if numbers[-1] > 20 * len(numbers) + 1000:
        raise InvalidInput(
            f"site {site.side}",
            f"{len(numbers)} packets of {numbers[-1] + 1}",
            "a recording whose packets are of one session is required",
            "Give the recording of one session.",
        )
    every = np.arange(numbers[-1] + 1)
    delays = np.full(len(every), np.nan)
    delays[numbers] = 1e-9 * delay
    times = np.maximum.accumulate(np.interp(every, numbers, 1e-9 * since))
    return Trace(times, delays, losses_recorded=True)


def session_traces(found: Replay) -> tuple[Trace, Trace]:
    """Return the ways forward and backward; with one side recorded its incoming way counts for both."""
    ways = {side.side: way_trace(side.recording) for side in found.sides}
    only = next(iter(ways.values()))
    return ways.get(2, only), ways.get(1, only)


def write_traces(found: Replay, folder: Path) -> list[Path]:
    """Write both ways as `telespring trace` and a study read them."""
    traces = session_traces(found)
    return [
        write_whole(folder / name, trace.to_csv()) for name, trace in zip(NETWORK_FILES, traces, strict=True)
    ]


def rehearsal_study(found: Replay) -> Study:
    """Return the study that compares the recorded and the replayed settings on the session's network.

    It names the files of `write_traces`. Simulated people react to the force, so it tells what a replay
    cannot.
    """
    recorded, study = found.recorded_study, found.study
    sessions = [recorded.session] if recorded.session == study.session else [recorded.session, study.session]
    forward, backward = NETWORK_FILES
    return recorded.replace(
        comparison={
            "architectures": [session.settings() for session in sessions],
            "networks": [
                {"name": "recorded session", "trace": {"forward": forward, "backward": backward}},
            ],
        },
        protocol={
            "stiffness": sorted({recorded.stiffness, study.stiffness}),
            "delay": [max(recorded.delay)],
        },
    )
