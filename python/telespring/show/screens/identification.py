"""The screen of `telespring identify`: estimates with intervals, how they were made, and warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from telespring.identification.cutoff import CUTOFF_RULE
from telespring.identification.warning_messages import UNITS
from telespring.show.quantities import format_count, format_estimate, format_number
from telespring.show.screens.layout import Fitting

if TYPE_CHECKING:
    from telespring.identification.results import Identification

__all__ = ["identification_screen"]

_PARAMETERS = {
    "mass": "mass",
    "damping": "damping",
    "stiffness": "spring",
    "coulomb": "Coulomb friction",
    "offset": "offset",
    "drag": "drag, times v|v|",
    "stiction": "stiction",
    "gravity_sine": "gravity, sine",
    "gravity_cosine": "gravity, cosine",
}


def identification_screen(identification: Identification, title: str) -> RenderableType:
    """Lay out an identified robot for the terminal, under the name of its log."""
    source = "automatic" if identification.cutoff_rule == CUTOFF_RULE else "as given"
    return Group(
        _identified_estimate_table(identification, title),
        Text(
            f"{format_count(identification.samples[0], 'sample')} at {format_number(identification.rate, 5)} "
            f"Hz; {identification.samples[1]} used after filtering at "
            f"{format_number(identification.cutoff)} Hz ({source})."
        ),
        *_force_lag_statement(identification),
        *_log_table(identification),
        _identification_method_statement(identification),
        *_axis_independence_statement(identification),
        Text(_CONDITION_NUMBER),
        Text(identification.outside_intervals),
        *(Text.assemble(("Warning: ", "bold yellow"), warning) for warning in identification.warnings),
    )


_CONDITION_NUMBER = (
    "The condition number says how well the movement tells the parameters apart: the smaller the better, "
    "and 1 is ideal."
)


def _identified_estimate_table(identification: Identification, title: str) -> Fitting:
    table = Table(box=None, pad_edge=False)
    table.add_column("axis", no_wrap=True, min_width=4)
    for heading in ("parameter", "estimate", "95 % interval", "condition no.", "R²"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right", no_wrap=True)
    lines = []
    for axis in identification.axes:
        quality = axis.axis, format_number(axis.condition_number), f"{axis.r_squared:.5f}"
        line = [f"condition number {quality[1]}", f"R² {quality[2]}"]
        for key, estimate in reversed(list(axis.estimates.items())):
            value, interval = format_estimate(estimate.value, estimate.standard_error, estimate.interval)
            line.insert(0, f"{_PARAMETERS[key]} {value} {UNITS[key]} ({interval})")
        lines.append(Text(f"{axis.axis}: {'; '.join(line)}"))
        for key, estimate in axis.estimates.items():
            value, interval = format_estimate(estimate.value, estimate.standard_error, estimate.interval)
            table.add_row(quality[0], _PARAMETERS[key], f"{value} {UNITS[key]}", interval, *quality[1:])
            quality = "", "", ""
    narrow = Group(Text("In brackets: 95 % intervals."), *lines)
    return Fitting(Text(title, style="bold"), table, narrow)


def _force_lag_statement(identification: Identification) -> list[Text]:
    """Say by how much the force was late, where that was estimated; the estimates allow for it."""
    shifts = {axis.axis: axis.time_shift for axis in identification.axes if axis.time_shift is not None}
    estimated = {name: shift for name, shift in shifts.items() if shift.standard_error > 0.0}
    if not estimated:
        return []
    distinct = set(estimated.values())
    lines = []
    for name, shift in estimated.items():
        value, interval = format_estimate(
            1e3 * shift.value, 1e3 * shift.standard_error, (1e3 * shift.interval[0], 1e3 * shift.interval[1])
        )
        of_axis = "" if len(distinct) == 1 else f" on {name}"
        lines.append(
            Text(f"Lag of the force{of_axis}: {value} ms ({interval} ms); the estimates allow for it.")
        )
    return lines[:1] if len(distinct) == 1 else lines


def _log_table(identification: Identification) -> list[RenderableType]:
    """Show the mass and damping that each log gives alone, where there are several."""
    if not identification.logs:
        return []
    table = Table(box=None, pad_edge=False, title_justify="left", title="Each log alone")
    table.add_column("log")
    for axis in identification.axes:
        table.add_column(f"mass {axis.axis}, kg", justify="right")
        table.add_column(f"damping {axis.axis}, N·s/m", justify="right")
    for number, log in enumerate(identification.logs, start=1):
        cells = []
        for axis in log.axes:
            for estimate in (axis.mass, axis.damping):
                value, _ = format_estimate(estimate.value, estimate.standard_error, estimate.interval)
                cells.append(value)
        table.add_row(str(number), *cells)
    return [table]


def _identification_method_statement(identification: Identification) -> Text:
    iterations = identification.iterations
    return Text(
        {
            "robust": "Robust regression. Intervals account for autocorrelated residuals.",
            "ols": "Ordinary least squares. Intervals account for autocorrelated residuals.",
            "paper": (
                f"The paper's weights 1/(r² + ε), {iterations} reweighting{'' if iterations == 1 else 's'}. "
                "These intervals are not valid."
            ),
        }[identification.method]
    )


def _axis_independence_statement(identification: Identification) -> list[Text]:
    """State whether several axes are independent."""
    if len(identification.axes) == 1:
        return []
    return [
        {
            True: Text("The axes are independent, as far as this log shows.", style="green"),
            False: Text("The axes are NOT independent.", style="bold red"),
            None: Text("This log cannot show whether the axes are independent."),
        }[identification.independent]
    ]
