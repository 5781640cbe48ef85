"""Row 4: critical stiffness and maximum delay, one dyad at a time and in bulk."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import reference
from case import HMAN, REFERENCE_STIFFNESS
from harness import Effort, Row, attempt
from rustside import RustSide

import telespring as ts

EACH = "critical stiffness and maximum delay, each dyad"
VERDICTS = "verdicts on the H-MANs, and one critical stiffness"
SETS = {
    "two-decades": "masses and dampings over two decades",
    "hman-like": "like the H-MANs",
}


def rows(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    if rust is not None:
        for name, label in SETS.items():
            sample = rust.values[f"criteria/{name}/sample"][: 2 if effort.quick else 40]
            stiffness_error = _largest(reference.critical_stiffness(*row[:4]) / row[5] - 1 for row in sample)
            delay_error = _largest(_delay_error(row[:5], row[6]) for row in sample)
            each = rust.values[f"criteria/{name}/crossings-each"]
            for what, key, error, base in (
                ("maximum delay", "maximum-delay", delay_error, name == "hman-like"),
                (f"all crossings ({each:.2f} each) with delays", "crossings", delay_error, False),
                ("critical stiffness", "critical-stiffness", stiffness_error, False),
            ):
                yield Row(
                    EACH,
                    f"ours: Rust, {what}, {label}",
                    rust.timing(f"criteria/{name}/{key}"),
                    error,
                    ours=True,
                    base=base,
                    target_seconds=0.15e-6,
                    target_error=1e-12,
                )

    x = HMAN["x"]
    k = 2 * REFERENCE_STIFFNESS
    truth = reference.maximum_delay(*x, k)
    count = 1000 if effort.quick else 100_000
    stiffness = np.linspace(10.0, 300.0, count)
    bulk = effort.time(lambda: ts.maximum_delay(*x, stiffness)).scaled(1 / count)
    yield Row(EACH, "ours: Python maximum_delay, array", bulk, ours=True)
    single = effort.time(lambda: ts.maximum_delay(*x, k), 0.3)
    yield Row(EACH, "ours: Python maximum_delay, one call", single, ours=True)

    if rust is not None:
        yield Row(
            VERDICTS, "ours: Rust verdicts", rust.timing("criteria/hman/verdicts"), ours=True, base=True
        )
        yield Row(
            VERDICTS,
            "ours: Rust verdicts and remedies over all grips, sampled",
            rust.timing("criteria/hman/verdicts-over-grips"),
            ours=True,
            target_seconds=0.5,
        )
        yield Row(
            VERDICTS,
            "ours: Rust critical stiffness, axis x",
            rust.timing("criteria/hman/critical-stiffness"),
            ours=True,
        )
    dyad = ts.hman()
    error = _largest(
        tier.stiffness_bound / reference.critical_stiffness(*HMAN[axis.name]) - 1
        for axis in ts.verdicts(dyad, 71.2, 0.1).axes
        for tier in axis.tiers
        if tier.tier == "any constant delay" and tier.stiffness_bound is not None
    )
    verdicts = effort.time(lambda: ts.verdicts(dyad, 71.2, 0.1), 0.3)
    yield Row(VERDICTS, "ours: Python verdicts", verdicts, error, ours=True)
    single = effort.time(lambda: ts.critical_stiffness(*x), 0.3)
    error = ts.critical_stiffness(*x) / reference.critical_stiffness(*x) - 1
    yield Row(
        VERDICTS,
        "ours: Python critical_stiffness, one call",
        single,
        abs(error),
        ours=True,
        target_seconds=5e-6,
        target_error=1e-12,
    )

    def one(name: str, call: Callable[[], float], note: str) -> Row:
        error = abs(call() / truth - 1)
        return Row(EACH, name, effort.time(call), error, note=note)

    def by_numpy() -> Iterator[Row]:
        from peers import numpy_roots

        def both() -> float:
            numpy_roots.paper_critical_stiffness(*x)
            return numpy_roots.maximum_delay(*x, k)

        yield one("numpy.roots", both, "delay by roots of the cubic; stiffness by Eq. 5, which is not exact")

    def by_control() -> Iterator[Row]:
        from peers import control

        yield one("python-control stability_margins", lambda: control.maximum_delay(*x, k), "delay only")

    def by_yaltapy() -> Iterator[Row]:
        from peers import yaltapy

        note = "delay only, up to 0.2 s"
        yield one("yaltapy stability windows", lambda: yaltapy.maximum_delay(*x, k, 0.2), note)

    yield from attempt(EACH, "numpy.roots", by_numpy)
    yield from attempt(EACH, "python-control stability_margins", by_control)
    yield from attempt(EACH, "yaltapy stability windows", by_yaltapy)


def _largest(errors: Iterator[float]) -> float:
    return float(max(abs(error) for error in errors))


def _delay_error(dyad: list[float], found: float) -> float:
    truth = reference.maximum_delay(*dyad)
    # the program writes an infinite delay as the largest number
    if np.isinf(truth):
        return 0.0 if found > 1e300 else float("inf")
    return found / truth - 1
