"""Two sites of a live session as an exact replay needs them: made by hand, packet by packet."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

import telespring as ts
from made_recording import message

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
    ticks: int = 2000, *, still: bool = False, has_target: bool = False, loss: float = 0.02, **session: object
) -> tuple[ts.SiteRecording, ts.SiteRecording]:
    """Make both sides of a session of a spring of 60 N/m, without the forces.

    A target stands still where robot 1 begins.
    """
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
    target = np.tile(motions[0][0][0], (ticks, 1)) if has_target else unknown
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
            target_position=target,
            target_velocity=0.0 * target,
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


def with_forces(
    pair: tuple[ts.SiteRecording, ts.SiteRecording],
) -> tuple[ts.SiteRecording, ts.SiteRecording]:
    """Give a made session the forces that its own settings give."""
    found = ts.replay(*pair)
    one, two = (
        dataclasses.replace(side.recording, wanted=side.own.wanted, force=side.own.force)
        for side in found.sides
    )
    return one, two


def write_session(folder: Path) -> list[Path]:
    """Write the recordings of both sites of a session, as `telespring connect` does."""
    folder.mkdir(parents=True, exist_ok=True)
    sites = with_forces(made_session(has_target=True))
    return [write_recording(folder / f"site{site.side}.mcap", site) for site in sites]


def write_recording(path: Path, site: ts.SiteRecording) -> Path:
    """Write a made site as the live program does, as far as a replay reads it."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=50_000, compression=CompressionType.LZ4)
        writer.start("telespring", "telespring-link")
        writer.add_metadata(
            "telespring",
            {"format_version": "1", "program_version": "0.1.0", "side": str(site.side)}
            | {"session": f"{site.session:#018x}", "wall_time_zero": "1700000000000000000"},
        )
        writer.add_metadata("endpoint", {"sample_period_ns": str(PERIOD)})
        spans = {"silence_ns": round(1e9 * site.silence), "stall_ns": round(1e9 * site.stall)}
        safety = {name: str(value) for name, value in spans.items()}
        limits = {"force": repr(site.largest_force), "rise": repr(site.steepest_rise)}
        limits |= {"scale": "1", "lock_x": "false", "lock_y": "false"}
        writer.add_metadata("safety", safety | limits)
        writer.add_attachment(0, 0, "study.toml", "application/toml", site.study.to_toml().encode())
        made = {}
        for full in ("tick.Tick", "arrival.Arrival", "event.Event"):
            schema, kind = message(full)
            topic = f"/site{site.side}/{full.split('.')[0]}"
            number = writer.register_schema(full, "protobuf", schema)
            made[full] = writer.register_channel(topic, "protobuf", number), kind
        arrivals = list(zip(site.arrival_tick, site.arrival_time, site.datagram, strict=True))
        for tick, time in enumerate(site.time.tolist()):
            while arrivals and arrivals[0][0] == tick:
                _, came, datagram = arrivals.pop(0)
                arrival = made["arrival.Arrival"][1](
                    tick=tick, time=int(came), is_taken=True, length=112, datagram=datagram.tobytes()
                )
                writer.add_message(made["arrival.Arrival"][0], time, arrival.SerializeToString(), time)
            row = made["tick.Tick"][1](
                tick=tick,
                time=time,
                commanded_time=time + 100_000,
                phase="running",
                watchdog="engaged",
                is_measured=bool(site.is_given[tick]),
                share=float(site.share[tick, 0]),
                stiffness_wanted=site.study.stiffness,
                stiffness=site.study.stiffness,
            )
            if site.answered[tick]:
                row.asked_time = int(site.answered[tick])
            offset = site.clock_offset[tick]
            if np.isfinite(offset):
                row.clock_offset, row.clock_offset_error = round(1e9 * offset), 1000
            forces = {"wanted_force": site.wanted, "commanded_force": site.force, "told_force": site.acted}
            for name, values in forces.items():
                if np.isfinite(values[tick]).all():
                    fill(getattr(row, name), values[tick])
            if site.is_given[tick]:
                fill(row.own.position, site.position[tick])
                fill(row.own.velocity, site.velocity[tick])
            if np.isfinite(site.target_position[tick]).all():
                fill(row.target.position, site.target_position[tick])
                fill(row.target.velocity, site.target_velocity[tick])
            writer.add_message(made["tick.Tick"][0], time, row.SerializeToString(), time)
        writer.add_metadata("end", {"missed": "0"})
        writer.finish()
    return path


def fill(pair: Any, values: NDArray[np.float64]) -> None:
    """Set a pair of numbers; also one of zeros is there then."""
    pair.SetInParent()
    pair.x, pair.y = (float(value) for value in values)
