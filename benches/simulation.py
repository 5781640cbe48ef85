"""Rows 1 and 2: one simulation of 10 s, and the 32 of the paper's Fig. 5."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from case import HMAN, REFERENCE_DELAY, REFERENCE_STIFFNESS, figure_5, main_case
from harness import Effort, Row, Timing, attempt, relative_error
from reference import trajectories
from rustside import RustSide

import telespring as ts

ONE = "one 10 s simulation, axis x, 2 K_xy, 0.167 s, 1 kHz"
GRID = "Fig. 5: 32 simulations of 10 s"


def rows(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    yield from one_simulation(effort, rust)
    yield from grid(effort, rust)


def one_simulation(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    case = main_case(0.5 if effort.quick else 10.0)
    (truth,) = trajectories([case])
    (again,) = trajectories([case], refine=2)
    doubt = max(relative_error(again, truth), float(np.finfo(np.float64).eps))
    yield Row(ONE, "the truth: matrix exponentials, extended precision", error=doubt, note="its own error")

    if rust is not None:
        full = main_case()
        (positions,) = trajectories([full])
        yield Row(
            ONE,
            "ours: Rust, positions",
            rust.timing("simulation"),
            relative_error(rust.positions("simulation"), positions),
            ours=True,
            base=True,
            target_seconds=0.06e-3,
            target_error=1e-11,
        )
        yield Row(
            ONE,
            "ours: Rust, positions and velocities",
            rust.timing("simulation/velocities"),
            relative_error(rust.positions("simulation"), positions),
            ours=True,
            target_seconds=0.09e-3,
            target_error=1e-11,
            note="error of the positions",
        )
        for label, key, delay in (
            ("10 ms", "10ms", 1e-2),
            ("1 ms", "1ms", 1e-3),
            ("0.1 ms", "100us", 1e-4),
            ("1 ns", "1ns", 1e-9),
        ):
            error = None
            if delay >= 1e-4:
                case_here = type(full)(*HMAN["x"], full.k, delay)
                (there,) = trajectories([case_here])
                error = relative_error(rust.positions(f"simulation-{key}"), there)
            yield Row(
                ONE,
                f"ours: Rust, delay {label}",
                rust.timing(f"simulation/{key}"),
                error,
                ours=True,
                note="its cost",
            )

    dyad, push = ts.hman(), [[1.0, 0.0], [-1.0, 0.0]]
    # one axis alone
    one = ts.Dyad(
        ts.Robot(mass=[case.m1], damping=[case.b1], axes=("x",)),
        ts.Robot(mass=[case.m2], damping=[case.b2], axes=("x",)),
    )

    def bare(velocities: bool = False) -> ts.Trajectory:
        return ts.simulate_array(
            one, case.k, case.delay, [[1.0], [-1.0]], case.duration, velocities=velocities
        )

    python = bare().position[:, :, 0].T
    error = relative_error(python, truth)
    yield Row(ONE, "ours: Python simulate_array, positions", effort.time(bare), error, ours=True)
    both = effort.time(lambda: bare(velocities=True))
    yield Row(ONE, "ours: Python simulate_array, and velocities", both, error, ours=True)
    labelled = effort.time(lambda: ts.simulate(dyad, case.k, case.delay, push, case.duration))
    yield Row(ONE, "ours: Python simulate, both axes, xarray", labelled, error, ours=True)

    def by_numba() -> Iterator[Row]:
        from peers import numba_rk4

        spent, call = effort.once(lambda: numba_rk4.simulation(case))
        error = relative_error(call(), truth)
        note = f"step 1 ms, which divides the delay; compiled for this CPU in {spent.median:.1f} s"
        yield Row(ONE, "numba RK4", effort.time(call), error, note=note)

    def by_rust(name: str, note: str) -> Iterator[Row]:
        if rust is None:
            return
        timing = rust.timing(f"differential-equations/{name}")
        error = relative_error(rust.positions(f"differential-equations-{name}"), positions)
        yield Row(ONE, f"Rust differential-equations {name}", timing, error, note=note)

    def by_jitcdde() -> Iterator[Row]:
        from peers import jitcdde

        compiled, equations = effort.once(lambda: jitcdde.build(case))
        for label, tolerances in (("defaults", {}), ("rtol 1e-8", {"rtol": 1e-8, "atol": 1e-11})):
            call = jitcdde.integrate(equations, case, **tolerances)
            error = relative_error(call(), truth)
            note = f"compiled in {compiled.median:.1f} s, not counted"
            yield Row(ONE, f"jitcdde, {label}", effort.time(call), error, note=note)

    def by_scipy() -> Iterator[Row]:
        from peers import scipy_steps

        for label, rtol, longest in (
            ("rtol 1e-6", 1e-6, math.inf),
            ("rtol 1e-13, steps of 20 ms", 1e-13, 0.02),
        ):
            call = scipy_steps.simulation(case, rtol, longest)
            error = relative_error(call(), truth)
            yield Row(ONE, f"scipy DOP853 by steps, {label}", effort.time(call), error)

    def by_ddeint() -> Iterator[Row]:
        from peers import ddeint

        spent, found = effort.once(ddeint.simulation(case))
        yield Row(ONE, "ddeint", spent, relative_error(found, truth), note="run once")

    yield from attempt(ONE, "numba RK4", by_numba)
    for name, note in (
        ("rkv878e", "as its example does it"),
        ("dopri5", "rtol 1e-6"),
        ("dop853", "rtol 1e-9"),
        ("dop853-fine", "rtol 1e-12, steps of 20 ms"),
    ):
        yield from attempt(ONE, f"Rust differential-equations {name}", lambda n=name, w=note: by_rust(n, w))
    yield from attempt(ONE, "jitcdde", by_jitcdde)
    yield from attempt(ONE, "scipy DOP853 by steps", by_scipy)
    yield from attempt(ONE, "ddeint", by_ddeint)


def grid(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    cases = figure_5(0.5 if effort.quick else 10.0)
    truth = trajectories(cases)

    if rust is not None:
        full = figure_5()
        found = np.fromfile(rust.directory / "grid.f64", dtype="<f8").reshape(32, 2, -1)
        expected = truth if not effort.quick else trajectories(full)
        error = max(relative_error(x, y) for x, y in zip(found, expected, strict=True))
        yield Row(
            GRID,
            "ours: Rust, one core",
            rust.timing("grid"),
            error,
            ours=True,
            base=True,
            target_seconds=2e-3,
            target_error=1e-11,
        )

    robots = ts.hman()

    def ours() -> None:
        # simulate_array does both axes of a dyad at once
        for factor in (0.5, 1.0, 2.0, 4.0):
            for part in (0.0, 0.5, 1.0, 2.0):
                ts.simulate_array(
                    robots,
                    factor * REFERENCE_STIFFNESS,
                    part * REFERENCE_DELAY,
                    [[1.0, 1.0], [-1.0, -1.0]],
                    cases[0].duration,
                    velocities=False,
                )

    yield Row(GRID, "ours: Python simulate_array", effort.time(ours), ours=True)

    def by_numba() -> Iterator[Row]:
        from peers import numba_rk4

        calls = [numba_rk4.simulation(case) for case in cases]
        error = max(relative_error(call(), y) for call, y in zip(calls, truth, strict=True))

        def everything() -> None:
            for call in calls:
                call()

        yield Row(GRID, "numba RK4", effort.time(everything), error)

    yield from attempt(GRID, "numba RK4", by_numba)


def scaled_grid(single: list[Row]) -> Iterator[Row]:
    """Peers too slow to run 32 times: 32 times their single simulation, and labelled so."""
    for name in ("jitcdde, defaults", "ddeint"):
        for row in single:
            if row.name == name and isinstance(row.timing, Timing):
                note = "32 times the single simulation, not run"
                yield Row(GRID, name, row.timing.scaled(32), row.error, note=note)
