"""What `telespring compare` prints: the best safe choice and why, every strategy, what ran away."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.padding import Padding
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
        LeftOut,
        Recommendation,
        Rejection,
        Unconnected,
    )
    from telespring.comparison.choices import Grounds, Lack

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
            console.print(Padding(Text(sentence), (0, 0, 0, 2)))
        else:
            style = "bold red" if recommendation.recommended is None else "bold green"
            console.print(Text(sentence, style=style))
    console.print()
    console.print(_strategy_table(data, recommendation))
    for line in _ran_away_lines(data):
        console.print(line, markup=False)
    for line in _left_out_lines(comparison.left_out):
        console.print(line, markup=False)


def recommendation_sentences(recommendation: Recommendation, networks: int = 1) -> Iterator[str]:
    """Say which choice is the best safe one, why it is safe, how good it is, and what comes next."""
    what, plural = "delay", "delays"
    if networks > 1:
        what, plural = "pair of network and delay", "pairs of network and delay"
    best, unconnected = recommendation.candidate, recommendation.unconnected
    if best is None:
        yield "NOTHING THAT WAS COMPARED IS SAFE at every delay and on every network."
        yield (
            "Safe is what has grounds of its own on each of them, if no trial ran away or ended early; "
            "docs/strategies.md lists them."
        )
        return
    choice = f"{name_strategy(best.architecture)} at {format_number(best.stiffness)} N/m"
    if unconnected.outcome == "worse":
        yield "WORKING ALONE IS BETTER than every coupling that is safe."
        yield f"The best of them is {choice}: {_difference_sentence(unconnected)}"
    else:
        yield f"RECOMMENDED: {choice}"
    yield f"Safe: {_GROUNDS[best.grounds]}. None of its trials ran away."
    yield (
        f"Tracking errors of both people {_pair(best.tracking_error)}, and "
        f"{_pair(best.worst_tracking_error)} at the worst of "
        f"{format_count(recommendation.conditions, what, plural)}."
    )
    if unconnected.outcome == "better":
        yield f"{_difference_sentence(unconnected).capitalize()}"
    elif unconnected.outcome == "no difference":
        yield f"No better than working alone: {_difference_sentence(unconnected)}"
    following = recommendation.next_best
    if following is not None and following.candidate is not None:
        yield _next_sentence(following, following.candidate)


#: Why a choice is safe.
_GROUNDS: Mapping[Grounds, str] = MappingProxyType(
    {
        "any network": "on any network the guard gives out no more energy than its account holds",
        "stable spring": "the spring is stable at every delay that was compared",
        "bounded ages": "its dampers are strong enough for every age that network and play-out make",
        "honest partner": "on any network, both sides give out no more energy than went in, "
        "if the partner's program tells the truth about its energy",
    }
)
#: What a strategy lacks for that.
_LACKS: Mapping[Lack, str] = MappingProxyType(
    {
        "stable spring": "spring not stable",
        "known prediction": "prediction not judged",
        "force without a computing tick": "force acts a tick late",
        "force without a lag": "force lags",
        "exact positions": "positions are rounded",
        "weaker damper": "damper too strong for the mass",
        "stronger damper": "damper too weak for the spring",
        "softer spring": "too stiff for the sample period",
        "shorter ages": "ages longer than its damper is for",
        "honest partner": "a partner that may lie",
    }
)


def _difference_sentence(unconnected: Unconnected) -> str:
    """Say by how much a choice differs from working alone."""
    size = f"{1e3 * abs(unconnected.difference):.2f}"
    if np.isfinite(unconnected.difference_error) and unconnected.difference_error > 0.0:
        size += f" ± {1e3 * unconnected.difference_error:.2f}"
    more = "more" if unconnected.difference > 0.0 else "less"
    return f"{size} mm {more} on average than without a partner ({_pair(unconnected.tracking_error)})."


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
    return f"none: {_LACKS[softest.lack] if softest.lack else softest.objection}"


def _left_out_lines(left_out: Sequence[LeftOut]) -> Iterator[str]:
    """Say which usual strategies the study cannot have, those together that need the same."""
    needs: dict[tuple[str, str], list[LeftOut]] = {}
    for each in left_out:
        needs.setdefault((each.field, each.remedy), []).append(each)
    for (field, remedy), ones in needs.items():
        names = ", ".join(name_strategy(each.architecture) for each in ones)
        why = f"{field} = {ones[0].value}: {ones[0].allowed}. " if len(ones) == 1 else f"{field}: "
        yield f"Left out: {names}. {why}{remedy}"


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
