"""Two sites of a live session as an exact replay needs them: made by hand, packet by packet."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

import telespring as ts

PERIOD = 1_000_000
SESSIONS = (0xA11CE, 0xB0B)
#: What the clocks of both sites read at the start, ns.
STARTS = (5_000_000_000, 81_234_567_890)
#: How long a packet takes, ns, but for jitter.
TRAVEL = 20_300_000


def packet(session: int, number: int, sent: int, echo: tuple[int, int], motion: NDArray[np.float64]) -> bytes:
    """Write a packet as docs/wire.md has it, of a spring that keeps no account."""
    stamps = struct.pack("<4sBBHQQQQQ", b"TSPR", 2, 2, 0, session, number, sent, *echo)
    return stamps + struct.pack("<4d", *motion) + struct.pack("<4d", 0.0, 60.0, 0.0, 0.0)


def positions(ticks: int, side: int, *, still: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return position (m) and velocity (m/s) of a handle: at rest 2 cm from the other, or on a circle."""
    time = 1e-3 * np.arange(ticks)
    apart = np.array([0.02 * side, 0.0])
    if still:
        return np.tile(apart, (ticks, 1)), np.zeros((ticks, 2))
    rate, size = 5.0 + side, 0.04
    circle = size * np.stack([np.sin(rate * time), np.cos(rate * time)], axis=1)
    return circle + apart, size * rate * np.stack([np.cos(rate * time), -np.sin(rate * time)], axis=1)


def made_session(
    ticks: int = 2000, *, still: bool = False, loss: float = 0.02, **session: object
) -> tuple[ts.SiteRecording, ts.SiteRecording]:
    """Make both sides of a session of a spring of 60 N/m; the forces are those of a replay."""
    study = ts.Study.paper().replace(coupling={"stiffness": 60.0}, network={"delay": 0.04}, session=session)
    random = np.random.default_rng(1)
    motions = [positions(ticks, side, still=still) for side in range(2)]
    begins = [STARTS[side] + PERIOD * np.arange(ticks) + 300_000 * side for side in range(2)]
    known: list[tuple[int, int] | None] = [None, None]  # the newest stamp of the partner, and when it came
    travelling: list[list[tuple[int, bytes, int]]] = [[], []]
    arrivals: list[list[tuple[int, int, bytes]]] = [[], []]
    for tick in range(ticks):
        for side in range(2):
            now = int(begins[side][tick])
            newest = known[side]
            echo = (0, 0) if newest is None else (newest[0], now - newest[1])
            position, velocity = motions[side]
            sent = packet(SESSIONS[side], tick, now, echo, np.concatenate([position[tick], velocity[tick]]))
            if random.random() >= loss:
                travel = TRAVEL + int(4e6 * random.random())
                travelling[1 - side].append((now - STARTS[side] + travel, sent, now))
            due = [item for item in travelling[side] if item[0] <= now - STARTS[side]]
            travelling[side] = [item for item in travelling[side] if item[0] > now - STARTS[side]]
            for place, (_, datagram, stamp) in enumerate(sorted(due)):
                arrived = now + 500 * (place + 1)
                arrivals[side].append((tick, arrived, datagram))
                newest = known[side]
                if newest is None or stamp > newest[0]:
                    known[side] = stamp, arrived
    unknown = np.full((ticks, 2), np.nan)
    sites = [
        ts.SiteRecording(
            study=study,
            side=side + 1,
            session=SESSIONS[side],
            silence=0.15,
            stall=0.02,
            largest_force=20.0,
            time=begins[side].astype(np.uint64),
            answered=(begins[side] + 90_000).astype(np.uint64),
            is_given=np.ones(ticks, dtype=bool),
            position=motions[side][0],
            velocity=motions[side][1],
            acted=unknown,
            target_position=unknown,
            target_velocity=unknown,
            share=np.ones((ticks, 2)),
            wanted=unknown,
            force=unknown,
            clock_offset=np.full(ticks, 1e-9 * (STARTS[1 - side] - STARTS[side])),
            arrival_tick=np.array([tick for tick, _, _ in arrivals[side]], dtype=np.int64),
            arrival_time=np.array([time for _, time, _ in arrivals[side]], dtype=np.uint64),
            datagram=np.frombuffer(
                b"".join(datagram for _, _, datagram in arrivals[side]), dtype=np.uint8
            ).reshape(-1, 112),
        )
        for side in range(2)
    ]
    return sites[0], sites[1]
