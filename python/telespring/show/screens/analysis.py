"""The screen of `telespring analyse`: Table I and the other measures in mm, ms and N, and the tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from telespring.analysis.tracking_errors import tracking_error_name
from telespring.show.quantities import format_in_column, format_p_value

__all__ = ["analysis_screen"]

#: Measures in addition to the tracking errors: key, heading, factor to the unit shown, and decimals.
_COLUMNS = (
    ("lag", "lag\nms", 1e3, 0),
    ("interaction_force_rms", "spring\nN", 1.0, 2),
    ("effort_rms", "effort\nN", 1.0, 2),
)


def analysis_screen(
    numbers: Mapping[str, Any], title: str, resampled_to: float | None = None
) -> RenderableType:
    """Lay out an analysis for the terminal: Table I with lag and forces, and the results of the tests.

    `resampled_to` is the period of the grid to which the trials were resampled, s; None if they were not.
    """
    return Group(
        Text(title, style="bold"), _table_1_screen(numbers), *_test_result_lines(numbers, resampled_to)
    )


def _table_1_screen(numbers: Mapping[str, Any]) -> Table:
    # Narrow enough for 80 columns.
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    table.add_column("Condition", no_wrap=True)
    for robot in (1, 2):
        table.add_column(f"TE{robot}\nmm", justify="right", no_wrap=True)
    measured = numbers["conditions"][0]["measures"]
    columns = [column for column in _COLUMNS if column[0] in measured]
    for _, heading, _, _ in columns:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("trials", justify="right", no_wrap=True)
    for row, condition in zip(numbers["table1"], numbers["conditions"], strict=True):
        cells = [_table_1_cell(row, robot) for robot in (1, 2)]
        for name, _, factor, decimals in columns:
            means = [condition["measures"][name][f"robot{robot}"]["mean"] for robot in (1, 2)]
            shown = [
                "–" if mean is None else format_in_column(factor * mean, decimals, 10.0) for mean in means
            ]
            cells.append(Text("|".join(shown)))
        early, begun = row["ended_early"], row["trials"]
        trials = Text(f"{begun - early}/{begun}", style="red") if early else Text(str(begun))
        table.add_row(row["condition"], *cells, trials)
    return table


def _table_1_cell(row: Mapping[str, Any], robot: int) -> Text:
    """Show mean ± standard deviation, an arrow for a difference from the baseline, * if Holm keeps it."""
    mean, sd = row[f"te{robot}_mean"], row[f"te{robot}_sd"]
    if mean is None:
        return Text("–     ")
    text = format_in_column(mean, 2, 100.0)
    if sd is not None:
        text += f" ± {format_in_column(sd, 2, 10.0 if mean >= 100.0 else 100.0)}"
    arrow, arrow_holm = row[f"te{robot}_arrow"], row[f"te{robot}_arrow_holm"]
    return Text(f"{text} {arrow or ' '}{'*' if arrow and arrow_holm else ' '}")


def _test_result_lines(numbers: Mapping[str, Any], resampled_to: float | None) -> Iterator[Text]:
    analysed = numbers["analysed"]
    has_forces = "interaction_force_rms" in numbers["conditions"][0]["measures"]
    forces = "; forces are root mean squares" if has_forces else ""
    yield Text("")
    yield Text(
        f"Every trial from {analysed['from']:.4g} to {analysed['to']:.4g} s, sampled every "
        f"{1e3 * analysed['sample_period']:.4g} ms. TE: mean ± standard deviation of the tracking error. "
        f"Other columns: means for robot 1|robot 2{forces}."
    )
    if resampled_to is not None:
        yield Text(
            f"The trials had different sample times and were resampled every {1e3 * resampled_to:.4g} ms."
        )
    yield from _baseline_comparison_lines(numbers)
    for test in numbers["kruskal_wallis"]:
        if test["over"] == "all conditions" and test["h"] is not None:
            yield Text(
                f"TE{test['robot']} over all conditions: Kruskal-Wallis H({test['degrees_of_freedom']}) = "
                f"{test['h']:.2f}, p {format_p_value(test['p'])}, ε² = {test['epsilon_squared']:.2f}."
            )
    for warning in numbers["warnings"]:
        yield Text(warning, style="red")
    early = sum(row["ended_early"] for row in numbers["table1"])
    if early:
        yield Text(
            f"{'1 trial ended early: it has' if early == 1 else f'{early} trials ended early: they have'} "
            "no tracking error and no part in the tests, so the condition looks better than it is.",
            style="red",
        )


def _baseline_comparison_lines(numbers: Mapping[str, Any]) -> Iterator[Text]:
    baseline = numbers["baseline"]["condition"]
    if baseline is None:
        yield Text(
            "There is no unconnected mode to compare with, so there are no arrows; --baseline chooses "
            "another condition."
        )
        return
    yield Text(
        f"↑ ↓ larger or smaller than TE2 in {baseline}: Wilcoxon rank-sum test, p < 0.05; * also after "
        f"Holm's correction over all {numbers['wilcoxon']['baseline']['size']} comparisons."
    )
    for comparison in numbers["wilcoxon"]["robots"]["comparisons"]:
        if comparison["first"] == tracking_error_name(1, baseline) and comparison["p"] is not None:
            low, high = comparison["superiority_interval"]
            yield Text(
                f"TE1 against TE2 in {baseline}: p {format_p_value(comparison['p'])}; TE1 is the larger with "
                f"probability {comparison['superiority']:.2f} ({low:.2f} to {high:.2f})."
            )
