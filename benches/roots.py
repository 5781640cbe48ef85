"""Row 3: the rightmost characteristic root, and whether none was missed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from case import HMAN, REFERENCE_DELAY, REFERENCE_STIFFNESS, Case, main_case
from harness import Effort, Row, attempt
from reference import refined_root, unstable_roots
from rustside import RustSide

import telespring as ts

RIGHTMOST = "rightmost root, axis x, 2 K_xy, 0.167 s"
# multiples of K_xy and of the reference delay at which roots are unstable
HARD = ((2.0, 2.0), (4.0, 1.0), (2.0, 12.0), (4.0, 60.0))


def rows(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    case = main_case()
    dyad = ts.hman()
    start = ts.characteristic_roots(dyad, case.k, case.delay, 1)[0]
    truth = refined_root(case, start)
    hard = [Case(*HMAN["x"], f * REFERENCE_STIFFNESS, d * REFERENCE_DELAY) for f, d in HARD]
    hard = hard[:1] if effort.quick else hard
    unstable = [unstable_roots(each) for each in hard]

    def missed(solver: Callable[[Case], Any], among: int = len(HARD)) -> str:
        """How many of the unstable roots of the hard cases it did not find."""
        counts = []
        for each, expected in list(zip(hard, unstable, strict=True))[:among]:
            found = np.unique(np.round(np.asarray(solver(each)), 7))
            # a root and its conjugate, of which some give the upper one only
            upper = found[(found.real > 1e-6) & (found.imag >= 0)]
            number = int(np.sum(np.where(upper.imag > 1e-6, 2, 1)))
            counts.append(
                f"{expected - number:+d}/{expected}"
                if number > expected
                else f"{expected - number}/{expected}"
            )
        return "missed unstable roots: " + ", ".join(counts)

    def error_of(found: Any) -> float:
        found = np.asarray(found)
        rightmost = found[np.argmin(np.abs(found - truth))]
        return float(abs(rightmost - truth) / abs(truth))

    def ours(each: Case) -> Any:
        spectrum = ts.certified_roots(dyad, each.k, each.delay, unstable_roots(each) + 8)
        if not spectrum.complete:
            raise RuntimeError(spectrum.certificate)
        return spectrum.roots

    if rust is not None:
        pairs = rust.values["roots/found"]
        yield Row(
            RIGHTMOST,
            "ours: Rust abscissa with certificate",
            rust.timing("roots/abscissa"),
            error_of([complex(*pair) for pair in pairs]),
            ours=True,
            base=True,
            target_seconds=0.1e-3,
            target_error=1e-12,
            note=f"certificate {rust.values['roots/certificate']}; {missed(ours)}",
        )
        yield Row(
            RIGHTMOST, "ours: Rust, eight roots with certificate", rust.timing("roots/eight"), ours=True
        )
    timing = effort.time(lambda: ts.spectral_abscissa(dyad, case.k, case.delay), 0.5)
    yield Row(RIGHTMOST, "ours: Python spectral_abscissa", timing, error_of([start]), ours=True)

    def by_tdcpy() -> Iterator[Row]:
        from peers import tdcpy

        found = tdcpy.roots(case, -1.0)
        timing = effort.time(lambda: tdcpy.roots(case, -1.0))
        note = "right of -1/s; " + missed(lambda each: tdcpy.roots(each, -0.01))
        yield Row(RIGHTMOST, "tdcpy", timing, error_of(found), note=note)

    def by_qpmr() -> Iterator[Row]:
        from peers import qpmr

        region = (-1.0, 20.0, 0.0, 60.0)
        found = qpmr.roots(case, region, e=1e-12)
        timing = effort.time(lambda: qpmr.roots(case, region, e=1e-12))
        note = "region (-1, 20, 0, 60), e 1e-12; " + missed(lambda each: qpmr.roots(each, region, e=1e-12), 3)
        yield Row(RIGHTMOST, "qpmr, region given", timing, error_of(found), note=note)

    def by_qpmr_defaults() -> Iterator[Row]:
        from peers import qpmr

        spent, found = effort.once(lambda: qpmr.roots(case))
        error = error_of(found)
        note = "run once; "
        if error > 1e-3:
            note += f"misses the rightmost root {truth:.4f}; "
        note += missed(qpmr.roots, 1)
        yield Row(RIGHTMOST, "qpmr, defaults", spent, error, note=note)

    yield from attempt(RIGHTMOST, "tdcpy", by_tdcpy)
    yield from attempt(RIGHTMOST, "qpmr, region given", by_qpmr)
    if not effort.quick:
        yield from attempt(RIGHTMOST, "qpmr, defaults", by_qpmr_defaults)
