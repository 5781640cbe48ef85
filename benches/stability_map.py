"""Row 5: a million points, each stable or not."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from case import HMAN
from harness import Effort, Row, attempt
from rustside import RustSide

import telespring as ts

MAP = "1e6-point stability map"


def rows(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    if rust is not None:
        for key, label, base in (
            ("map/grid", "ours: Rust stability_map, 1000 stiffnesses by 1000 delays", False),
            ("map/random/maximum-delay", "ours: Rust maximum_delay, 1e6 random dyads", True),
            ("map/random/all-intervals", "ours: Rust, all intervals, 1e6 random dyads", False),
        ):
            yield Row(MAP, label, rust.timing(key), ours=True, base=base, target_seconds=0.15)

    count = 1000 if effort.quick else 1_000_000
    generator = np.random.default_rng(3)
    mass, damping = generator.uniform(0.5, 2, (2, count)), generator.uniform(4, 15, (2, count))
    stiffness, delay = generator.uniform(10, 300, count), generator.uniform(0, 0.5, count)
    arrays = (mass[0], damping[0], mass[1], damping[1], stiffness)
    timing = effort.time(lambda: ts.maximum_delay(*arrays) > delay)
    note = "uses the machine's cores"
    yield Row(MAP, "ours: Python maximum_delay, 1e6 random dyads", timing, ours=True, note=note)

    def by_numpy() -> Iterator[Row]:
        from peers import numpy_roots

        part = min(count, 100_000)
        some = tuple(array[:part] for array in arrays)
        stable = numpy_roots.maximum_delays(*some) > delay[:part]
        differ = int(np.sum(stable != (ts.maximum_delay(*some) > delay[:part])))
        timing = effort.time(lambda: numpy_roots.maximum_delays(*some) > delay[:part])
        yield Row(
            MAP,
            "numpy batched eigvals, 1e6 random dyads",
            timing.scaled(1e6 / part),
            note=f"{part} points, scaled; {differ} of them differ from ours",
        )
        k, x = np.linspace(1, 300, 1000), [np.full(1000, value) for value in HMAN["x"]]
        delays = np.linspace(0, 0.5, 1000)
        timing = effort.time(lambda: numpy_roots.maximum_delays(*x, k)[:, None] > delays)
        yield Row(MAP, "numpy batched eigvals, 1000 by 1000", timing, note="eigvals once per stiffness")

    yield from attempt(MAP, "numpy batched eigvals", by_numpy)
