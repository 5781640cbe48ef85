"""What is seen of a comparison, on the screen, in figures and in the report, is what was measured."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from rich.console import Console

from made_comparison import LABELS, made_account_trial, made_comparison
from telespring.comparison import LeftOut
from telespring.comparison.recommendation import recommend
from telespring.comparison.results import Comparison
from telespring.paper import Analysis
from telespring.show.drawings.comparison import (
    COMPARISON_FIGURES,
    draw_account,
    draw_comparison,
    draw_delays,
    draw_plane,
)
from telespring.show.screens.comparison import comparison_screen
from telespring.show.strategies import name_strategy


def screen(data: xr.Dataset, width: int = 100, left_out: tuple[LeftOut, ...] = ()) -> list[str]:
    comparison = Comparison(data, recommend(data), left_out, Path("nowhere"))
    console = Console(width=width, record=True, file=io.StringIO())
    comparison_screen(console, comparison)
    return console.export_text().splitlines()


@pytest.mark.parametrize(
    "data",
    [
        made_comparison(),
        made_comparison(delays=np.linspace(0.0, 0.35, 12).tolist()),
        made_comparison(LABELS, (142.5,), (0.084,), networks=("5G urban", "5G walking", "fixed line")),
        made_comparison(("spring",), (142.5,), (0.084, 0.334)),
    ],
    ids=["usual", "many delays", "networks", "nothing safe"],
)
@pytest.mark.parametrize("width", [80, 100])
def test_law_a_screen_has_thirty_lines_and_begins_with_the_answer(data: xr.Dataset, width: int) -> None:
    lines = screen(data, width)
    assert len(lines) <= 30
    assert lines[0] == data.attrs["name"]
    assert lines[1].startswith(("RECOMMENDED: ", "NOTHING THAT WAS COMPARED IS SAFE"))
    assert "…" not in "".join(lines)


def test_law_a_screen_shows_the_means_of_both_at_each_delay() -> None:
    data = made_comparison()
    best = recommend(data).candidate
    assert best is not None
    here = data.isel(condition=np.flatnonzero(data.stiffness.values == best.stiffness), network=0)
    text = "\n".join(screen(data))
    for label in LABELS:
        row = next(
            line for line in text.splitlines() if re.match(rf"{re.escape(name_strategy(label))} +\d", line)
        )
        means = 1e3 * here.tracking_error.sel(architecture=label).mean("trial").values
        assert [float(number) for number in re.findall(r"\d+\.\d", row)[: means.size]] == pytest.approx(
            means.ravel().tolist(), abs=0.0501
        )


def test_law_a_screen_names_what_ran_away_and_how_often() -> None:
    data = made_comparison()
    data.diverged[0, 0, -1, 0] = False
    lines = screen(data, 120)
    assert lines[lines.index("Ran away:") + 1] == (
        "  bare spring: 142.5 N/m, 84 ms (4 of 4); 142.5 N/m, 334 ms (3 of 4)"
    )
    calm = made_comparison(LABELS[2:5])
    assert "No trial ran away." in screen(calm)


def test_law_a_screen_says_first_that_working_alone_is_better() -> None:
    data = made_comparison()
    best = recommend(data).candidate
    assert best is not None
    data["tracking_error_unconnected"] = 0.5 * data.tracking_error_unconnected
    lines = screen(data, 120)
    assert lines[1] == "WORKING ALONE IS BETTER than every coupling that is safe."
    choice = f"{name_strategy(best.architecture)} at {best.stiffness:.4g} N/m"
    more = 1e3 * (best.mean_tracking_error - float(data.tracking_error_unconnected.mean()))
    assert re.match(rf"  The best of them is {re.escape(choice)}: {more:.2f} ± \d\.\d\d mm more", lines[2])
    assert "RECOMMENDED" not in "".join(lines)


@pytest.mark.parametrize(("lack", "words"), [("weaker damper", "damper too strong"), ("", "ran away")])
def test_law_a_screen_says_what_a_strategy_lacks(lack: str, words: str) -> None:
    data = made_comparison()
    here = {"architecture": "wave-variables"}
    data["grounds"].loc[here] = "" if lack else "honest partner"
    data["lack"].loc[here] = lack
    data["diverged"].loc[here] = not lack
    row = next(line for line in screen(data, 130) if line.startswith("wave variables"))
    assert f"none: {words}" in row


def test_law_what_is_left_out_has_its_field_and_remedy() -> None:
    out = [
        LeftOut(name, "session.strategy", f'"{name}"', f"{name} has no place for it", "Remove it.")
        for name in ("wave-variables", "injected-damping")
    ]
    out.append(LeftOut("two-layer", "session.level", "-1", "must be from 0", "Take 0.05."))
    text = " ".join(line.strip() for line in screen(made_comparison(), 200, tuple(out)))
    assert "Left out: wave variables, damping injection. session.strategy: Remove it." in text
    assert "Left out: two layers. session.level = -1: must be from 0. Take 0.05." in text


def heights(line: Line2D) -> NDArray[np.float64]:
    return np.asarray(line.get_ydata(), dtype=float)


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_law_the_figure_against_delay_shows_every_mean_or_says_it_above_the_scale() -> None:
    data = made_comparison()
    figure = draw_delays(data)
    one = [axes for axes in figure.axes if axes.get_visible()]
    assert len(one) == 8
    for column, stiffness in enumerate(np.unique(data.stiffness.values)):
        here = data.isel(condition=np.flatnonzero(data.stiffness.values == stiffness), network=0)
        for person in (0, 1):
            axes = one[4 * person + column]
            drawn = {tuple(np.round(heights(line), 6)) for line in axes.lines}
            for label in LABELS:
                errors = 1e3 * here.tracking_error.sel(architecture=label).isel(robot=person)
                assert tuple(np.round(errors.mean("trial").values, 6)) in drawn
            above = [text.get_text() for text in axes.texts]
            edges = [heights(line)[0] for line in axes.lines if line.get_linewidth() == 0.4]
            limit = edges[0] if edges else None
            far = 1e3 * here.tracking_error.isel(robot=person).mean("trial").values
            assert (limit is None) == (stiffness < 100.0)
            if limit is not None:
                # both springs at 84 and 334 ms, with the means of the completed trials
                assert sorted(float(text.split()[1]) for text in above) == sorted(np.round(far[far > limit]))
                assert all(text.startswith("✕ ") for text in above)


def test_law_a_trial_that_ended_early_is_not_drawn_as_nothing() -> None:
    data = made_comparison(("spring", "guard"), (142.5,), (0.0, 0.084))
    data.status[1, 0, 1, :3] = 2
    data.tracking_error[1, 0, 1, :3] = np.nan
    assert "† 3/4" in texts(draw_delays(data))
    assert any(text.endswith(", 3/4") for text in texts(draw_plane(data, ("spring", "guard"))))


def test_law_a_strategy_without_any_error_leaves_the_panels_their_width() -> None:
    data = made_comparison(("spring", "guard"), (142.5,), (0.0, 0.084))
    data.status[0, 0] = 1
    data.tracking_error[0, 0] = np.nan
    figure = draw_delays(data)
    figure.draw_without_rendering()
    assert all(axes.get_position().width > 0.8 for axes in figure.axes)


def test_law_the_plane_shows_the_larger_of_both_costs() -> None:
    data = made_comparison()
    figure = draw_plane(data, ("guard + shared-target",))
    means = data.tracking_error.isel(network=0).mean("trial")
    expected = []
    for i, stiffness in enumerate(data.stiffness.values):
        first = int(np.flatnonzero((data.stiffness.values == stiffness) & (data.delay.values == 0.0))[0])
        undelayed = means.sel(architecture="spring").isel(condition=first)
        ratio = float((means.sel(architecture="guard + shared-target").isel(condition=i) / undelayed).max())
        expected.append(f"{ratio:.2f}")
    assert texts(figure) == expected


def test_law_without_an_undelayed_condition_the_plane_relates_to_working_alone() -> None:
    data = made_comparison(delays=(0.0836, 0.1672))
    figure = draw_plane(data, ("guard + shared-target",))
    means = data.tracking_error.isel(network=0).sel(architecture="guard + shared-target").mean("trial")
    ratios = (means / data.tracking_error_unconnected.mean("trial")).max("robot")
    assert texts(figure) == [f"{ratio:.2f}" for ratio in ratios.values]
    [legend] = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    assert "error up to 1.1 × that without a partner" in words
    assert not any("undelayed" in word for word in words)


@pytest.mark.parametrize(("factor", "role"), [(1.0, "recommended: "), (0.5, "best safe coupling: ")])
def test_law_the_account_is_that_of_the_recommended_stiffness(factor: float, role: str) -> None:
    data = made_comparison()
    data["tracking_error_unconnected"] = factor * data.tracking_error_unconnected
    found = recommend(data)
    assert found.candidate is not None
    figure = dict(draw_comparison(data, found))["account.png"]
    title = figure.axes[0].get_title(loc="left")
    assert title.startswith(
        f"{role}{name_strategy(found.candidate.architecture)}, {found.candidate.stiffness:.4g} N/m, "
    )


def test_law_the_account_is_shaded_exactly_where_it_limits() -> None:
    trial = made_account_trial()
    figure = draw_account(trial)
    energy = (trial.coupling_force**2).sum("axis") / (2.0 * 142.5)
    limited = (energy >= 0.97 * trial.account).values
    for robot in (0, 1):
        for axes in figure.axes[2 * robot : 2 * robot + 2]:
            shaded = np.zeros(len(trial.time), dtype=bool)
            for patch in axes.patches:
                left = patch.get_x()  # type: ignore[attr-defined]
                right = left + patch.get_width()  # type: ignore[attr-defined]
                shaded |= (trial.time.values >= left) & (trial.time.values <= right)
            assert (shaded == limited[:, robot]).all()
    assert 0.05 < limited.mean() < 0.95


def test_law_all_figures_of_a_comparison_are_drawn_if_there_is_something_to_draw() -> None:
    data = made_comparison()
    assert [name for name, _ in draw_comparison(data, recommend(data))] == list(COMPARISON_FIGURES)
    bare = made_comparison(("spring",))
    assert [name for name, _ in draw_comparison(bare, recommend(bare))] == list(COMPARISON_FIGURES[:2])


def test_law_the_report_compares_with_the_experiments_own_trials(analysis: Analysis) -> None:
    numbers = analysis.numbers
    table = {(row["stiffness"], row["delay"]): row for row in numbers["table1"]}
    [unconnected] = [row for row in numbers["table1"] if row["stiffness"] is None]
    alone, best = numbers["comparison"]["unconnected"], numbers["comparison"]["best"]
    assert alone["trials"] == unconnected["trials"]
    means = [alone[f"te{i}_mean"] for i in (1, 2)]
    assert means == pytest.approx([unconnected[f"te{i}_mean"] for i in (1, 2)], rel=1e-9)
    delayed = [row[best] for row in numbers["comparison"]["conditions"] if row["delay"] > 0.0]
    assert alone["compared"] == len(delayed) == numbers["comparison"]["delayed"]
    assert alone["better"] == sum(each["te1_mean"] + each["te2_mean"] > sum(means) for each in delayed)
    assert numbers["comparison"]["reference"] == "undelayed"
    own = [row for row in numbers["comparison"]["conditions"] if row["of_the_protocol"]]
    assert len(own) == 16
    for row in own:
        printed = table[row["stiffness"], row["delay"]]
        assert row["spring"]["trials"] == printed["trials"]
        for te in ("te1", "te2"):
            assert row["spring"][f"{te}_mean"] == pytest.approx(printed[f"{te}_mean"], rel=1e-9)
            undelayed = table[row["stiffness"], 0.0][f"{te}_mean"]
            for key in ("spring", "guard", "shared_target"):
                assert row[key][f"{te}_cost"] == pytest.approx(row[key][f"{te}_mean"] / undelayed, rel=1e-9)


def test_ref_the_published_cost_of_delay_is_that_of_table_i(
    analysis: Analysis, du2025: dict[str, Any]
) -> None:
    """Du et al. (2025), Table I: means of CM-142-84 and CM-142-0, and so on."""
    printed = {
        (round(row["stiffness"]), round(row["delay"])): [row[te]["mean"] for te in ("TE1", "TE2")]
        for row in du2025["table1"]["row"]
        if "stiffness" in row
    }
    rows = [row for row in analysis.numbers["comparison"]["conditions"] if row["published"]]
    assert len(rows) == 16
    for row in rows:
        stiffness = round(row["stiffness"])
        one = printed[stiffness, round(1e3 * row["delay"])]
        for te, mean, undelayed in zip(("te1", "te2"), one, printed[stiffness, 0], strict=True):
            assert row["published"][f"{te}_cost"] == pytest.approx(mean / undelayed)
