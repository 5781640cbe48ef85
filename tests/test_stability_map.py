"""The map of stability: it shows what `decide` answers, at the condition and everywhere else."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet

import telespring as ts
from one_period_map import radius
from questions import MINE, flat, one_axis, run
from telespring.paper.scene import Scene
from telespring.paper.sections.map.section import find_map
from telespring.show import figures

#: The seed of `make verify`.
DRAWN = int(os.environ.get("TELESPRING_VERIFY", "1"))
STABLE = "#CFE8DF"


@pytest.fixture(autouse=True)
def _closed_figures() -> Iterator[None]:
    yield
    plt.close("all")


def is_shaded(axes: Axes, stiffness: float, delay: float) -> bool:
    """Return whether a point, N/m and s, lies strictly in what is shaded as stable: by counting crossings."""
    inside = False
    x, y = stiffness, 1e3 * delay
    for each in axes.collections:
        if not (isinstance(each, ContourSet) and each.filled):
            continue
        if mpl.colors.to_hex(tuple(np.asarray(each.get_facecolor())[0])).upper() != STABLE:
            continue
        for path in each.get_paths():
            for polygon in path.to_polygons(closed_only=True):
                corners = np.asarray(polygon, dtype=float)
                (x1, y1), (x2, y2) = corners[:-1].T, corners[1:].T
                crosses = (y1 > y) != (y2 > y)
                with np.errstate(divide="ignore", invalid="ignore"):
                    at = x1 + (y - y1) / (y2 - y1) * (x2 - x1)
                inside ^= bool(np.count_nonzero(crosses & (at > x)) % 2)
    return inside


def legend(axes: Axes) -> list[str]:
    shown = axes.get_legend()
    assert shown is not None
    return [text.get_text() for text in shown.get_texts()]


def drawn(random: np.random.Generator, *, over_ranges: bool) -> dict[str, Any]:
    """Draw a question near its limit: slow or fast controllers, jitter, hands, unequal ways, dampers."""
    axes = int(random.integers(1, 3))
    one, other = (
        ts.Robot(np.exp(random.uniform(-1.0, 1.4, axes)), np.exp(random.uniform(-0.5, 2.7, axes)))
        for _ in range(2)
    )
    hands = [ts.Operator(stiffness=np.exp(random.uniform(1.0, 6.0, axes))) for _ in range(4)]
    held = random.random() < 0.4
    damper = float(random.uniform(0.0, 4.0)) if random.random() < 0.2 else 0.0
    dyad = ts.Dyad(one, other, (hands[0], hands[1]) if held and not over_ranges else None, damper)
    ranges = None
    if over_ranges:
        soft, stiff = hands[:2], hands[2:]
        ends = [ts.Operator(stiffness=a.stiffness + b.stiffness) for a, b in zip(soft, stiff, strict=True)]
        ranges = ts.OperatorRange(soft[0], ends[0]), ts.OperatorRange(soft[1], ends[1])
    delay = float(np.exp(random.uniform(math.log(0.005), math.log(0.3))))
    ways = (delay, delay * float(random.choice([1.0, 1.0, random.uniform(0.2, 4.0)])))
    period = float(random.choice([0.0, 0.001, np.exp(random.uniform(math.log(0.002), math.log(0.04)))]))
    jitter = float(random.choice([0.0, 0.0, random.uniform(0.0, 0.5) * delay]))
    network = ts.Network(ways, jitter=jitter, sample_period=period)
    found = ts.decide(dyad, delay=network, operator_range=ranges, allow_unusual=True)
    limit = found.stiffness_limit
    near = limit if limit is not None and 0.0 < limit < 1e6 else 100.0
    return {
        "dyad": dyad,
        "network": network,
        "ranges": ranges,
        "stiffness": near * float(random.choice([random.uniform(0.9, 1.1), random.uniform(0.3, 3.0)])),
        "buffer": bool(random.random() < 0.5),
    }


def mistakes(cases: int, seed: int, *, over_ranges: bool = False) -> list[str]:
    """Compare the map with the answer at the condition of random questions."""
    random = np.random.default_rng(seed)
    found = []
    for number in range(cases):
        case = drawn(random, over_ranges=over_ranges)
        answer = ts.decide(
            case["dyad"],
            case["stiffness"],
            case["network"],
            operator_range=case["ranges"],
            playout_buffer=case["buffer"],
            allow_unusual=True,
        )
        status = answer.status
        mean = 0.5 * sum(case["network"].delay)
        axes = ts.plot.stability_map(
            case["dyad"],
            mark=(case["stiffness"], mean),
            operator_range=case["ranges"],
            network=case["network"],
            playout_buffer=case["buffer"],
            verdict=status,
            allow_unusual=True,
        )
        shaded = is_shaded(axes, case["stiffness"], mean)
        plt.close("all")
        assert case["stiffness"] < axes.get_xlim()[1]
        assert mean < 1e-3 * axes.get_ylim()[1]
        # A stable condition may be an island beyond the first limit of a range.
        is_wrong = shaded if status in {"unstable", "not proven"} else status == "stable" and not shaded
        if is_wrong and not (case["ranges"] is not None and not shaded):
            found.append(f"{number}: {status}, {case}")
    return found


def test_law_a_condition_lies_in_the_shade_as_it_is_judged() -> None:
    assert mistakes(25, DRAWN) == []


def test_law_a_condition_over_ranges_lies_in_the_shade_as_it_is_judged() -> None:
    assert mistakes(3, DRAWN, over_ranges=True) == []


@pytest.mark.verify
def test_law_many_conditions_lie_in_the_shade_as_they_are_judged() -> None:
    assert mistakes(1000, 7) == []
    assert mistakes(100, 8, over_ranges=True) == []


def test_cross_what_is_shaded_is_stable_by_the_one_period_matrix() -> None:
    random = np.random.default_rng(DRAWN)
    sides = ((1.2, 6.0, 0.0), (2.0, 9.0, 0.0))
    counted = {True: 0, False: 0}
    for period in (0.004, 0.02):
        axes = ts.plot.stability_map(
            one_axis(), mark=(140.0, 0.04), network=ts.Network(0.04, sample_period=period)
        )
        (_, widest), (_, longest) = axes.get_xlim(), axes.get_ylim()
        for k, delay in random.uniform(0.0, 1.0, (150, 2)) * (widest, 1e-3 * longest):
            ticks = math.ceil(delay / period - 1e-9)
            stable = radius(sides, k, 0.0, period, 0.0, (ticks, ticks)) < 1.0
            shaded = is_shaded(axes, k, delay)
            counted[shaded] += 1
            assert stable or not shaded, (period, k, delay)
            # Left out is at most what is between three neighbouring stiffnesses of 400.
            if stable and not shaded:
                assert radius(sides, k + widest / 200, 0.0, period, 0.0, (ticks, ticks)) >= 1.0
    assert min(counted.values()) > 30


def test_law_what_is_shaded_is_stable_if_the_hands_let_go() -> None:
    """Held by 50 N/m or more the condition is stable, free it is not."""
    held = ts.OperatorRange(ts.Operator(stiffness=50.0), ts.Operator(stiffness=300.0))
    network, ranges = ts.Network(0.3, sample_period=0.001), (held, held)
    mark = (50.0, 0.3)
    axes = ts.plot.stability_map(one_axis(), mark=mark, operator_range=ranges, network=network)
    assert is_shaded(axes, *mark)
    both = ts.plot.stability_map(
        one_axis(), mark=mark, operator_range=ranges, network=network, free=one_axis()
    )
    assert not is_shaded(both, *mark)
    assert is_shaded(both, 15.0, 0.3)
    legend = both.get_legend()
    assert legend is not None
    labels = [text.get_text() for text in legend.get_texts()]
    assert "free and held" in labels[0]
    assert "boundary of axis x, free handles" in labels
    answer = ts.decide(one_axis(), 50.0, network, operator_range=ranges)
    assert answer.decision is not None
    assert (answer.decision.status, answer.decision.worst_status) == ("stable", "unstable")


@pytest.mark.parametrize("period", [0.0, 0.005])
def test_cross_what_is_shaded_over_a_range_is_stable_for_every_operator(period: float) -> None:
    random = np.random.default_rng(DRAWN)
    held = ts.OperatorRange(ts.Operator(), ts.Operator(stiffness=300.0))
    axes = ts.plot.stability_map(
        one_axis(), operator_range=(held, held), network=ts.Network(0.0, sample_period=period)
    )
    # A continuous controller is one with a very short period, which rounds the delay up by up to one.
    short = period or 0.001
    widest, checked = axes.get_xlim()[1], 0
    for delay in random.uniform(0.02, 0.06, 12):
        inside = _edge(axes, widest, delay)
        assert inside > 0.0
        ticks = math.ceil(delay / short - 1e-9) if period else math.floor(delay / short)
        for springs in [(0.0, 0.0), *random.uniform(0.0, 300.0, (15, 2)).tolist()]:
            sides = ((1.2, 6.0, springs[0]), (2.0, 9.0, springs[1]))
            # Holding a sample for a period delays it by half of it more.
            late = ticks if period else ticks - 1
            assert radius(sides, inside, 0.0, short, 0.0, (late, late)) < 1.0
            checked += 1
    assert checked > 100


def _edge(axes: Axes, widest: float, delay: float) -> float:
    """Return the largest stiffness that is shaded at a delay, N/m."""
    steps = np.linspace(0.0, widest, 600)[1:]
    return max((k for k in steps.tolist() if is_shaded(axes, k, delay)), default=0.0)


def test_ref_slow_controllers_have_a_map_of_their_own(tmp_path: Path) -> None:
    # The answer at 140 N/m and 40 ms is UNSTABLE at 50 Hz; continuous controllers would be stable.
    network = ts.Network(0.04, sample_period=0.02)
    axes = ts.plot.stability_map(one_axis(), mark=(140.0, 0.04), network=network, verdict="unstable")
    assert not is_shaded(axes, 140.0, 0.04)
    assert is_shaded(ts.plot.stability_map(one_axis(), mark=(140.0, 0.04)), 140.0, 0.04)
    assert legend(axes)[0] == "stable at a constant delay, controllers sampled every 20 ms"
    assert "UNSTABLE" in [text.get_text() for text in axes.texts]
    written = tmp_path / "map.svg"
    shown = run(
        "decide", *MINE, "--ping", "80ms", "--sample-period", "20ms", "--stiffness", "140",
        "--figure", str(written),
    )  # fmt: skip
    assert shown.exit_code == 0, shown.output
    text = written.read_text()
    for words in ("UNSTABLE", "controllers sampled every 20 ms", "Robot 1: 1.2 kg, 6 N·s/m on x"):
        assert words in text


def test_ref_while_the_delay_varies_only_what_is_proven_is_shaded(tmp_path: Path) -> None:
    network = ts.Network(0.04, jitter=0.01, sample_period=0.001)
    axes = ts.plot.stability_map(one_axis(), mark=(157.0, 0.04), network=network, verdict="not proven")
    proven = ts.verdicts(one_axis(), 157.0, network).stiffness_allowed
    assert proven is not None
    column = axes.get_xlim()[1] / 400
    assert is_shaded(axes, proven.stiffness - 2.0 * column, 0.04)
    assert not is_shaded(axes, proven.stiffness, 0.04)
    assert not is_shaded(axes, 157.0, 0.04)
    assert legend(axes)[:2] == [
        "stable while the delay varies by up to 10 ms, controllers sampled every 1 ms",
        "stable only with a playout buffer, which makes the delay constant",
    ]
    assert axes.get_ylabel() == "Shortest one-way delay δ, ms"
    # With the buffer the map is that of a constant delay 10 ms longer.
    buffered = ts.plot.stability_map(
        one_axis(), mark=(157.0, 0.04), network=network, playout_buffer=True, verdict="stable"
    )
    assert is_shaded(buffered, 157.0, 0.04)
    limit = ts.delay_limit(one_axis(), 157.0, network).delay - 0.01
    assert is_shaded(buffered, 157.0, limit - 0.001)
    assert not is_shaded(buffered, 157.0, limit + 0.001)
    written = tmp_path / "map.svg"
    run(
        "decide", *MINE, "--ping", "80ms", "--ping-jitter", "10ms", "--stiffness", "150",
        "--grip", "50:300", "--figure", str(written),
    )  # fmt: skip
    text = written.read_text()
    assert "NOT PROVEN" in text
    assert "held by 50 to 300 N/m" in text
    assert "varies by up to 10 ms" in flat(text)


@pytest.mark.parametrize("stiffness", [20.0, 100.0, 190.0, 400.0])
def test_law_a_map_reaches_to_the_condition_and_its_limits(stiffness: float) -> None:
    dyad, network = one_axis(), ts.Network(0.04, sample_period=0.001)
    axes = ts.plot.stability_map(dyad, mark=(stiffness, 0.04), network=network)
    (_, widest), (_, longest) = axes.get_xlim(), axes.get_ylim()
    bound = ts.decide(dyad, stiffness, network).stiffness_limit
    assert bound is not None
    assert max(stiffness, bound) < widest < 2.0 * max(stiffness, bound)
    assert 40.0 < longest <= 1.25 * max(40.0, 6 * 40.0)
    only_delay = ts.plot.stability_map(dyad, mark=(None, 0.04), network=network)
    assert bound < only_delay.get_xlim()[1] < 2.0 * bound
    assert "this delay" in legend(only_delay)
    only_stiffness = ts.plot.stability_map(dyad, mark=(stiffness, None), network=network)
    limit = ts.delay_limit(dyad, stiffness, network).delay
    assert limit < 1e-3 * only_stiffness.get_ylim()[1]
    assert "this stiffness" in legend(only_stiffness)


def test_law_a_map_without_a_condition_shows_delays_of_networks() -> None:
    axes = ts.plot.stability_map(one_axis())
    assert axes.get_ylim()[1] == 250.0
    assert 150.0 < axes.get_xlim()[1] < 400.0
    assert axes.get_title("left") == "Robot 1: 1.2 kg, 6 N·s/m on x\nRobot 2: 2 kg, 9 N·s/m on x"


def test_law_a_longest_delay_stands_alone() -> None:
    with pytest.raises(ts.InvalidInput, match="the network says by how much"):
        ts.plot.stability_map(one_axis(), mark=(150.0, 0.04, 0.05), network=ts.Network(0.04))


OWN = """
[robot1]
mass = 1.2
damping = 6.0
[robot2]
mass = 2.0
damping = 9.0
[coupling]
stiffness = 140.0
[network]
delay = 0.04
[controller]
sample_period = 0.02
"""


def shown_in_report(study: ts.Study, monkeypatch: pytest.MonkeyPatch) -> tuple[dict[str, Any], str, Any]:
    """Return what the report's map is drawn from, its drawing, and its stiffnesses."""
    given: dict[str, Any] = {}
    draw = figures.tier_map

    def spy(shown: Any, **values: Any) -> Any:
        given.update(values, shown=shown)
        return draw(shown, **values)

    monkeypatch.setattr(figures, "tier_map", spy)
    found = find_map(Scene.of(study))
    return given, found.drawings["map"], given["shown"][0].stiffness


def test_cross_the_reports_map_shades_what_the_answer_calls_stable(monkeypatch: pytest.MonkeyPatch) -> None:
    given, drawing, stiffness = shown_in_report(ts.Study.from_toml(OWN), monkeypatch)
    sides = ((1.2, 6.0, 0.0), (2.0, 9.0, 0.0))
    assert np.interp(140.0, stiffness, given["judged"]) < 0.04
    for k in (30.0, 60.0, 100.0, 131.0, 140.0):
        limit = float(np.interp(k, stiffness, given["judged"]))
        first = next(n for n in range(1, 60) if radius(sides, k, 0.0, 0.02, 0.0, (n, n)) >= 1.0)
        assert limit == pytest.approx(0.02 * (first - 1))
    for words in ("UNSTABLE", "controllers sampled every 20 ms", "exact, continuous controllers"):
        assert words in drawing
    # The line for a varying delay is of the same controllers: at 40 ms not beyond what a constant one allows.
    allowed, delays = given["bounded"]
    assert np.interp(0.04, delays, allowed) < 132.0


@pytest.mark.parametrize("buffer", [False, True])
def test_law_no_unstable_study_is_shaded_in_the_report(
    monkeypatch: pytest.MonkeyPatch, *, buffer: bool
) -> None:
    random = np.random.default_rng(DRAWN)
    seen = set()
    for _ in range(12):
        study = ts.Study.from_toml(
            OWN,
            coupling={"stiffness": float(random.uniform(100.0, 220.0))},
            network={
                "delay": 0.04,
                "jitter": float(random.choice([0.0, 0.015])),
                "playout_buffer": buffer,
            },
            controller={"sample_period": float(random.choice([0.0, 0.001, 0.02]))},
        )
        given, drawing, stiffness = shown_in_report(study, monkeypatch)
        status = ts.decide(study).status
        seen.add(status)
        assert status is not None
        assert status.upper() in drawing
        if status == "unstable":
            assert np.interp(study.stiffness, stiffness, given["judged"]) < 0.04
    assert {"unstable", "stable"} <= seen
