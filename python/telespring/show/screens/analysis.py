"""The screen of `telespring analyse`: Table I and the other measures in mm, ms and N, and the tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from telespring.analysis.statistics import LEVEL, fewest_values
from telespring.analysis.tracking_errors import tracking_error_name
from telespring.show.quantities import format_in_column, format_p_value, format_time

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
        Text(title, style="bold"),
        _WidestThatFits([[_table_1_screen(numbers)], _narrow_tables(numbers)]),
        Text(""),
        *_test_result_lines(numbers, resampled_to),
    )


@dataclass(frozen=True)
class _WidestThatFits:
    """The first of several layouts (tables below each other) that fits the terminal, else the last."""

    layouts: Sequence[Sequence[Table]]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for layout in self.layouts:
            wide = options.update_width(10_000)
            if all(Measurement.get(console, wide, table).maximum <= options.max_width for table in layout):
                break
        for i, table in enumerate(layout):
            if i:
                yield Text("")
            yield table


def _table_1_screen(numbers: Mapping[str, Any]) -> Table:
    table = _create_table()
    _add_error_columns(table)
    _add_measure_columns(table, numbers)
    _add_trial_columns(table, numbers)
    for row, condition in zip(numbers["table1"], numbers["conditions"], strict=True):
        table.add_row(
            row["condition"],
            *_error_cells(row),
            *_measure_cells(numbers, condition),
            *_trial_cells(numbers, row),
        )
    return table


def _narrow_tables(numbers: Mapping[str, Any]) -> list[Table]:
    """Put the errors and the other measures below each other."""
    errors, measures = _create_table(), _create_table()
    _add_error_columns(errors)
    _add_trial_columns(errors, numbers)
    _add_measure_columns(measures, numbers)
    for row, condition in zip(numbers["table1"], numbers["conditions"], strict=True):
        errors.add_row(row["condition"], *_error_cells(row), *_trial_cells(numbers, row))
        measures.add_row(row["condition"], *_measure_cells(numbers, condition))
    return [errors, measures]


def _create_table() -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    # Names have no spaces to break at; a very long one goes on in the next line.
    table.add_column("Condition", overflow="fold")
    return table


def _add_error_columns(table: Table) -> None:
    for robot in (1, 2):
        table.add_column(f"TE{robot}\nmm", justify="right", no_wrap=True)


def _add_measure_columns(table: Table, numbers: Mapping[str, Any]) -> None:
    for _, heading, _, _ in _present_columns(numbers):
        table.add_column(heading, justify="right", no_wrap=True)


def _add_trial_columns(table: Table, numbers: Mapping[str, Any]) -> None:
    if numbers["analysed"]["unit"] == "dyad":
        table.add_column("dyads", justify="right", no_wrap=True)
    table.add_column("trials", justify="right", no_wrap=True)
    if _has_copies(numbers):
        table.add_column("distinct", justify="right", no_wrap=True)


def _present_columns(numbers: Mapping[str, Any]) -> list[tuple[str, str, float, int]]:
    measured = numbers["conditions"][0]["measures"]
    return [column for column in _COLUMNS if column[0] in measured]


def _has_copies(numbers: Mapping[str, Any]) -> bool:
    return any(row["te1_copies"] or row["te2_copies"] for row in numbers["table1"])


def _error_cells(row: Mapping[str, Any]) -> list[Text]:
    return [_table_1_cell(row, robot) for robot in (1, 2)]


def _measure_cells(numbers: Mapping[str, Any], condition: Mapping[str, Any]) -> Iterator[Text]:
    for name, _, factor, decimals in _present_columns(numbers):
        means = [condition["measures"][name][f"robot{robot}"]["mean"] for robot in (1, 2)]
        shown = ["–" if mean is None else format_in_column(factor * mean, decimals, 10.0) for mean in means]
        yield Text("|".join(shown))


def _trial_cells(numbers: Mapping[str, Any], row: Mapping[str, Any]) -> list[Text]:
    early, begun = row["ended_early"], row["trials"]
    cells = [Text(f"{begun - early}/{begun}", style="red") if early else Text(str(begun))]
    if numbers["analysed"]["unit"] == "dyad":
        cells.insert(0, Text(_for_both(row["te1_n"], row["te2_n"])))
    if _has_copies(numbers):
        is_reduced = row["te1_copies"] or row["te2_copies"]
        distinct = _for_both(row["te1_distinct"], row["te2_distinct"])
        cells.append(Text(distinct, style="yellow" if is_reduced else ""))
    return cells


def _for_both(first: int, second: int) -> str:
    """Write a number of each robot, once if both are equal."""
    return str(first) if first == second else f"{first}|{second}"


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
    over = "mean ± standard deviation over the trials"
    if analysed["unit"] == "dyad":
        over = "mean ± standard deviation over the dyads, each with the mean of its trials"
    yield Text(
        f"Every trial from {analysed['from']:.4g} to {analysed['to']:.4g} s, sampled every "
        f"{format_time(analysed['sample_period'])}. TE: tracking error, {over}. "
        f"Other columns: means for robot 1|robot 2{forces}."
    )
    if resampled_to is not None:
        yield Text(
            f"The trials had different sample times and were resampled every {format_time(resampled_to)}."
        )
    yield from _baseline_comparison_lines(numbers)
    for test in numbers["kruskal_wallis"]:
        if test["over"] == "all conditions" and test["p"] is not None:
            yield Text(_group_test_sentence(test))
    yield from _independence_lines(numbers)
    yield from _copy_lines(numbers)
    for warning in numbers["warnings"]:
        yield Text(warning, style="red")
    early = sum(row["ended_early"] for row in numbers["table1"])
    if early:
        yield Text(
            f"{'1 trial ended early: it has' if early == 1 else f'{early} trials ended early: they have'} "
            "no tracking error and no part in the tests, so the condition looks better than it is.",
            style="red",
        )


def _group_test_sentence(test: Mapping[str, Any]) -> str:
    is_friedman = test["test"] == "Friedman"
    symbol, statistic = ("Q", test["q"]) if is_friedman else ("H", test["h"])
    effect = "W" if is_friedman else "ε²"
    size = test["kendalls_w"] if is_friedman else test["epsilon_squared"]
    how = ", exact" if test["method"] == "exact" else ""
    if test["method"] == "permutation":
        how = f", by {test['permutations']:,} random permutations"
    if test["least_p"] is not None and test["least_p"] >= LEVEL:
        how += f" (it cannot be below {_format_least_p(test['least_p'])})"
    return (
        f"TE{test['robot']} over all conditions: {test['test']} {symbol}({test['degrees_of_freedom']}) = "
        f"{statistic:.2f}, p {format_p_value(test['p'])}{how}; {effect} = {size:.2f}."
    )


def _baseline_comparison_lines(numbers: Mapping[str, Any]) -> Iterator[Text]:
    baseline = numbers["baseline"]["condition"]
    if baseline is None:
        yield Text(
            "There is no unconnected mode to compare with, so there are no arrows; --baseline chooses "
            "another condition."
        )
        return
    family = numbers["wilcoxon"]["baseline"]
    test = "Wilcoxon rank-sum test"
    if any(each["test"] == "signed-rank" for each in family["comparisons"]):
        test = "Wilcoxon signed-rank test within dyads"
    yield Text(
        f"↑ ↓ larger or smaller than TE2 in {baseline}: {test}, p < {LEVEL:g}; * also after "
        f"Holm's correction over all {family['size']} comparisons."
    )
    yield from _least_p_lines(family)
    for comparison in numbers["wilcoxon"]["robots"]["comparisons"]:
        if comparison["first"] == tracking_error_name(1, baseline) and comparison["p"] is not None:
            low, high = comparison["superiority_interval"]
            if comparison["test"] == "signed-rank":
                larger = (
                    f"in {100 * comparison['superiority']:.0f} % of these dyads (95 % interval for others: "
                    f"{100 * low:.0f} to {100 * high:.0f} %)"
                )
            else:
                chance = comparison["superiority"]
                larger = f"with probability {chance:.2f} (95 % interval: {low:.2f} to {high:.2f})"
            yield Text(
                f"TE1 against TE2 in {baseline}: p {format_p_value(comparison['p'])}; TE1 is the larger "
                f"{larger}."
            )


def _least_p_lines(family: Mapping[str, Any]) -> Iterator[Text]:
    """State which p values are out of reach for groups this small."""
    tested = [each for each in family["comparisons"] if each["least_p"] is not None]
    if not tested:
        return
    unit = "dyads" if tested[0]["unit"] == "dyad" else "distinct trials"
    least = min(each["least_p"] for each in tested)
    hopeless = [each for each in tested if each["least_p"] >= LEVEL]
    fewest = fewest_values(tested[0]["test"])
    if len(hopeless) == len(tested):
        yield Text(
            f"With so few {unit} p cannot be below {_format_least_p(least)}, so no arrow can appear, however "
            f"large the differences; {fewest} in each condition are the fewest.",
            style="yellow",
        )
        return
    if hopeless:
        names = _listed([each["first"] for each in hopeless])
        yield Text(
            f"{names}: too few {unit} for an arrow; p cannot be below "
            f"{_format_least_p(min(each['least_p'] for each in hopeless))}.",
            style="yellow",
        )
    if least * len(tested) >= LEVEL:
        fewest = fewest_values(tested[0]["test"], LEVEL / len(tested))
        yield Text(
            f"With so few {unit} no * can appear: the least p is {_format_least_p(least)}, and Holm's "
            f"correction asks for {_format_least_p(LEVEL / len(tested))} at first; {fewest} in each "
            "condition are the fewest.",
            style="yellow",
        )


def _format_least_p(p_value: float) -> str:
    return f"{p_value:.3g}"


def _independence_lines(numbers: Mapping[str, Any]) -> Iterator[Text]:
    """State what counts as independent, and what p means for it."""
    analysed = numbers["analysed"]
    if analysed["unit"] == "dyad":
        yield Text(
            f"{len(analysed['dyads'])} dyads: every dyad counts once, in all means and tests, so that p "
            "holds for other dyads too."
        )
    elif analysed["simulated"]:
        yield Text(_simulated_line(numbers))
    elif analysed["dyads"] is None:
        yield Text(
            "All trials count as independent. If several dyads or people took part, name them in the column "
            "dyad of the list: otherwise p is too small.",
        )
    else:
        yield Text("All trials are of one dyad: p holds for this dyad only.")


def _simulated_line(numbers: Mapping[str, Any]) -> str:
    """State what p means for simulated trials: more of them change it only where something is random."""
    judge = "Judge by the size of the differences."
    if not any(row[f"te{robot}_distinct"] > 1 for row in numbers["table1"] for robot in (1, 2)):
        return f"The trials are simulated and nothing in them is random, so p says nothing. {judge}"
    where = ", where trials differ," if _has_copies(numbers) else ""
    return (
        f"The trials are simulated: p also depends on how many were run, and with enough of them{where} any "
        f"difference is significant. {judge}"
    )


def _copy_lines(numbers: Mapping[str, Any]) -> Iterator[Text]:
    """State which trials are copies and do not count."""
    is_simulated = numbers["analysed"]["simulated"]
    repeated: dict[tuple[int, int], list[str]] = {}
    for row in numbers["table1"]:
        for robot in (1, 2):
            copies, distinct = row[f"te{robot}_copies"], row[f"te{robot}_distinct"]
            if copies:
                name = tracking_error_name(robot, row["condition"])
                repeated.setdefault((copies, copies + distinct), []).append(name)
    for (copies, completed), names in repeated.items():
        is_random = completed - copies > 1
        reason = (
            "" if is_random or not is_simulated else ": nothing in them is random; more trials do not help"
        )
        yield Text(
            f"{_listed(names)}: {copies} of {completed} trials repeat another one to the nanometre, so "
            f"{'it does' if copies == 1 else 'they do'} not count{reason}.",
            style="yellow",
        )


def _listed(names: Sequence[str]) -> str:
    """List names, the first few of many."""
    return ", ".join(names) if len(names) <= 6 else f"{', '.join(names[:5])} and {len(names) - 5} others"
