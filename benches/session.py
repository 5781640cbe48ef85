"""One tick of one side of a live coupling at 1 kHz, over 84 ms each way."""

from __future__ import annotations

from collections.abc import Iterator

from harness import Effort, Row
from rustside import RustSide

TICK = "one tick of one side: measurement, packet out, packet in, force"
LABELS = {
    "fixed": "fixed delay, shared clock",
    "adaptive": "adaptive delay, estimated clock",
}


def rows(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    del effort  # measured by the Rust program
    if rust is None:
        return
    for name, label in LABELS.items():
        if not rust.values[f"session/{name}/engaged"]:
            raise RuntimeError(f"the coupling was not engaged: {label}")
        timing = rust.timing(f"session/{name}")
        yield Row(TICK, f"ours: Rust, {label}", timing, ours=True, base=name == "fixed", target_seconds=1e-6)
