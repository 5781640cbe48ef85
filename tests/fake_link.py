"""A stand-in for the live program that speaks its console: status, events, summary; orders and signals.

It runs as a program, so it imports nothing of the package. Its first argument that is no option names what it
does beside that; `$FAKE_LINK` gives its version and how it behaves, as JSON.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import time
from pathlib import Path

BEHAVIOUR = json.loads(os.environ.get("FAKE_LINK", "{}"))
LEAVES: list[int] = []


def say(kind: str, **content: object) -> None:
    print(json.dumps({"type": kind, **content}), flush=True)


def status(side: int, at: float) -> None:
    say(
        "status",
        side=side,
        time=at,
        phase="running",
        watchdog="engaged",
        watchdog_cause=None,
        round_trip=0.1213,
        age=0.0712,
        loss=0.021,
        lateness={"median": 1e-5, "quantile_99": 9e-5, "largest": 2e-4},
        overruns=0,
        latency={"device": 0.0, "loop": 1e-4, "network": 0.0601, "playout": 0.0111},
        force=1.234,
        stiffness=142.0,
        stiffness_in_use=101.0,
        limited_share=0.125,
        limits=["strategy"],
        balance=0.0123,
        te=0.0141,
    )


def summary(side: int, cause: str) -> dict[str, object]:
    return {
        "schema": 1,
        "side": side,
        "state": "ended",
        "cause": cause,
        "seconds": 20.0,
        "coupled_share": 0.9,
        "round_trip": {"latest": 0.12 + 0.001 * side, "smallest": 0.119, "clock_error": 0.06},
        "age": {"mean": 0.07 + 0.001 * side, "quantile_99": 0.09},
        "loss": {"share": 0.01 * side},
        "lateness": {"quantile_99": 1e-4 * side, "overruns": 0},
        "limited_share": 0.25,
        "energy": {"least_balance": 0.0},
        "largest_force": 4.5,
        "te": 0.014,
        "real_time": {"priority": "granted", "locked_memory": "granted", "awake": "granted"},
        "events": [
            {"time": 0.1 * side, "event": "running"},
            {"time": 20.0, "event": "ended", "cause": cause},
        ],
        "recording": {"path": f"out/side-{side}.mcap", "status": "complete"},
    }


def leave(*_: object) -> None:
    LEAVES.append(1)


def check() -> int:
    items = [
        {"item": "loop", "verdict": "ok", "found": "5000 ticks"},
        {"item": "device", "verdict": BEHAVIOUR["device"], "found": "no row came", "remedy": "Start it."},
    ]
    verdict = BEHAVIOUR["device"]
    print(json.dumps({"schema": 1, "side": 2, "verdict": verdict, "items": items, "lateness": None}))
    return int(verdict == "failed")


def live(*, is_demo: bool) -> int:
    sides = (1, 2) if is_demo else (1,)
    is_stuck = BEHAVIOUR.get("stuck", False)
    signal.signal(signal.SIGINT, leave)
    begun, seconds = time.monotonic(), float(BEHAVIOUR.get("seconds", 0.3))
    for line in BEHAVIOUR.get("says", []):
        print(line, flush=True)
    for side in sides:
        say("event", side=side, time=0.1 * side, event="force-ramping-out", cause="silence")
    cause, is_open = "stop-requested", True
    time.sleep(float(BEHAVIOUR.get("deaf", 0.0)))
    text = ""
    while is_stuck or (not LEAVES and time.monotonic() - begun < seconds):
        for side in sides:
            status(side, time.monotonic() - begun)
        ready, _, _ = select.select([0] if is_open else [], [], [], 0.02)
        if ready:
            text += os.read(0, 4096).decode() or "\x04"
            is_open = "\x04" not in text
            if not is_open:
                cause = "operator-gone"
                break
            *orders, text = text.split("\n")
            for order in orders:
                say("event", side=1, time=1.0, event=f"order-{order}")
    if "note" in BEHAVIOUR:
        Path(BEHAVIOUR["note"]).write_text(f"{cause} {len(LEAVES)}\n")
    sites = [summary(side, cause) for side in sides]
    if is_demo:
        say("summary", schema=1, study="", sites=sites)
    else:
        say("summary", **sites[0])
    return int(BEHAVIOUR.get("status", 0))


def main() -> int:
    if sys.argv[1:] == ["--version"]:
        print(f"telespring-link {BEHAVIOUR['version']}")
        return 0
    if "refuses" in BEHAVIOUR:
        print(BEHAVIOUR["refuses"], file=sys.stderr)
        return 2
    if "arguments" in BEHAVIOUR:
        Path(BEHAVIOUR["arguments"]).write_text(json.dumps(sys.argv[1:]))
    return check() if sys.argv[1] == "check" else live(is_demo=sys.argv[1] == "demo")


if __name__ == "__main__":
    sys.exit(main())
