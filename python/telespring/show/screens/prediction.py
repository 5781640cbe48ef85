"""The screen of `telespring predictor`: errors per predictor and delay, and the lines for the study."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from telespring.analysis.prediction import PredictorComparison, PredictorErrors
from telespring.show.quantities import format_in_column, format_number
from telespring.show.screens.layout import fitting_table

__all__ = ["prediction_screen", "study_lines", "study_text"]

_UNITS = {"constant-velocity": "m²/s³", "constant-acceleration": "m²/s⁵"}


def prediction_screen(comparison: PredictorComparison, title: str) -> RenderableType:
    """Lay out a comparison of predictors for the terminal."""
    best = comparison.best, comparison.best_without_target
    rows = []
    for entry in comparison.predictors:
        cells = ["–" if error != error else format_in_column(1e3 * error, 2, 10.0) for error in entry.errors]
        style = "bold" if entry in best else ""
        rows.append([Text(entry.label, style), *(Text(cell, style) for cell in cells)])
    headings = ["RMS error, mm", *(f"{format_number(delay, shift=3)}\nms" for delay in comparison.delays)]
    table = fitting_table("", headings, rows, right=range(1, len(headings)))
    lines: list[RenderableType] = [Text(title, style="bold"), table, Text("")]
    used, recorded = comparison.motions
    lines.append(
        Text(f"{used} motions compared" + (f" of {recorded}, spread evenly." if used < recorded else "."))
    )
    lines += [_fit_line(comparison, model) for model in comparison.fits]
    lines.append(Text(""))
    lines.append(_best_line(comparison, best[0], "Best"))
    if best[1] is not best[0]:
        lines.append(_best_line(comparison, best[1], "Best without a shared target"))
    return Group(*lines)


def study_text(comparison: PredictorComparison) -> str:
    """Write what goes into the study: lines to copy, whole however narrow the terminal is."""
    best, without = comparison.best, comparison.best_without_target
    lines = ["", "For the study:", *study_lines(best)]
    if without is not best:
        lines += ["or, if the sites do not show one target on a shared clock:", study_lines(without)[1]]
    return "\n".join(
        [
            *lines,
            "",
            "A good prediction can still make the spring unstable: telespring.plot.prediction_map(dyad)",
            'shows where. With strategy = "guard" no side gives out more energy than its account holds.',
        ]
    )


def study_lines(entry: PredictorErrors) -> list[str]:
    """Write a predictor as the lines of a study file.

    Examples
    --------
    >>> study_lines(PredictorErrors("linear", "linear", (0.01,)))
    ['[session]', 'predictor = "linear"']
    """
    if isinstance(entry.predictor, str):
        return ["[session]", f'predictor = "{entry.predictor}"']
    settings = ", ".join(
        f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value!r}"
        for key, value in entry.predictor.items()
    )
    return ["[session]", f"predictor = {{{settings}}}"]


def _fit_line(comparison: PredictorComparison, model: str) -> Text:
    fit, ends = comparison.fits[model], comparison.ends[model]
    text = (
        f"Fitted noise, {model.replace('-', ' ')}: "
        f"process {format_number(fit['process'], 3)} {_UNITS[model]}, "
        f"position {format_number(fit['position'], 3, shift=3)} mm"
    )
    doubts = {
        "no measurement noise": "positions as good as exact",
        "no process noise": "motion as good as the model's",
    }
    for end, words in doubts.items():
        if ends.get(end):
            text += f"; {words} in {ends[end]} of {comparison.motions[0]}"
    return Text(f"{text}.")


def _best_line(comparison: PredictorComparison, entry: PredictorErrors, whose: str) -> Text:
    hold = comparison.predictors[0]
    shares = [
        error / held
        for error, held in zip(entry.errors, hold.errors, strict=True)
        if error == error and held > 0
    ]
    if not shares or entry is hold:
        return Text(f"{whose}: {entry.label}.")
    return Text(
        f"{whose}: {entry.label}, {100 * min(shares):.0f} to {100 * max(shares):.0f} % of the error of hold."
    )
