"""Figures for scripts: exact boundaries, whole legends, and wrong units refused."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet

import telespring as ts
from telespring.show import figures


@pytest.fixture(autouse=True)
def _closed_figures() -> Iterator[None]:
    yield
    plt.close("all")


def outline(axes: Axes) -> np.ndarray:
    """Return the vertices of the boundary, N/m and ms."""
    (lines,) = [each for each in axes.collections if isinstance(each, ContourSet) and not each.filled]
    return np.concatenate([path.vertices for path in lines.get_paths()])


def delay_limit_of_twins(mass: float, damping: float, stiffness: np.ndarray) -> np.ndarray:
    """Return the first one-way delay, s, at which two free robots that are alike become unstable.

    m s² + b s + k = −k exp(−sδ) at s = jω: the lengths give ω, the arguments δ.
    """
    frequency = np.sqrt(2.0 * stiffness * mass - damping**2) / mass
    argument = np.arctan2(damping * frequency, damping**2 / mass - stiffness)
    return (math.pi - argument) / frequency


def test_ref_the_boundary_passes_through_the_exact_limits() -> None:
    mass, damping = 1.2, 6.0
    axes = ts.plot.stability_map(ts.Dyad(ts.Robot(mass, damping), ts.Robot(mass, damping)), delay=0.4)
    k, at = outline(axes).T
    widest = axes.get_xlim()[1]
    columns = np.arange(1, 401) * widest / 400
    columns = columns[columns > damping**2 / (2 * mass)]
    exact = 1e3 * delay_limit_of_twins(mass, damping, columns)
    columns, exact = columns[exact < 400.0], exact[exact < 400.0]
    assert len(columns) > 200
    for each, limit in zip(columns, exact, strict=True):
        # a row of the map is 1 ms high
        assert np.abs(at[np.abs(k - each) < 1e-9 * widest] - limit).min() < 1e-6
    # between two columns the line is straight
    inside = k > damping**2 / (2 * mass) + 0.01 * widest
    assert np.abs(at - 1e3 * delay_limit_of_twins(mass, damping, k))[inside].max() < 1.0


def test_law_a_depth_is_the_distance_to_the_nearest_end_of_a_stable_interval() -> None:
    rng = np.random.default_rng(3)
    delay = np.linspace(0.0, 2.0, 57)
    for _ in range(50):
        ends = np.sort(rng.uniform(0.0, 2.4, 2 * int(rng.integers(0, 4))))
        if ends.size and rng.random() < 0.5:
            ends[0] = 0.0
        intervals = [(float(a), float(b)) for a, b in zip(ends[::2], ends[1::2], strict=True)]
        depth = figures.maps.stable_depth([figures.MapColumn(1.0, intervals)], delay)[:, 0]
        for at, found in zip(delay, depth, strict=True):
            is_inside = any(start <= at < end for start, end in intervals)
            away = min([abs(at - end) for end in ends if end > 0.0], default=figures.HORIZON * 2.0)
            assert found == pytest.approx(away if is_inside else -away, abs=1e-12)


def legend(axes: Axes) -> list[str]:
    shown = axes.get_legend()
    assert shown is not None
    return [text.get_text() for text in shown.get_texts()]


def test_law_the_bar_of_a_mark_is_in_the_legend() -> None:
    bar = "this condition, up to its longest delay"
    dyad = ts.hman()
    assert bar in legend(ts.plot.stability_map(dyad, mark=(71.2, 0.08, 0.1)))
    assert bar not in legend(ts.plot.stability_map(dyad, mark=(71.2, 0.08)))
    stiffness = np.linspace(1.0, 100.0, 120)
    drawn = figures.tier_map(
        [figures.MapAxis("x", stiffness, 5.0 / stiffness, None)],
        any_network=15.0,
        any_constant=30.0,
        bounded=None,
        conditions=[],
        extent=(100.0, 0.4),
        mark=figures.StudyMark(50.0, 0.08, 0.1),
    )
    words = [text.get_text() for text in drawn.legends[0].get_texts()]
    assert words[-2:] == ["this study", "this study, up to its longest delay"]


@pytest.mark.parametrize(
    ("mark", "field", "words"),
    [
        ((71.2, 80.0), "mark[1]", "Did you mean 80 ms? Write 0.08. If it is meant, pass allow_unusual=True."),
        ((71.2, 0.08, 95.0), "mark[2]", "Did you mean 95 ms? Write 0.095."),
        ((0.0712, 0.08), "mark[0]", "Did you mean 0.0712 N/mm? Write 71.2."),
        ((71.2, 0.08, 0.05), "mark", "Write the shorter delay first."),
        ((71.2,), "mark", "Write mark=(71.2, 0.08)."),
        ((71.2, math.nan), "mark[1]", "Correct it."),
    ],
)
def test_law_a_mark_in_another_unit_is_refused(mark: tuple[float, ...], field: str, words: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        ts.plot.stability_map(ts.hman(), mark=mark)  # type: ignore[arg-type]  # what users may pass
    assert refused.value.field == field
    assert words in refused.value.remedy


def test_law_all_figures_of_a_condition_refuse_milliseconds_unless_meant() -> None:
    dyad = ts.hman()
    for draw in (ts.plot.nyquist, ts.plot.frequency_response):
        with pytest.raises(ts.InvalidInput, match="Did you mean 80 ms"):
            draw(dyad, 71.2, 80.0)
    with pytest.raises(ts.InvalidInput, match="if 300 was meant in ms, write 0\\.3"):
        ts.plot.stability_map(dyad, delay=300.0)
    assert ts.plot.stability_map(dyad, mark=(71.2, 3.0), allow_unusual=True).get_ylim()[1] > 3e3
