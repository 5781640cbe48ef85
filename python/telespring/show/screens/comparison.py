"""What `telespring compare` prints: the best safe choice and why, every strategy, what ran away."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.text import Text

from telespring._quantities import format_count, format_number
from telespring.show.screens.layout import Fitting, fitting_table
from telespring.show.strategies import name_strategy

if TYPE_CHECKING:
    import xarray as xr

    from telespring.comparison import (
        Alternative,
        Candidate,
        Comparison,
        Recommendation,
        Rejection,
    )

__all__ = ["comparison_screen", "recommendation_sentences"]

#: So many pairs of network and delay have a column each; of more the table shows the worst.
_MOST_COLUMNS = 5
#: So many lines say what ran away.
_MOST_LINES = 5


def comparison_screen(console: Console, comparison: Comparison) -> None:
    """Print what a comparison found, in at most thirty lines at the usual width."""
    data, recommendation = comparison.dataset, comparison.recommendation
    console.print(Text(comparison.name, style="bold"))
    for i, sentence in enumerate(recommendation_sentences(recommendation, data.sizes["network"])):
        if i:
            console.print(f"  {sentence}", markup=False)
        else:
            style = "bold red" if recommendation.candidate is None else "bold green"
            console.print(Text(sentence, style=style))
    console.print()
    console.print(_strategy_table(data, recommendation))
    for line in _ran_away_lines(data):
        console.print(line, markup=False)
    if comparison.left_out:
        reasons = "; ".join(
            f"{name_strategy(left_out.architecture)} ({left_out.reason})" for left_out in comparison.left_out
        )
        console.print(f"Left out: {reasons}.", markup=False)


def recommendation_sentences(recommendation: Recommendation, networks: int = 1) -> Iterator[str]:
    """Say which choice is the best safe one, why it is safe, how good it is, and what comes next."""
    what, plural = "delay", "delays"
    if networks > 1:
        what, plural = "pair of network and delay", "pairs of network and delay"
    best = recommendation.candidate
    if best is None:
        yield "NOTHING THAT WAS COMPARED IS SAFE at every delay and on every network."
        yield (
            "Safe is what the guard limits, or a spring that `telespring decide` calls stable, if no trial "
            "ran away or ended early."
        )
        return
    yield f"RECOMMENDED: {name_strategy(best.architecture)} at {format_number(best.stiffness)} N/m"
    yield f"Safe: {_grounds(best)}. None of its trials ran away."
    yield (
        f"Tracking errors of both people {_pair(best.tracking_error)}, and "
        f"{_pair(best.worst_tracking_error)} at the worst of "
        f"{format_count(recommendation.conditions, what, plural)}."
    )
    following = recommendation.next_best
    if following is not None and following.candidate is not None:
        yield _next_sentence(following, following.candidate)


def _grounds(candidate: Candidate) -> str:
    if candidate.grounds == "any network":
        return "the guard gives out no more energy than it has, on any network"
    return "the spring is stable at every delay that was compared"


def _next_sentence(following: Alternative, candidate: Candidate) -> str:
    difference = f"{1e3 * following.difference:.2f}"
    if np.isfinite(following.difference_error) and following.difference_error > 0.0:
        difference += f" ± {1e3 * following.difference_error:.2f}"
    return (
        f"Next best: {name_strategy(candidate.architecture)} at {format_number(candidate.stiffness)} N/m, "
        f"with {difference} mm more on average."
    )


def _pair(errors: tuple[float, float]) -> str:
    one, two = errors
    return f"{1e3 * one:.1f} and {1e3 * two:.1f} mm"


def _shown_stiffness(data: xr.Dataset, recommendation: Recommendation) -> float:
    """Return the stiffness that the table shows, N/m: the recommended one, or else the largest."""
    best = recommendation.candidate
    return float(data.stiffness.max()) if best is None else best.stiffness


def _strategy_table(data: xr.Dataset, recommendation: Recommendation) -> Fitting:
    """Lay out the errors of every strategy, a column per delay; with many of them, only the worst."""
    stiffness = _shown_stiffness(data, recommendation)
    here = data.isel(condition=np.flatnonzero(data.stiffness.values == stiffness)).sortby("delay")
    pairs = [
        (str(network), i)
        for n, network in enumerate(here.network.values)
        for i in range(here.sizes["condition"])
        if here.is_rehearsed.transpose("network", "condition").values[n, i]
    ]
    several = here.sizes["network"] > 1
    has_column_each = len(pairs) <= _MOST_COLUMNS
    delays = [f"{1e3 * float(here.delay[i]):.0f} ms" for _, i in pairs]
    if not has_column_each:
        columns = ["least", "worst", "at"]
    elif several:
        columns = [f"{network}\n{delay}" for (network, _), delay in zip(pairs, delays, strict=True)]
    else:
        columns = delays
    choices = _choices(recommendation)
    best = recommendation.candidate
    rows = []
    for label in map(str, here.architecture.values):
        one = here.sel(architecture=label)
        cells: list[Text | str] = [
            _error_cell(one.sel(network=network).isel(condition=i)) for network, i in pairs
        ]
        if not has_column_each:
            cells = _extreme_cells(one, pairs, cells, several=several)
        style = "bold" if best is not None and best.architecture == label else ""
        rows.append([Text(name_strategy(label), style=style), *cells, _limited_cell(one), choices[label]])
    networks = f"{format_count(here.sizes['network'], 'network')}, " if several else ""
    last = len(columns) + 1
    return fitting_table(
        f"Mean tracking errors TE₁, TE₂ at {format_number(stiffness)} N/m, mm "
        f"({networks}{format_count(here.sizes['trial'], 'trial')} each)",
        ["strategy", *columns, "limited", "best safe"],
        rows,
        right=[*range(1, last - (not has_column_each)), last],
        optional=(last,),
    )


def _error_cell(place: xr.Dataset) -> Text:
    """Write the errors of both, and how many trials ran away."""
    means = _mean_errors(place)
    ran_away, trials = int(place.diverged.sum()), place.sizes["trial"]
    words = "–" if means is None else f"{1e3 * means[0]:.1f} {1e3 * means[1]:.1f}"
    if ran_away:
        count = "" if ran_away == trials else f" {ran_away}/{trials}"
        words = f"ran away{count}"
    return Text(words, style="red" if ran_away else "")


def _mean_errors(place: xr.Dataset) -> tuple[float, float] | None:
    errors = place.tracking_error.transpose("trial", "robot").values
    finished = errors[np.isfinite(errors).all(axis=1)]
    if not len(finished):
        return None
    one, two = finished.mean(axis=0).tolist()
    return one, two


def _extreme_cells(
    one: xr.Dataset, pairs: Sequence[tuple[str, int]], cells: Sequence[Text | str], *, several: bool
) -> list[Text | str]:
    """Write the least and the worst of many cells, and where the worst is."""
    places = [one.sel(network=network).isel(condition=i) for network, i in pairs]

    def badness(i: int) -> tuple[int, float]:
        means = _mean_errors(places[i])
        return int(places[i].diverged.sum()), np.inf if means is None else max(means)

    order = sorted(range(len(pairs)), key=badness)
    network, condition = pairs[order[-1]]
    where = f"{1e3 * float(one.delay[condition]):.0f} ms"
    return [cells[order[0]], cells[order[-1]], f"{network}, {where}" if several else where]


def _limited_cell(one: xr.Dataset) -> str:
    """Write the largest share of ticks that was limited at any delay."""
    limited = one.limited_share.mean(("trial", "robot")).values
    if not np.isfinite(limited).any():
        return "–"
    share = 100.0 * float(np.nanmax(limited))
    if 0.0 < share < 0.05:
        return "< 0.1 %"
    return f"{share:.0f} %" if share >= 0.95 or share == 0.0 else f"{share:.1f} %"


def _choices(recommendation: Recommendation) -> dict[str, str]:
    """Say for every architecture at which stiffness it is a safe choice, or why it is none."""
    words = {}
    best = recommendation.candidate
    if best is not None:
        words[best.architecture] = f"{format_number(best.stiffness)} N/m"
    for each in recommendation.alternatives:
        candidate = each.candidate
        if candidate is not None:
            words[each.architecture] = f"{format_number(candidate.stiffness)} N/m"
        else:
            words[each.architecture] = _why_none(each.rejections)
    return words


def _why_none(rejections: Sequence[Rejection]) -> str:
    """Say why an architecture is no safe choice at any stiffness: what was found at its softest one."""
    if not rejections:
        return "none"
    softest = min(rejections, key=lambda rejection: rejection.stiffness)
    words = {
        "not proven": "nothing proves it",
        "overdraft": "the controllers are too slow for a guard at this stiffness",
    }
    return f"none: {words.get(softest.objection, softest.objection)}"


def _ran_away_lines(data: xr.Dataset) -> Iterator[str]:
    """List by strategy where trials ran away, and how many of them."""
    lines = []
    for label in map(str, data.architecture.values):
        places = []
        for network in data.network.values:
            one = data.sel(architecture=label, network=network).sortby(["stiffness", "delay"])
            for i, count in enumerate(one.diverged.sum("trial").values.tolist()):
                if count:
                    where = (
                        f"{format_number(float(one.stiffness[i]))} N/m, {1e3 * float(one.delay[i]):.0f} ms"
                    )
                    if data.sizes["network"] > 1:
                        where += f" on {network}"
                    places.append(f"{where} ({count} of {data.sizes['trial']})")
        if places:
            more = f"; and {len(places) - 3} more" if len(places) > 3 else ""
            lines.append(f"  {name_strategy(label)}: {'; '.join(places[:3])}{more}")
    if not lines:
        yield "No trial ran away."
        return
    yield "Ran away:"
    yield from lines[:_MOST_LINES]
    if len(lines) > _MOST_LINES:
        yield f"  and {format_count(len(lines) - _MOST_LINES, 'more strategy', 'more strategies')}"
