"""The verdict of `stable_delays` against the spectral abscissa of `oracle_collocation`.

A disagreement is allowed only where moving the delay or the stiffness by a relative 1e-6 changes
our verdict: there both sides of a boundary are within what either computation may round to.

The large comparisons of `make verify` compare new dyads in every run: it draws a seed, prints it and
hands it over in TELESPRING_VERIFY.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Literal

import numpy as np
import pytest

import telespring as ts
from oracle_collocation import Axes, Floats, spectral_abscissa

Operators = Literal["free", "one grounded", "both grounded"]
Seed = tuple[int, ...]
DRAWN = int(os.environ.get("TELESPRING_VERIFY", "0"))
CLOSE = 1e-6  # relative, in delay and in stiffness

groups = pytest.mark.parametrize("damper", [False, True], ids=["no damper", "damper"])
holds = pytest.mark.parametrize("operators", ["free", "one grounded", "both grounded"])


def random_dyads(seed: Seed, count: int, operators: Operators, damper: bool) -> tuple[Axes, Floats, Floats]:
    """Return dyads, stiffnesses and delays: the space that the criteria must hold in."""
    random = np.random.default_rng([*seed, len(operators), damper])

    def log_uniform(low: float, high: float) -> Floats:
        return np.exp(random.uniform(np.log(low), np.log(high), count))

    m1, m2 = log_uniform(0.05, 5.0), log_uniform(0.05, 5.0)
    b1, b2 = log_uniform(1.0, 100.0), log_uniform(1.0, 100.0)
    paper = (b1**2 + b2**2) / (2 * (m1 + m2))
    k = random.uniform(0.2, 6.0, count) * paper
    delay = random.uniform(1e-3, 6.0, count) * np.sqrt(np.maximum(m1, m2) / k)
    kh1, kh2 = k * log_uniform(0.02, 20.0), k * log_uniform(0.02, 20.0)
    first = random.random(count) < 0.5
    if operators == "free":
        kh1, kh2 = np.zeros(count), np.zeros(count)
    elif operators == "one grounded":
        kh1, kh2 = np.where(first, kh1, 0.0), np.where(first, 0.0, kh2)
    c = np.sqrt(b1 * b2) * log_uniform(0.02, 2.0) if damper else np.zeros(count)
    return Axes(m1, b1, m2, b2, kh1, kh2, c), k, delay


def is_stable(axis: tuple[float, ...], k: float, delay: float) -> bool:
    m1, b1, m2, b2, kh1, kh2, c = axis
    stable = ts.stable_delays(m1, b1, m2, b2, k, 1.01 * delay, kh1=kh1, kh2=kh2, c=c)
    return any(start <= delay < end for start, end in stable)


def near_a_boundary(axis: tuple[float, ...], k: float, delay: float) -> bool:
    moved = [(k * (1 + x), delay * (1 + y)) for x, y in ((CLOSE, 0), (-CLOSE, 0), (0, CLOSE), (0, -CLOSE))]
    return len({is_stable(axis, *one) for one in [(k, delay), *moved]}) > 1


def columns(axes: Axes) -> Iterator[tuple[float, ...]]:
    return zip(*(column.tolist() for column in axes), strict=True)


def compare(axes: Axes, k: Floats, delay: Floats) -> tuple[int, int, int]:
    """Return how many agree, how many of them are stable, and how many are too near a boundary."""
    truth = spectral_abscissa(axes, k, delay)
    assert truth.resolved.all(), f"the oracle is unsure of {np.flatnonzero(~truth.resolved)}"
    agreed = stable = close = 0
    wrong = []
    for i, axis in enumerate(columns(axes)):
        at = (axis, float(k[i]), float(delay[i]))
        ours = is_stable(*at)
        if ours == bool(truth.abscissa[i] < 0):
            agreed += 1
            stable += ours
        elif near_a_boundary(*at):
            close += 1
        else:
            wrong.append((*at, ours, float(truth.abscissa[i])))
    assert not wrong, f"{len(wrong)} of {len(k)} disagree, the first: {wrong[0]}"
    return agreed, stable, close


def report(name: str, counts: tuple[int, int, int]) -> None:
    agreed, stable, close = counts
    print(f"{name}: {agreed} compared ({stable} stable), {close} skipped near a boundary")


@holds
@groups
def test_cross_two_thousand_dyads(operators: Operators, damper: bool) -> None:
    counts = compare(*random_dyads((1,), 334, operators, damper))
    report(f"{operators}, damper {damper}", counts)
    # both answers must occur, or the comparison says nothing
    assert min(counts[1], counts[0] - counts[1]) > 30
    assert counts[0] > 330


@pytest.mark.verify
@holds
@groups
def test_cross_a_hundred_thousand_dyads(operators: Operators, damper: bool) -> None:
    counts = compare(*random_dyads((2, DRAWN), 16_667, operators, damper))
    report(f"{operators}, damper {damper}", counts)
    assert counts[0] > 16_600


def both_sides(
    seed: Seed, count: int, operators: Operators, damper: bool, offset: float
) -> tuple[Axes, Floats, Floats]:
    """Return the points a relative `offset` before and behind every boundary up to the delay drawn."""
    axes, k, delay = random_dyads(seed, count, operators, damper)
    index, points = [], []
    for i, (m1, b1, m2, b2, kh1, kh2, c) in enumerate(columns(axes)):
        horizon = float(delay[i])
        stable = ts.stable_delays(m1, b1, m2, b2, float(k[i]), horizon, kh1=kh1, kh2=kh2, c=c)
        for boundary in (one for pair in stable for one in pair if 0 < one < horizon):
            index += [i, i]
            points += [boundary * (1 - offset), boundary * (1 + offset)]
    chosen = np.array(index, dtype=np.int64)
    return axes.at(chosen), k[chosen], np.array(points)


@holds
@groups
def test_cross_both_sides_of_every_boundary(operators: Operators, damper: bool) -> None:
    # 2e-6: just outside what may be skipped, so that a boundary wrong by more than that is seen
    counts = compare(*both_sides((3,), 160, operators, damper, 2 * CLOSE))
    report(f"{operators}, damper {damper}", counts)
    # each boundary has a stable and an unstable side; some are tangencies within reach of CLOSE
    assert counts[0] > 40
    assert abs(counts[0] - 2 * counts[1]) <= counts[2] + 2


@pytest.mark.verify
@holds
@groups
def test_cross_both_sides_of_many_boundaries(operators: Operators, damper: bool) -> None:
    counts = compare(*both_sides((4, DRAWN), 4000, operators, damper, 2 * CLOSE))
    report(f"{operators}, damper {damper}", counts)
