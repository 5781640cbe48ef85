"""Recordings of a live session, made without the live program, as docs/recording.md describes them."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.writer import CompressionType, Writer

F = descriptor_pb2.FieldDescriptorProto
STUDY = "[coupling]\nstiffness = [100.0]\n"
SESSIONS = {1: 0x1111, 2: 0x2222}
#: Fields of messages by type, as docs/recording.md lists them; those with a question mark may be absent.
PAIR, MOTION = "Pair", "HandleMotion"
FIELDS = {
    "tick.Tick": """tick:u time:u asked_time?:u commanded_time:u lateness:d duration:d phase:s watchdog:s
    watchdog_cause?:s
        watchdog_factor:d is_measured:b is_limited:b own?:M device_sequence?:d device_time?:d target?:M
        partner_played?:M partner_predicted?:M partner_newest?:M partner_sequence?:u partner_sent_time?:u
        partner_arrival_time?:u commanded_force:P wanted_force?:P acted_force?:P told_force?:P
        measured_force?:P age?:d played_age?:d playout_delay:d round_trip?:d smallest_round_trip?:d
        clock_offset?:z clock_offset_error?:z energy_balance?:d energy_given_out:d energy_sent:d
        energy_received:d partner_energy_sent?:d stiffness_wanted:d stiffness:d partner_stiffness?:d
        latency_device?:d latency_loop:d latency_network?:d latency_playout?:d packets_sent:u
        packets_received:u
        packets_refused:u packets_lost:u packets_late:u held_ticks:u unrecorded_arrivals:u is_timed:b share:d
        handle_offset?:P overruns:u""",
    "arrival.Arrival": "tick:u time:u is_taken:b length:u datagram:y",
    "event.Event": "time:u event:s cause?:s",
}
TYPES = {
    "u": F.TYPE_UINT64,
    "z": F.TYPE_SINT64,
    "d": F.TYPE_DOUBLE,
    "b": F.TYPE_BOOL,
    "s": F.TYPE_STRING,
    "y": F.TYPE_BYTES,
    "P": F.TYPE_MESSAGE,
    "M": F.TYPE_MESSAGE,
}


@cache
def message(full: str) -> tuple[bytes, Any]:
    """Return the schema of a message as bytes, and its class."""
    package, name = full.split(".")
    file = descriptor_pb2.FileDescriptorProto(name=f"{package}.proto", package=package, syntax="proto3")
    described = file.message_type.add(name=name)
    pair = described.nested_type.add(name=PAIR)
    for number, axis in ((1, "x"), (2, "y")):
        pair.field.add(name=axis, number=number, type=F.TYPE_DOUBLE, label=F.LABEL_OPTIONAL)
    motion = described.nested_type.add(name=MOTION)
    for number, each in ((1, "position"), (2, "velocity")):
        motion.field.add(
            name=each, number=number, type=F.TYPE_MESSAGE, type_name=f".{full}.{PAIR}", label=F.LABEL_OPTIONAL
        )
    for number, text in enumerate(FIELDS[full].split(), 1):
        title, _, kind = text.partition(":")
        added = described.field.add(
            name=title.rstrip("?"), number=number, type=TYPES[kind], label=F.LABEL_OPTIONAL
        )
        if kind in "PM":
            added.type_name = f".{full}.{PAIR if kind == 'P' else MOTION}"
        elif title.endswith("?"):
            added.proto3_optional = True
            added.oneof_index = len(described.oneof_decl)
            described.oneof_decl.add(name=f"_{added.name}")
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    made = message_factory.GetMessageClass(pool.FindMessageTypeByName(full))
    return descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString(), made


class SiteFile:
    """Writes the file of one site, as the live program does: a chunk and a flush every 0.5 s."""

    def __init__(
        self,
        path: Path,
        side: int,
        *,
        period: float,
        zero: int,
        changed: dict[str, str] | None = None,
        is_checked: bool = True,
    ) -> None:
        self.path, self.zero = path, zero
        self.side = side
        self.stream = path.open("wb")
        compression = CompressionType.LZ4 if is_checked else CompressionType.NONE
        self.writer = Writer(self.stream, compression=compression, enable_crcs=is_checked)
        self.writer.start("telespring", "telespring-link")
        described = {
            "format_version": "1",
            "program_version": "0.1.0",
            "side": str(side),
            "session": f"{SESSIONS[side]:#018x}",
            "wall_time_zero": str(zero),
        }
        self.writer.add_metadata("telespring", described | (changed or {}))
        self.writer.add_metadata("endpoint", {"sample_period_ns": str(round(period * 1e9))})
        self.writer.add_attachment(0, 0, "study.toml", "application/toml", STUDY.encode())
        self.channels = {
            full: self.writer.register_channel(
                f"/site{side}/{full.split('.')[0]}",
                "protobuf",
                self.writer.register_schema(full, "protobuf", message(full)[0]),
            )
            for full in FIELDS
        }

    def write(self, full: str, made: Any) -> None:
        stamp = int(made.time) + self.zero
        self.writer.add_message(self.channels[full], stamp, made.SerializeToString(), stamp)

    def flush(self) -> None:
        self.writer.flush()

    def end(self, missed: int = 0) -> None:
        self.writer.add_metadata("end", {"missed": str(missed)})
        self.writer.finish()
        self.stream.close()


@dataclass
class MadeSession:
    """What a made session is like; times in s, on the clock of site 1."""

    seconds: float = 2.0
    period: float = 0.001
    delay: tuple[float, float] = (0.03, 0.04)
    loss: float = 0.0
    #: Of site 2's clock: ahead by this many ns, and faster by this share.
    offset: int = 7_000_000_000_123
    drift: float = 3e-5
    #: Error of what the sites believe of the other's clock, and its bound, ns.
    believed: tuple[int, int] = (2_000_000, -1_000_000)
    bound: int = 5_000_000
    stiffness: float = 100.0
    beside: float = 0.004
    marks: list[tuple[float, int, str]] = field(default_factory=list)
    paused: tuple[float, float] | None = None
    metadata: dict[int, dict[str, str]] = field(default_factory=dict)
    #: Without compression and checksums, so that damage is seen by the reader of the messages.
    is_checked: bool = True

    def target(self, time: Any) -> Any:
        return 0.05 * np.stack([np.sin(2.0 * time), np.cos(1.0 * time)], axis=-1)

    def position(self, side: int, time: Any) -> Any:
        """Robot 1 stays beside the target on x, robot 2 twice as far on y."""
        apart = np.array([self.beside, 0.0]) if side == 1 else np.array([0.0, 2.0 * self.beside])
        return self.target(time) + apart

    def velocity(self, time: Any) -> Any:
        return 0.05 * np.stack([2.0 * np.cos(2.0 * time), -np.sin(time)], axis=-1)

    def clock(self, side: int, time: Any) -> Any:
        """What the clock of a site reads, ns."""
        begin = 5_000_000_000
        whole = np.rint(np.asarray(time) * 1e9).astype(np.int64)
        drifted = np.rint(whole * self.drift).astype(np.int64) if side == 2 else 0
        return begin + whole + drifted + (self.offset if side == 2 else 0)

    def force(self, side: int, time: Any) -> Any:
        other = self.position(3 - side, time - self.delay[2 - side])
        return self.stiffness * (other - self.position(side, time))

    def write(self, folder: Path) -> tuple[Path, Path]:
        """Write the files of both sites."""
        return self.write_site(folder, 1), self.write_site(folder, 2)

    def write_site(self, folder: Path, side: int, *, end: bool = True) -> Path:
        path = folder / f"site{side}.mcap"
        file = SiteFile(
            path,
            side,
            period=self.period,
            zero=10**18 + 1000 * side,
            changed=self.metadata.get(side),
            is_checked=self.is_checked,
        )
        count = round(self.seconds / self.period)
        times = np.arange(count) * self.period
        late = self.delay[2 - side]
        rng = np.random.default_rng(side)
        lost = rng.random(count) < self.loss
        tick, arrival, event = (message(full)[1] for full in FIELDS)
        marks = sorted(mark for mark in self.marks if mark[1] == side)
        clock, other = self.clock(side, times), self.clock(3 - side, times)
        motion = [self.position(each, times) for each in (1, 2)]
        velocity, target, force = self.velocity(times), self.target(times), self.force(side, times)
        arrived = 0
        shift = round(late / self.period)
        sums = np.cumsum((force[:-1] * np.diff(motion[side - 1], axis=0)).sum(axis=1))
        file.write("event.Event", event(time=int(clock[0]), event="running"))
        for i in range(count):
            now = int(clock[i])
            while marks and marks[0][0] <= times[i]:
                made = event(time=now, event="mark", cause=marks.pop(0)[2])
                file.write("event.Event", made)
            came = i - shift
            if came >= 0 and not lost[came]:
                sent = int(other[came])
                where = motion[2 - side][came]
                packet = struct.pack(
                    "<4sBBHQQQQQ2d2ddd2d",
                    b"TSPR", 2, 2, 1, SESSIONS[3 - side], came, sent, 1, 0,
                    *where, *velocity[came], 0.0, self.stiffness, 0.0, 0.0,
                )  # fmt: skip
                file.write(
                    "arrival.Arrival", arrival(tick=i, time=now, is_taken=True, length=112, datagram=packet)
                )
                arrived += 1
            is_paused = self.paused is not None and self.paused[0] <= times[i] < self.paused[1]
            made = tick(
                tick=i, time=now, commanded_time=now, lateness=2e-5, duration=1e-4,
                phase="paused" if is_paused else "running", watchdog="engaged", watchdog_factor=1.0,
                is_measured=True, is_limited=i % 4 == 0, playout_delay=late, energy_balance=0.02,
                energy_given_out=float(sums[i - 1]) if i else 0.0, energy_sent=0.001 * i,
                stiffness_wanted=self.stiffness, stiffness=self.stiffness, latency_loop=1.2e-4,
                packets_sent=i, packets_received=arrived, packets_lost=int(lost[: max(0, came)].sum()),
            )  # fmt: skip
            made.own.position.x, made.own.position.y = motion[side - 1][i]
            made.own.velocity.x, made.own.velocity.y = velocity[i]
            made.target.position.x, made.target.position.y = target[i]
            made.commanded_force.x, made.commanded_force.y = force[i]
            if came >= 0:
                made.age = late
                made.clock_offset = int(other[i]) - now + self.believed[side - 1]
                made.clock_offset_error = self.bound
                made.round_trip = sum(self.delay)
                made.latency_network = late
            file.write("tick.Tick", made)
            if i % 500 == 499:
                file.flush()
        if end:
            file.end()
        else:
            file.flush()
            file.stream.close()
        return path
