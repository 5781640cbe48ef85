"""A robot for telespring-link in plain Python: a simulated handle behind the device protocol.

python examples/device.py --listen 127.0.0.1:4600 --site 127.0.0.1:4601

docs/device-protocol.md describes the rows. To join a robot of your own, replace the class Handle.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import socket
import struct
import sys
import time

STATE = struct.Struct("<13d")
COMMAND = struct.Struct("<8d")
PERIOD = 0.001  # s, the sample period of the study
DEADLINE = 0.02  # s, how long a command acts
LARGEST = 20.0  # N, the largest force that person and robot bear
MOST_ROWS = 64  # datagrams that one tick looks at
PATIENCE = 5.0  # s without any command, after which this program ends


class Handle:
    """A mass with a damper on each of two axes, moved by a hand that follows a slow circle."""

    def __init__(self) -> None:
        self.position = [0.0, 0.0]  # m
        self.velocity = [0.0, 0.0]  # m/s

    def move(self, seconds: float, span: float, force: list[float]) -> None:
        """Move for `span` s under the force of the motors, N; a robot of your own is told the force here."""
        aim = [0.03 * math.sin(seconds), 0.03 - 0.03 * math.cos(seconds)]
        for axis in range(2):
            hand = 100.0 * (aim[axis] - self.position[axis]) - 8.0 * self.velocity[axis]
            self.velocity[axis] += (force[axis] + hand - 8.0 * self.velocity[axis]) / 1.0 * span
            self.position[axis] += self.velocity[axis] * span


def address(text: str) -> tuple[str, int]:
    """Return host and port of "host:port"."""
    host, _, port = text.rpartition(":")
    return host, int(port)


def take(row: bytes, newest: float) -> tuple[float, list[float], bool] | None:
    """Return sequence number, force and whether the session is over; None if the row is no newer command."""
    if len(row) != COMMAND.size:
        return None
    version, sequence, _, _, x, y, _, over = COMMAND.unpack(row)
    if version != 1.0 or not sequence > newest or not all(map(math.isfinite, (sequence, x, y))):
        return None
    cut = LARGEST / max(LARGEST, math.hypot(x, y))
    return sequence, [cut * x, cut * y], over == 1.0


def main() -> None:
    """Be the robot until the session is over."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--listen", type=address, required=True, help="where this program listens")
    parser.add_argument("--site", type=address, required=True, help="device.local of the site file")
    arguments = parser.parse_args()
    site = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    site.bind(arguments.listen)
    site.connect(arguments.site)
    site.setblocking(False)

    handle = Handle()
    force, newest, told = [0.0, 0.0], 0.0, -math.inf
    start = heard = moved = time.monotonic()
    rows, commands, largest = 0, 0, 0.0
    while time.monotonic() - heard < PATIENCE:
        time.sleep(max(0.0, start + (rows + 1) * PERIOD - time.monotonic()))
        now = time.monotonic()
        for _ in range(MOST_ROWS):
            try:
                command = take(site.recv(512), newest)
            except BlockingIOError:
                break
            except ConnectionRefusedError:
                continue  # telespring-link does not listen yet
            if command is None:
                continue
            (newest, force, is_over), told, heard = command, now, now
            commands += 1
            if is_over:
                print(f"{rows} rows, {commands} commands, {largest:.3f} N at most")
                return
        if now - told > DEADLINE:
            force = [0.9 * force[0], 0.9 * force[1]]  # nobody commands: let go
        largest = max(largest, math.hypot(*force))
        handle.move(now - start, min(now - moved, 0.01), force)
        moved = now
        rows = max(rows + 1, int((now - start) / PERIOD))  # a tick that was missed is left out
        enabled, homed, stopped = 1.0, 1.0, 0.0
        state = (1.0, rows, now - start, *handle.position, *handle.velocity, 0, 0, 0, enabled, homed, stopped)
        with contextlib.suppress(ConnectionRefusedError):  # telespring-link does not listen yet
            site.send(STATE.pack(*state))
    sys.exit(f"no command for {PATIENCE} s: the robot is let go")


if __name__ == "__main__":
    main()
