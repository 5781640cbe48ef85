"""Figs. 7 and 8 and Table I: the study's experiment, run on the virtual laboratory and analysed."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from telespring.paper.published import BASELINE_MEDIAN, TABLE_I, PublishedRow
from telespring.paper.rehearsed import rehearsed_study
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.paper.sections.experiment.reported import compare_reported_tests
from telespring.show import figures

__all__ = ["SECTION", "find_experiment"]


def find_experiment(scene: Scene) -> Findings:
    """Rehearse the study's protocol; for the paper's own experiment, compare the results with Table I."""
    import xarray

    from telespring.analysis.results import compare_conditions
    from telespring.analysis.statistics import LEVEL
    from telespring.analysis.trials import Trials
    from telespring.rehearsal.run import remove_rehearsal
    from telespring.show.drawings.trials import draw_errors, draw_trajectories

    experiment = scene.study.experiment
    if experiment is None:
        if scene.rehearsal is not None:
            # otherwise the page would be next to another study's trials
            remove_rehearsal(scene.rehearsal)
        return Findings()
    with rehearsed_study(scene) as dataset:
        trials = Trials.from_dataset(xarray.load_dataset(dataset, engine="h5netcdf"))
    analysed = compare_conditions(trials)
    rows = analysed["table1"]
    published = (
        {row.label: _printed_table_1_row(row) for row in TABLE_I} if scene.of_the_papers_experiment else {}
    )
    for row in rows:
        row["printed"] = published.get(row["condition"])
        for te in ("te1", "te2"):
            least = row[f"{te}_least_p"]
            row[f"{te}_untestable"] = least is not None and least >= LEVEL
    drawings = {
        "trajectories": figures.to_svg(
            draw_trajectories(trials),
            "trajectories",
            "Handle positions of every trial by condition",
            f"A panel per condition with the target and {experiment.trials} trials of both robots.",
        ),
        "tracking": figures.to_svg(
            draw_errors(analysed, published, BASELINE_MEDIAN) if published else draw_errors(analysed),
            "tracking",
            "Tracking error of both robots by condition",
            " ".join(_mean_tracking_errors(row) for row in rows),
        ),
    }
    return Findings(
        numbers={
            "table1": rows,
            "experiment": {
                "protocol": {
                    "conditions": len(experiment.conditions),
                    "trials": experiment.trials,
                    "duration": experiment.duration,
                    "discard": experiment.discard,
                    "record_rate": experiment.record_rate,
                    "seed": experiment.seed,
                    "order": experiment.order,
                },
                "finished": sum(row["trials"] - row["ended_early"] for row in rows),
                "ended_early": sum(row["ended_early"] for row in rows),
                "reported": compare_reported_tests(analysed) if published else [],
                "printed_baseline_median": BASELINE_MEDIAN if published else None,
                "compared": _compare_with_table_1(rows, _unstable_conditions(scene)) if published else None,
                **{key: analysed[key] for key in ("analysed", "baseline", "kruskal_wallis", "wilcoxon")},
                "conditions": [_condition_without_trials(condition) for condition in analysed["conditions"]],
            },
        },
        drawings=drawings,
    )


SECTION = Section(
    name="experiment",
    anchor="experiment",
    title="The experiment",
    step="Figs. 7 and 8, Table I",
    find=find_experiment,
    holds=(
        Place("Fig. 7", "figure-trajectories"),
        Place("Fig. 8", "figure-tracking"),
        Place("Table I", "table1"),
    ),
    mentions=("calibration",),
    is_long=True,
)


def _printed_table_1_row(row: PublishedRow) -> dict[str, Any]:
    """Table I's row, in mm as it prints them."""
    printed: dict[str, Any] = {}
    for i in (0, 1):
        # To the two printed decimals, so that 0.03483 m is 34.83 mm again.
        printed[f"te{i + 1}_mean"] = round(1e3 * row.mean[i], 2)
        printed[f"te{i + 1}_sd"] = round(1e3 * row.standard_deviation[i], 2)
        printed[f"te{i + 1}_arrow"] = row.arrow[i]
    return printed


def _unstable_conditions(scene: Scene) -> set[tuple[float, float]]:
    """Return the conditions, N/m and s, that are unstable with the handles held by the study's agents.

    There is none where it is not known, because the target leaves an arm's reach.
    """
    from telespring.decision.arm_stability import arm_stability

    assert scene.study.experiment is not None
    connected = [(k, delay) for k, delay in scene.study.experiment.conditions if k is not None]
    held = arm_stability(scene.study, connected, scene.modules).conditions
    if not held:
        return set()
    return {each for each, condition in zip(connected, held, strict=True) if not condition.stable}


def _compare_with_table_1(
    rows: Sequence[Mapping[str, Any]], unstable: set[tuple[float, float]]
) -> dict[str, Any]:
    """Compare all means and arrows with the printed ones.

    The root mean square of the differences, mm, is over all cells, and without the unstable conditions. There
    is no arrow for TE2 in the unconnected mode, with which all others are compared.
    """
    cells = [(row, te) for row in rows if row["printed"] for te in ("te1", "te2")]
    means = [
        (row[f"{te}_mean"] - row["printed"][f"{te}_mean"], (row["stiffness"], row["delay"]) in unstable)
        for row, te in cells
        if row[f"{te}_mean"] is not None
    ]
    arrows = [(row, te) for row, te in cells if (row["stiffness"], te) != (None, "te2")]
    return {
        "cells": len(cells),
        "rms_difference": _root_mean_square([difference for difference, _ in means]),
        "unstable_conditions": [
            row["condition"] for row in rows if (row["stiffness"], row["delay"]) in unstable
        ],
        "rms_difference_stable": _root_mean_square(
            [difference for difference, swings in means if not swings]
        ),
        "arrows": len(arrows),
        "arrows_that_agree": sum(row[f"{te}_arrow"] == row["printed"][f"{te}_arrow"] for row, te in arrows),
    }


def _root_mean_square(values: Sequence[float]) -> float | None:
    return math.sqrt(statistics.fmean(value * value for value in values)) if values else None


def _condition_without_trials(condition: Mapping[str, Any]) -> dict[str, Any]:
    """Remove the values and labels of single trials, which the dataset has."""
    measures = {
        name: {
            key: (
                {k: v for k, v in value.items() if k not in ("values", "dyad_means")}
                if isinstance(value, dict)
                else value
            )
            for key, value in measure.items()
        }
        for name, measure in condition["measures"].items()
    }
    kept = {key: value for key, value in condition.items() if key not in ("trials", "dyads")}
    return {**kept, "measures": measures}


def _mean_tracking_errors(row: Mapping[str, Any]) -> str:
    means: Sequence[float | None] = (row["te1_mean"], row["te2_mean"])
    errors = " and ".join("none" if mean is None else f"{mean:.1f} mm" for mean in means)
    return f"{row['condition']}: {errors}."
