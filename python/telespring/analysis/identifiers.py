"""What identifies a trial: the name of its condition, its own number or label, and its dyad."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.layout import file_name, name_place, refuse_trials
from telespring.study.conditions import condition_labels, distinct_labels

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["TrialNames", "condition_names", "trial_dyads", "trial_files", "trial_numbers"]


@dataclass(frozen=True)
class TrialNames:
    """Names of trials in messages; the attributes are those of `telespring.analysis.Trials`."""

    labels: tuple[str, ...]
    numbers: NDArray[Any]
    dyads: NDArray[np.str_] | None
    files: NDArray[np.str_] | None

    def __call__(self, condition: int, trial: int) -> str:
        """Name one trial and its file if that is known, such as "trial 3 of UM (um-3.csv)"."""
        name = f"trial {self.number(condition, trial)} of {self.labels[condition]}"
        file = "" if self.files is None else str(self.files[condition, trial])
        return f"{name} ({file})" if file else name

    def number(self, condition: int, trial: int) -> str:
        """Name one trial within its condition, such as "3", or "3 of dyad B"."""
        dyad = "" if self.dyads is None else f" of dyad {self.dyads[condition, trial]}"
        return f"{self.numbers[condition, trial]}{dyad}"


def condition_names(dataset: xr.Dataset, stiffness: FloatArray, delay: FloatArray) -> tuple[str, ...]:
    """Return the dataset's own names of the conditions, else the paper's; two alike are numbered."""
    if "condition" in dataset.coords:
        return tuple(distinct_labels([str(label) for label in np.asarray(dataset["condition"])]))
    pairs = zip(stiffness.tolist(), delay.tolist(), strict=True)
    return tuple(condition_labels([(None if math.isnan(k) else k, d) for k, d in pairs]))


def trial_numbers(dataset: xr.Dataset, status: NDArray[np.str_]) -> NDArray[Any]:
    """Return the number or label of every trial of a checked dataset, (condition, trial); 0 if absent."""
    if "trial_number" in dataset.variables:
        values = np.asarray(dataset["trial_number"])
        present = status != "absent"
        numbers = np.where(present, values, 0)
        if numbers.dtype.kind == "f" and np.all(np.isfinite(numbers) & (numbers % 1.0 == 0.0)):
            numbers = numbers.astype(int)
        if numbers.dtype.kind not in "iu":
            raise refuse_trials(
                "trial_number", f"of type {values.dtype}", "a whole number for every trial is required"
            )
        return numbers
    if "trial" in dataset.coords:
        return np.broadcast_to(np.asarray(dataset["trial"]), status.shape)
    return np.broadcast_to(np.arange(1, status.shape[1] + 1), status.shape)


def trial_files(dataset: xr.Dataset) -> NDArray[np.str_] | None:
    """Return the name of the file of every trial, (condition, trial), "" where unknown; None without."""
    if "file" not in dataset.variables:
        return None
    values = np.asarray(dataset["file"])
    return np.array([file_name(value) for value in values.flat], dtype=str).reshape(values.shape)


def trial_dyads(dataset: xr.Dataset, status: NDArray[np.str_]) -> NDArray[np.str_] | None:
    """Return the label of the dyad of every trial of a checked dataset, (condition, trial); None without."""
    present = [name for name in ("dyad", "participant") if name in dataset.variables]
    if not present:
        return None
    if len(present) == 2:
        raise refuse_trials(
            "dyad",
            "beside participant",
            "only one of them is required",
            "Keep the one whose trials are dependent: usually the dyad.",
        )
    values = np.asarray(dataset[present[0]])
    labels = np.full(values.shape, "", dtype=object)
    for place, value in np.ndenumerate(values):
        if status[place] == "absent":
            continue
        value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        is_number = isinstance(value, (float, np.floating))
        is_missing = value is None or (is_number and math.isnan(float(value)))
        text = "" if is_missing else str(value).strip()
        if not text:
            raise refuse_trials(
                present[0],
                "missing",
                f"a label for every trial is required, and {name_place(dataset, *place)} has none",
                "Label every trial, or leave the variable out.",
            )
        labels[place] = text.removesuffix(".0") if is_number else text
    _check_spellings(present[0], sorted({str(label) for label in labels.flat if label}))
    return labels.astype(str)


def _check_spellings(field: str, labels: list[str]) -> None:
    """Refuse labels that differ only in case or spaces: one dyad would count twice."""
    spellings: dict[str, str] = {}
    for label in labels:
        other = spellings.setdefault("".join(label.casefold().split()), label)
        if other != label:
            raise refuse_trials(
                field,
                f"{other!r} and {label!r}",
                "labels that differ in more than case and spaces are required",
                "Write the label of a dyad in one way.",
            )
