"""Table I and the other measures as one screen of text, in mm, ms and N."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from telespring.analysis.table import group_name

__all__ = ["analysis_screen"]


def analysis_screen(numbers: Mapping[str, Any], title: str) -> RenderableType:
    """Lay an analysis out for the terminal.

    Parameters
    ----------
    numbers
        What `telespring.analysis.analyse_trials` found.
    title
        What was analysed.

    Returns
    -------
    rich.console.RenderableType
        Table I with lag, interaction force and effort beside, and what the tests say.
    """
    return Group(Text(title, style="bold"), _table(numbers), *_words(numbers))


def _table(numbers: Mapping[str, Any]) -> Table:
    measured = numbers["conditions"][0]["measures"]
    # Narrow enough for 80 columns.
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    table.add_column("Condition", no_wrap=True)
    for robot in (1, 2):
        table.add_column(f"TE{robot}\nmm", justify="right", no_wrap=True)
    shown = [
        ("lag", "lag\nms", 1e3, 0),
        ("interaction_force_rms", "spring\nN", 1.0, 2),
        ("effort_rms", "effort\nN", 1.0, 2),
    ]
    shown = [each for each in shown if each[0] in measured]
    for _, heading, _, _ in shown:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("trials", justify="right", no_wrap=True)
    for row, condition in zip(numbers["table1"], numbers["conditions"], strict=True):
        cells = [_error(row, robot) for robot in (1, 2)]
        for name, _, factor, digits in shown:
            values = [condition["measures"][name][f"robot{robot}"]["mean"] for robot in (1, 2)]
            words = ["–" if value is None else _short(factor * value, digits, 10.0) for value in values]
            cells.append(Text("|".join(words)))
        early, begun = row["ended_early"], row["trials"]
        trials = Text(f"{begun - early}/{begun}", style="red") if early else Text(str(begun))
        table.add_row(row["condition"], *cells, trials)
    return table


def _error(row: Mapping[str, Any], robot: int) -> Text:
    mean, sd = row[f"te{robot}_mean"], row[f"te{robot}_sd"]
    if mean is None:
        return Text("–     ")
    words = _short(mean, 2, 100.0) + (
        "" if sd is None else f" ± {_short(sd, 2, 10.0 if mean >= 100.0 else 100.0)}"
    )
    arrow, holm = row[f"te{robot}_arrow"], row[f"te{robot}_arrow_holm"]
    return Text(f"{words} {arrow or ' '}{'*' if arrow and holm else ' '}")


def _words(numbers: Mapping[str, Any]) -> Iterator[Text]:
    analysed = numbers["analysed"]
    yield Text("")
    yield Text(
        f"From {analysed['from']:.4g} to {analysed['to']:.4g} s of every trial, a sample every "
        f"{1e3 * analysed['sample_period']:.4g} ms. TE: mean ± standard deviation. Others: mean of robot "
        "1|robot 2; spring and effort are root mean squares."
    )
    baseline = numbers["baseline"]["condition"]
    if baseline is None:
        yield Text(
            "No unconnected mode: nothing to draw arrows against (--baseline names another condition)."
        )
    else:
        size = numbers["wilcoxon"]["baseline"]["size"]
        yield Text(
            f"↑ ↓ differs from TE2 in {baseline}, Wilcoxon rank sum, p < 0.05; * also after Holm's "
            f"correction over all {size} comparisons."
        )
        alone = next(
            (
                each
                for each in numbers["wilcoxon"]["robots"]["comparisons"]
                if each["first"] == group_name(1, baseline)
            ),
            None,
        )
        if alone is not None and alone["p"] is not None:
            low, high = alone["superiority_interval"]
            yield Text(
                f"TE1 against TE2 in {baseline}: p {_p(alone['p'])}, TE1 is the larger with probability "
                f"{alone['superiority']:.2f} ({low:.2f} to {high:.2f})."
            )
    for test in numbers["kruskal_wallis"]:
        if test["over"] == "all conditions" and test["h"] is not None:
            yield Text(
                f"TE{test['robot']} over all conditions: Kruskal-Wallis H({test['degrees_of_freedom']}) = "
                f"{test['h']:.2f}, p {_p(test['p'])}, ε² = {test['epsilon_squared']:.2f}."
            )
    for warning in numbers["warnings"]:
        yield Text(warning, style="red")
    early = sum(row["ended_early"] for row in numbers["table1"])
    if early:
        yield Text(
            f"{'1 trial ended early: it has' if early == 1 else f'{early} trials ended early: they have'} "
            "no tracking error and no part in the tests, so that the condition looks better than it is.",
            style="red",
        )


def _short(value: float, decimals: int, from_here: float) -> str:
    """Write a number with one decimal less from `from_here` on, and again from ten times that."""
    fewer = sum(abs(value) >= limit for limit in (from_here, 10.0 * from_here))
    return f"{value:.{max(0, decimals - fewer)}f}"


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else f"= {value:.3f}"
