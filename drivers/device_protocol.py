"""The device protocol (docs/device-protocol.md): its rows, and the socket that carries them.

Plain Python of its own: a device program imports nothing of telespring.
"""

from __future__ import annotations

import math
import socket
import struct
from dataclasses import dataclass

VERSION = 1.0
STATE = struct.Struct("<13d")
COMMAND = struct.Struct("<8d")
MOST_ROWS = 64  # datagrams that one tick looks at
Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class State:
    """What a device sends."""

    sequence: float
    time: float  # s, the device's own
    position: Pair  # m, in the axes of the study
    velocity: Pair  # m/s
    measured_force: Pair | None  # N, of the motors on the handle since the row before
    is_enabled: bool
    is_homed: bool
    is_stopped: bool

    def encode(self) -> bytes:
        """Return the row."""
        force = self.measured_force or (0.0, 0.0)
        flags = (self.measured_force is not None, self.is_enabled, self.is_homed, self.is_stopped)
        return STATE.pack(
            VERSION, self.sequence, self.time, *self.position, *self.velocity, *force, *map(float, flags)
        )


@dataclass(frozen=True, slots=True)
class Command:
    """What a device is told."""

    sequence: float
    force: Pair  # N, on the handle, until the next command
    is_running: bool

    @classmethod
    def decode(cls, row: bytes) -> Command | None:
        """Return the command in a row; None if the row is no data."""
        if len(row) != COMMAND.size:
            return None
        version, sequence, _, _, x, y, running, _ = COMMAND.unpack(row)
        if version != VERSION or running not in (0.0, 1.0) or not all(map(math.isfinite, (sequence, x, y))):
            return None
        return cls(sequence, (x, y), running == 1.0)


def address(text: str) -> tuple[str, int]:
    """Return host and port of "host:port"."""
    host, _, port = text.rpartition(":")
    return host, int(port)


class Link:
    """The socket to telespring-link; it waits for nothing, and hears nobody else."""

    def __init__(self, listen: tuple[str, int], site: tuple[str, int]) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(listen)
        self._socket.connect(site)
        self._socket.setblocking(False)

    def commands(self) -> list[Command]:
        """Return what has come since the last call, oldest first."""
        taken = []
        for _ in range(MOST_ROWS):
            try:
                command = Command.decode(self._socket.recv(512))
            except BlockingIOError:
                break
            except ConnectionRefusedError:
                continue  # telespring-link does not listen
            if command is not None:
                taken.append(command)
        return taken

    def send(self, state: State) -> None:
        """Send a row."""
        try:
            self._socket.send(state.encode())
        except (BlockingIOError, ConnectionRefusedError):
            return  # nobody listens, or the row has no room: the next one is newer

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
