"""A robot for telespring-link in plain Python: a simulated handle behind the device protocol.

python examples/device.py --listen 127.0.0.1:4600 --site 127.0.0.1:4601

docs/your-robot.md walks through a session with it, docs/device-protocol.md describes the rows. To join a
robot of your own, replace the class Handle.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import select
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
PATIENCE = 5.0  # s without any command after the first one, after which this program ends


class Handle:
    """A mass with a damper on each of two axes, held by a hand that follows a slow circle while coupled."""

    def __init__(self) -> None:
        self.position = [0.0, 0.0]  # m
        self.velocity = [0.0, 0.0]  # m/s
        self.rest = [0.0, 0.0]  # m, where the hand rests otherwise
        self.seconds = 0.0  # s, how long it has followed the circle

    def move(self, span: float, force: list[float], *, is_coupled: bool) -> None:
        """Move for `span` s under the force of the motors, N; a robot of your own is told the force here."""
        self.seconds = self.seconds + span if is_coupled else 0.0
        circle = [0.03 * math.sin(self.seconds), 0.03 - 0.03 * math.cos(self.seconds)]
        aim = [self.rest[axis] + circle[axis] for axis in range(2)]
        for axis in range(2):
            hand = 100.0 * (aim[axis] - self.position[axis]) - 8.0 * self.velocity[axis]
            self.velocity[axis] += (force[axis] + hand - 8.0 * self.velocity[axis]) / 1.0 * span
            self.position[axis] += self.velocity[axis] * span


def address(text: str) -> tuple[str, int]:
    """Return host and port of "host:port"."""
    host, _, port = text.rpartition(":")
    return host, int(port)


class Hand:
    """Ways for the resting hand on the standard input: lines with x and y in mm, such as `26 -89`."""

    def __init__(self) -> None:
        self.text = b""
        self.is_open = True

    def shift(self, handle: Handle) -> None:
        """Move the place where the hand rests by what has been typed."""
        if not self.is_open or not select.select([0], [], [], 0)[0]:
            return
        typed = os.read(0, 256)
        self.is_open = bool(typed)
        *lines, self.text = (self.text + typed).split(b"\n")
        for line in lines:
            try:
                x, y = (float(word) / 1000.0 for word in line.split())
            except ValueError:
                print("write x and y in mm, such as 26 -89", file=sys.stderr)
                continue
            handle.rest = [handle.rest[0] + x, handle.rest[1] + y]


def take(row: bytes, newest: float) -> tuple[float, list[float], bool, bool] | None:
    """Return sequence number, force, whether the sides are coupled and whether the session is over.

    None if the row is no newer command.
    """
    if len(row) != COMMAND.size:
        return None
    version, sequence, _, _, x, y, coupled, over = COMMAND.unpack(row)
    if version != 1.0 or not sequence > newest or not all(map(math.isfinite, (sequence, x, y))):
        return None
    cut = LARGEST / max(LARGEST, math.hypot(x, y))
    return sequence, [cut * x, cut * y], coupled == 1.0, over == 1.0


def main() -> None:
    """Be the robot until the session is over."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--listen", type=address, required=True, help="where this program listens")
    parser.add_argument("--site", type=address, required=True, help="device.local of the site file")
    parser.add_argument(
        "--hand", action="store_true", help="take ways of the hand from standard input, x y in mm"
    )
    arguments = parser.parse_args()
    site = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    site.bind(arguments.listen)
    site.connect(arguments.site)
    site.setblocking(False)

    handle, hand = Handle(), Hand() if arguments.hand else None
    force, newest, told, is_coupled = [0.0, 0.0], 0.0, -math.inf, False
    start = moved = time.monotonic()
    rows, commands, largest = 0, 0, 0.0
    while told == -math.inf or time.monotonic() - told < PATIENCE:
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
            (newest, force, is_coupled, is_over), told = command, now
            commands += 1
            if is_over:
                print(f"{rows} rows, {commands} commands, {largest:.3f} N at most")
                return
        if now - told > DEADLINE:
            force, is_coupled = [0.9 * force[0], 0.9 * force[1]], False  # nobody commands: let go
        largest = max(largest, math.hypot(*force))
        if hand is not None:
            hand.shift(handle)
        handle.move(min(now - moved, 0.01), force, is_coupled=is_coupled)
        moved = now
        rows = max(rows + 1, int((now - start) / PERIOD))  # a tick that was missed is left out
        enabled, homed, stopped = 1.0, 1.0, 0.0
        state = (1.0, rows, now - start, *handle.position, *handle.velocity, 0, 0, 0, enabled, homed, stopped)
        with contextlib.suppress(ConnectionRefusedError):  # telespring-link does not listen yet
            site.send(STATE.pack(*state))
    sys.exit(f"no command for {PATIENCE} s: the robot is let go")


if __name__ == "__main__":
    main()
