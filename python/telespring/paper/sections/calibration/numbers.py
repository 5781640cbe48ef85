"""A calibration as `study.json` has it: tracking errors in mm, everything else in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.paper.calibration import (
    EVIDENCE,
    PREDICTION,
    Calibration,
    Confirmation,
    Explanation,
    Profile,
    PublishedRow,
    agreeing_arrows,
)
from telespring.paper.published import AGENT_STIFFNESS, TRIALS

__all__ = ["calibration_numbers", "equivalent_gain"]


def calibration_numbers(calibration: Calibration) -> dict[str, Any]:
    """Return the whole calibration; null stands for the error of an unstable dyad."""
    table = calibration.published
    return {
        "rules": {"evidence": EVIDENCE, "prediction": PREDICTION},
        "published": [
            {
                "condition": row.label,
                "stiffness": row.stiffness,
                "delay": row.delay if row.stiffness is not None else None,
                **_cells(row.mean, row.standard_deviation, row.arrow),
            }
            for row in table
        ],
        "hypotheses": [_explanation_json(each, table) for each in calibration.explanations],
        "equivalent_coupling_gain": equivalent_gain(calibration),
        "laboratory": [
            {"trials": calibration.trials, **_confirmation_json(each, table)}
            for each in calibration.confirmations
        ],
        "unexplained": [
            {
                "condition": table[i].label,
                "robot": robot + 1,
                "standard_error": 1e3 * table[i].standard_deviation[robot] / TRIALS**0.5,
                "misses": {
                    each.name: 1e3 * float(each.errors[i, robot] - table[i].mean[robot])
                    for each in calibration.supported
                },
            }
            for i, robot in calibration.unexplained
        ],
    }


def equivalent_gain(calibration: Calibration) -> dict[str, Any] | None:
    """Return the coupling gain at the printed agent stiffness that is the same as the fitted stiffness."""
    for each in calibration.explanations:
        if "agent_stiffness" in each.values and "agent_stiffness" in each.profiles:
            low, high = each.profiles["agent_stiffness"].interval
            return {
                "value": AGENT_STIFFNESS / each.values["agent_stiffness"],
                "interval": [AGENT_STIFFNESS / high, AGENT_STIFFNESS / low],
            }
    return None


def _explanation_json(explanation: Explanation, table: Sequence[PublishedRow]) -> dict[str, Any]:
    hypothesis, scores = explanation.hypothesis, explanation.scores
    parameters = () if hypothesis is None else hypothesis.parameters
    own = set() if hypothesis is None else {parameter.name for parameter in hypothesis.own}
    return {
        "name": explanation.name,
        "parameters": {
            each.name: {
                "value": explanation.values[each.name],
                "unit": each.unit,
                "meaning": each.meaning,
                "own": each.name in own,
                "searched": [each.low, each.high],
                **_profile_json(explanation.profiles.get(each.name)),
            }
            for each in parameters
        },
        "fixed": {} if hypothesis is None else dict(hypothesis.fixed),
        "rms_all": _millimetres(explanation.rms_all),
        "rms_held_out": _millimetres(explanation.rms_held_out),
        "rms_leave_one_stiffness_out": _millimetres(explanation.rms_leave_one_stiffness_out),
        "unstable": [
            row.label
            for row, errors in zip(table, explanation.errors, strict=True)
            if not np.isfinite(errors).all()
        ],
        "unstable_left_out": [table[i].label for i in explanation.unstable_left_out],
        "split": None if explanation.split_interval is None else _profile_json(explanation.split_interval),
        "aicc": finite_or_none(explanation.aicc),
        "rank_correlation": {cells: each.rank_correlation for cells, each in scores.items()},
        "arrows": _arrows_json(explanation.arrows, table),
        "criteria": None if explanation.criteria is None else dict(vars(explanation.criteria)),
        "verdict": explanation.verdict,
        "cells": [
            {"condition": row.label, "te1": _millimetres(errors[0]), "te2": _millimetres(errors[1])}
            for row, errors in zip(table, explanation.errors.tolist(), strict=True)
        ],
    }


def _profile_json(profile: Profile | None) -> dict[str, Any]:
    if profile is None:
        return {"interval": None, "open_below": None, "open_above": None, "profile": None}
    return {
        "interval": list(profile.interval),
        "open_below": profile.open_below,
        "open_above": profile.open_above,
        "profile": {"values": profile.values.tolist(), "deviance_rise": profile.rise.tolist()},
    }


def _confirmation_json(confirmation: Confirmation, table: Sequence[PublishedRow]) -> dict[str, Any]:
    prediction = confirmation.prediction
    return {
        "name": confirmation.name,
        "rms_all": _millimetres(confirmation.rms_all),
        "largest_difference": _millimetres(confirmation.largest_difference),
        "arrows": _arrows_json(prediction.arrow, table),
        "cells": [
            {
                "condition": row.label,
                **_cells(prediction.mean[i], prediction.standard_deviation[i], prediction.arrow[i]),
                "ended_early": prediction.ended_early[i],
            }
            for i, row in enumerate(table)
        ],
    }


def _arrows_json(arrows: Sequence[tuple[str, str]], table: Sequence[PublishedRow]) -> dict[str, Any]:
    agrees = [one for pair in agreeing_arrows(arrows, table) for one in pair if one is not None]
    return {"agreeing": sum(agrees), "of": len(agrees)}


def _cells(
    mean: FloatArray | tuple[float, float],
    deviation: FloatArray | tuple[float, float],
    arrow: tuple[str, str],
) -> dict[str, Any]:
    return {
        key: value
        for robot in (0, 1)
        for key, value in (
            (f"te{robot + 1}_mean", _millimetres(float(mean[robot]))),
            (f"te{robot + 1}_sd", _millimetres(float(deviation[robot]))),
            (f"te{robot + 1}_arrow", arrow[robot]),
        )
    }


def _millimetres(length: float) -> float | None:
    return finite_or_none(1e3 * length)
