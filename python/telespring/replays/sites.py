"""What a replay needs of one site of a recorded session."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._core import RecordedSite, Study
from telespring._errors import InvalidInput
from telespring._types import FloatArray

__all__ = ["PACKET_LENGTH", "ArrivalStamps", "SiteRecording", "arrival_stamps", "check_one_session"]

#: A packet's length and first bytes, and where its session id, number and sent stamp begin; docs/wire.md.
PACKET_LENGTH = 112
_MAGIC = b"TSPR"
_SESSION_AT, _SEQUENCE_AT, _SENT_AT = 8, 16, 24


@dataclass(frozen=True, eq=False)
class SiteRecording:
    """All that the endpoint of one site was given in a session, in its order, and what it answered.

    `replay` takes it instead of a file. One row per tick, n of them, and per datagram, m of them.

    Attributes
    ----------
    study
        The study of the session.
    side
        The robot of the study that the site moved, 1 or 2.
    session
        Its session id.
    silence, stall, largest_force
        What the site file said under `safety` and `limits.force`, s and N.
    time
        When each tick began, ns on the site's clock, (n,) uint64.
    answered
        When the endpoint was asked for the force, ns; 0 where it was not.
    is_given
        Whether the endpoint was given a motion.
    position, velocity
        This motion, m and m/s, (n, 2).
    acted
        The force that the endpoint was told to have acted, N, (n, 2); NaN where it was told none.
    target_position, target_velocity
        The target that it was given, m and m/s, (n, 2); NaN where it was given none.
    share
        The share of its force that the site let act, per axis, before its limit, (n, 2).
    wanted, force
        The force of the endpoint and that of the site, as recorded, N, (n, 2); NaN where the endpoint was not
        asked.
    clock_offset
        The partner's clock minus this one, as the endpoint used it, s, (n,); NaN before it knew.
    arrival_tick, arrival_time
        The tick in which the endpoint was given each datagram, and when, ns on the site's clock, (m,) int64
        and uint64.
    datagram
        The bytes, (m, 112) uint8.
    steepest_rise
        What the site file said under `limits.rise`, N/s. Default: no limit.
    has_measured_force
        Whether the device measured the force that acted. Default: no.
    """

    study: Study
    side: int
    session: int
    silence: float
    stall: float
    largest_force: float
    time: NDArray[np.uint64]
    answered: NDArray[np.uint64]
    is_given: NDArray[np.bool_]
    position: FloatArray
    velocity: FloatArray
    acted: FloatArray
    target_position: FloatArray
    target_velocity: FloatArray
    share: FloatArray
    wanted: FloatArray
    force: FloatArray
    clock_offset: FloatArray
    arrival_tick: NDArray[np.int64]
    arrival_time: NDArray[np.uint64]
    datagram: NDArray[np.uint8]
    steepest_rise: float = math.inf
    has_measured_force: bool = False

    def core(self) -> RecordedSite:
        """Return the same as the core takes it; InvalidInput where lengths, times or order do not fit."""
        columns: dict[str, Any] = {
            "time": np.ascontiguousarray(self.time, dtype=np.uint64),
            "answered": np.ascontiguousarray(self.answered, dtype=np.uint64),
            "is_given": np.ascontiguousarray(self.is_given, dtype=np.bool_),
            "position": self.position,
            "velocity": self.velocity,
            "acted": self.acted,
            "target_position": self.target_position,
            "target_velocity": self.target_velocity,
            "share": self.share,
            "arrival_tick": np.ascontiguousarray(self.arrival_tick, dtype=np.int64),
            "arrival_time": np.ascontiguousarray(self.arrival_time, dtype=np.uint64),
            "datagram": np.ascontiguousarray(self.datagram, dtype=np.uint8),
        }
        return RecordedSite(**columns)


@dataclass(frozen=True, eq=False)
class ArrivalStamps:
    """What the arrivals of a site say of themselves, (m,).

    Attributes
    ----------
    is_packet
        Whether each is a packet at all.
    session, sequence
        The session id of its sender, and its number.
    sent
        When it was sent, ns on the sender's clock.
    """

    is_packet: NDArray[np.bool_]
    session: NDArray[np.uint64]
    sequence: NDArray[np.uint64]
    sent: NDArray[np.uint64]


def arrival_stamps(site: SiteRecording) -> ArrivalStamps:
    """Read the stamps of a site's arrivals."""
    rows = np.ascontiguousarray(site.datagram, dtype=np.uint8).reshape(-1, PACKET_LENGTH)

    def numbers(start: int) -> NDArray[np.uint64]:
        return np.ascontiguousarray(rows[:, start : start + 8]).view("<u8").reshape(-1)

    is_packet = (rows[:, : len(_MAGIC)] == np.frombuffer(_MAGIC, dtype=np.uint8)).all(axis=1)
    return ArrivalStamps(is_packet, numbers(_SESSION_AT), numbers(_SEQUENCE_AT), numbers(_SENT_AT))


def check_one_session(first: SiteRecording, second: SiteRecording) -> None:
    """Refuse recordings that are not of both sides of one session."""
    if first.side == second.side:
        raise InvalidInput(
            "side",
            f"{first.side} in both recordings",
            "one recording of each side is required",
            "Give the recording of the other site.",
        )
    if first.study != second.study:
        raise InvalidInput(
            "study",
            f"{first.study.name or 'a study'} and {second.study.name or 'another'}",
            "both recordings must be of the same study",
            "Give the two recordings of one session.",
        )
    for site, partner in ((first, second), (second, first)):
        stamps = arrival_stamps(site)
        if stamps.is_packet.any() and not (stamps.session == np.uint64(partner.session)).any():
            raise InvalidInput(
                "session",
                f"{partner.session:#018x}",
                f"site {site.side} has heard no packet of this session of site {partner.side}",
                "Give the two recordings of one session.",
            )
