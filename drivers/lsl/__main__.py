"""A bridge from the telemetry stream of telespring-link to Lab Streaming Layer.

python -m drivers.lsl --listen 127.0.0.1:4700
"""

from __future__ import annotations

import argparse
import signal
import socket
import sys
import time
from types import FrameType

from drivers.device_protocol import address
from drivers.lsl.bridge import Bridge, Stream
from drivers.lsl.outlets import LslOutlets, clock_offset
from drivers.telemetry import Source

LOOK = 0.1  # s, the longest wait for rows
COMPARE = 10.0  # s, from one comparison of the clocks to the next


def serve(source: Source, bridge: Bridge) -> None:
    """Hand rows on until a signal comes."""
    is_over = False

    def end(_signal: int, _frame: FrameType | None) -> None:
        nonlocal is_over
        is_over = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    offset, error = clock_offset()
    compared = time.monotonic()
    print(f"LSL's clock less the monotonic one: {1e6 * offset:.2f} ± {1e6 * error:.2f} µs", flush=True)
    while not is_over:
        rows, marks = source.rows(LOOK)
        bridge.take(rows, offset)
        bridge.mark(marks, offset)
        if time.monotonic() - compared > COMPARE:
            now, error = clock_offset()
            compared = time.monotonic()
            if abs(now - offset) > 1e-3 + error:
                print(f"LSL's clock has moved by {1e3 * (now - offset):.3f} ms", file=sys.stderr, flush=True)
                offset = now


def main() -> int:
    """Listen and serve."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--listen", type=address, required=True, help="telemetry.address of the site file")
    arguments = parser.parse_args()
    try:
        source = Source(arguments.listen)
    except OSError as error:
        print(f"--listen {arguments.listen}: {error}", file=sys.stderr)
        return 2

    def open_outlets(stream: Stream) -> LslOutlets:
        print(f"{stream.name}: {stream.rate:g} Hz", flush=True)
        return LslOutlets(stream, socket.gethostname())

    try:
        serve(source, Bridge(open_outlets))
    finally:
        source.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
