"""Check a dataset of trials exactly: dimensions, labels, units, numbers, and how every trial ended."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "PER_SAMPLE",
    "PER_TRIAL",
    "STATUSES",
    "check_layout",
    "file_name",
    "name_place",
    "refuse_trials",
    "trial_statuses",
]

PER_TRIAL = ("condition", "trial")
PER_SAMPLE = (*PER_TRIAL, "time", "robot", "axis")

#: How a trial may end; "absent" stands for a trial that a condition does not have.
STATUSES = (
    "completed",
    "stopped",
    "diverged",
    "out of reach",
    "too stiff",
    "aborted",
    "failed",
    "absent",
)

#: Variables over (condition, trial, time, robot, axis): only the first is required.
_SIGNALS = ("position", "velocity", "coupling_force", "agent_force")
#: Labels by which robots and axes are put in order.
_LABELS: dict[str, tuple[Any, ...]] = {"robot": (1, 2), "axis": ("x", "y")}
#: Spellings of SI units by variable; no unit at all is taken as SI.
_METRES, _NEWTONS = ("m", "meter", "meters", "metre", "metres"), ("N", "newton", "newtons")
_SECONDS = ("s", "sec", "second", "seconds")
_UNITS = {
    "position": _METRES,
    "target": _METRES,
    "velocity": ("m/s", "m s-1", "m s^-1", "m*s-1", "m.s-1"),
    "coupling_force": _NEWTONS,
    "agent_force": _NEWTONS,
    "stiffness": ("N/m", "N m-1", "N m^-1", "N*m-1", "N.m-1"),
    "delay": _SECONDS,
    "time": _SECONDS,
    "ended_at": _SECONDS,
}


def check_layout(dataset: xr.Dataset) -> xr.Dataset:
    """Check a dataset of trials and return it in one form: exact dimensions, robots 1 and 2, axes x and y.

    What has one meaning only is repaired: a variable that was repeated along another dimension, as
    `xarray.concat` does, loses it if all repetitions are equal; a dimension of a single condition or trial
    that was dropped by indexing comes back; robots and axes are put in the order of their labels. The
    target is over condition or trial only where it changes along them. Everything else is refused.

    Raises
    ------
    telespring.InvalidInput
        If a variable is missing or has other dimensions, a number is of another type or unit, or a label of
        robots or axes is not one of theirs.
    """
    import xarray as xr

    if not isinstance(dataset, xr.Dataset):
        raise refuse_trials("dataset", type(dataset).__name__, "an xarray.Dataset of trials is required")
    for name, over in (("position", PER_SAMPLE), ("target", ("time", "axis"))):
        if name not in dataset.variables:
            raise refuse_trials(
                name,
                "missing",
                f"{name} over {', '.join(over)} is required",
                f"Add it: dataset[{name!r}] = ({over!r}, values), in m.",
            )
    for name in ("time", "stiffness", "delay"):
        if name not in dataset.variables:
            raise refuse_trials(name, "missing", f"a coordinate {name} is required")
    dataset = _order_labels(dataset)
    checked: dict[str, xr.DataArray] = {}
    for name in _SIGNALS:
        if name in dataset.variables:
            checked[name] = _in_dimensions(_numbers(dataset, name), PER_SAMPLE)
    if "trial" not in dataset["position"].dims and "trial" not in dataset.coords:
        # Indexing leaves the label of the trial behind; a mean over trials does not.
        raise refuse_trials(
            "position",
            f"over {', '.join(str(name) for name in dataset['position'].dims)}",
            f"position over {', '.join(PER_SAMPLE)} is required: single trials, not their mean",
        )
    sizes = checked["position"].sizes
    if sizes["robot"] != 2 or sizes["axis"] != 2 or 0 in sizes.values():
        raise refuse_trials(
            "position",
            " × ".join(f"{sizes[name]} {name}" for name in PER_SAMPLE),
            "two robots, two axes and at least one condition, trial and sample are required",
        )
    checked["target"] = _check_target(_numbers(dataset, "target"))
    for name, dimensions in (
        ("time", ("time",)),
        ("stiffness", ("condition",)),
        ("delay", ("condition",)),
        ("ended_at", PER_TRIAL),
        ("samples", PER_TRIAL),
    ):
        if name in dataset.variables:
            checked[name] = _in_dimensions(_numbers(dataset, name), dimensions)
    for name in ("status", "seed", "trial_number", "dyad", "participant"):
        if name in dataset.variables:
            broadcast = name in ("dyad", "participant")
            checked[name] = _in_dimensions(dataset[name], PER_TRIAL, sizes if broadcast else None)
    # Names of files only help to find a trial: something else of that name is left alone.
    if "file" in dataset.variables and set(dataset["file"].dims) <= set(PER_TRIAL):
        checked["file"] = _in_dimensions(dataset["file"], PER_TRIAL, sizes)
    for name, values in checked.items():
        _check_sizes(name, values, sizes)
    return xr.Dataset(
        {name: values.variable for name, values in checked.items()}, attrs=dataset.attrs
    ).assign_coords(_plain_labels(dataset))


def _plain_labels(dataset: xr.Dataset) -> dict[str, tuple[str, NDArray[Any]]]:
    """Return the labels of conditions and trials, of robots and of axes, where they are plain values."""
    labels: dict[str, tuple[str, NDArray[Any]]] = {}
    for name in (*PER_TRIAL, "robot", "axis"):
        if name not in dataset.coords or dataset[name].ndim > 1:
            continue
        found = [_plain_label(label) for label in np.ravel(np.asarray(dataset[name]))]
        # A multi-index has tuples; its levels are variables of their own.
        if all(isinstance(label, str) for label in found):
            labels[name] = name, np.array(found, dtype=object)
        elif name != "condition" and all(isinstance(label, (int, float)) for label in found):
            is_whole = all(float(label).is_integer() for label in found)
            labels[name] = name, np.array(found, dtype=int if is_whole else float)
    return labels


def trial_statuses(dataset: xr.Dataset) -> NDArray[np.str_]:
    """Decode how every trial of a checked dataset ended, (condition, trial).

    Words, or numbers with ``flag_values`` and ``flag_meanings`` as the CF conventions write them. A trial
    without a status is absent if it has no position at all, as after `reindex` or an outer join.
    """
    if "status" not in dataset.variables:
        return np.full((dataset.sizes["condition"], dataset.sizes["trial"]), "completed")
    status = dataset["status"]
    words = _flag_words(status)
    empty = ~np.isfinite(np.asarray(dataset["position"])).any(axis=(2, 3, 4))
    decoded = np.empty(status.shape, dtype=object)
    for place, raw in np.ndenumerate(np.asarray(status)):
        decoded[place] = _status_word(raw, words)
        if decoded[place] is None and empty[place]:
            decoded[place] = "absent"
        if decoded[place] not in STATUSES:
            raise _unknown_status(raw, words, name_place(dataset, *place))
    return decoded.astype(str)


def _flag_words(status: xr.DataArray) -> dict[int, str] | None:
    """Return the words of a status that is stored as numbers; None if it is stored as words."""
    if status.dtype.kind in "OUST":
        return None
    meanings = str(status.attrs.get("flag_meanings", "")).split()
    flags = np.ravel(status.attrs.get("flag_values", [])).tolist()
    if status.dtype.kind not in "iuf" or len(meanings) != len(flags) or not flags:
        raise InvalidInput(
            "status",
            f"of type {status.dtype}, without its meanings",
            f"words ({', '.join(STATUSES)}), or numbers with the attributes flag_values and flag_meanings, "
            "are required",
            "Keep the attributes (xarray.set_options(keep_attrs=True)), or write words.",
        )
    return {int(flag): meaning for flag, meaning in zip(flags, meanings, strict=True)}


def _status_word(raw: Any, words: dict[int, str] | None) -> str | None:
    """Return the word for a stored status, None where there is none."""
    if raw is None or (isinstance(raw, (float, np.floating)) and not math.isfinite(raw)):
        return None
    if words is not None:
        whole = int(raw)
        raw = words.get(whole) if whole == raw else None
        if raw is None:
            return "unknown"
    text = raw.decode("utf-8", "replace") if isinstance(raw, bytes) else str(raw)
    return " ".join(text.casefold().replace("_", " ").split()) or None


def name_place(dataset: xr.Dataset, condition: int, trial: int) -> str:
    """Name a trial of a checked dataset by its labels, such as "trial 3 of UM", or by its place from 1.

    With the name of its file, if that is known.
    """
    number: Any = trial + 1
    if "trial_number" in dataset.variables:
        number = f"{float(dataset['trial_number'][condition, trial]):g}"
    elif "trial" in dataset.coords:
        number = np.asarray(dataset["trial"])[trial]
    label: Any = f"condition {condition + 1}"
    if "condition" in dataset.coords:
        label = np.asarray(dataset["condition"])[condition]
    file = file_name(np.asarray(dataset["file"])[condition, trial]) if "file" in dataset.variables else ""
    return f"trial {number} of {label}{f' ({file})' if file else ''}"


def file_name(value: Any) -> str:
    """Return the name of a trial's file, "" where it is missing (a join or reindex leaves NaN)."""
    value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return str(value) if isinstance(value, str) else ""


def _unknown_status(raw: Any, words: dict[int, str] | None, where: str) -> InvalidInput:
    text = raw.decode("utf-8", "replace") if isinstance(raw, bytes) else str(raw)
    if words is not None and text != "nan":
        allowed = f"one of {', '.join(str(flag) for flag in words)} is required"
    else:
        allowed = f"one of {', '.join(STATUSES)} is required"
    missing = text in ("nan", "None", "")
    return InvalidInput(
        "status",
        f"missing, {where}" if missing else f"{text}, {where}",
        allowed,
        "Write how this trial ended; it has positions." if missing else "Correct it, or add its meaning.",
    )


def refuse_trials(field: str, value: str, allowed: str, remedy: str = "") -> InvalidInput:
    """Return the refusal of a dataset that does not hold trials."""
    return InvalidInput(
        field,
        value,
        allowed,
        remedy or "help(telespring.analysis.Trials.from_dataset) describes what a dataset of trials holds.",
    )


def _order_labels(dataset: xr.Dataset) -> xr.Dataset:
    """Put robots and axes in the order of their labels; places alone would exchange them."""
    for name, labels in _LABELS.items():
        if name not in dataset.coords or dataset[name].dims != (name,):
            continue
        found = [_plain_label(label) for label in np.asarray(dataset[name])]
        if found == list(labels):
            continue
        shown = ", ".join(str(label) for label in found)
        if len(found) != len(labels) or set(found) != set(labels):
            allowed = " and ".join(str(label) for label in labels)
            raise refuse_trials(
                name,
                shown,
                f"the labels {allowed} are required",
                f"Select both, or name them: dataset.assign_coords({name}={list(labels)}).",
            )
        dataset = dataset.isel({name: [found.index(label) for label in labels]})
    return dataset


def _plain_label(label: Any) -> Any:
    label = label.decode("utf-8", "replace") if isinstance(label, bytes) else label
    return label.item() if isinstance(label, np.generic) else label


def _numbers(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return a variable as float64, after a check of its type and unit."""
    values = dataset[name]
    kind = values.dtype.kind
    if kind == "m":
        return values.astype("timedelta64[ns]").astype(np.int64) / 1e9
    if kind == "O":
        try:
            values = values.astype(float)
            kind = "f"
        except (TypeError, ValueError):
            pass
    if kind not in "fiu":
        raise refuse_trials(name, f"of type {dataset[name].dtype}", "real numbers are required")
    unit = values.attrs.get("units")
    allowed = _UNITS.get(name)
    if unit is not None and allowed is not None and str(unit).strip() not in allowed:
        raise InvalidInput(
            name,
            f"in {unit}",
            f"{allowed[0]} is required",
            f"Convert the values, and set the attribute units to {allowed[0]}.",
        )
    return values.astype(float)


def _in_dimensions(values: xr.DataArray, dimensions: Sequence[str], broadcast: Any = None) -> xr.DataArray:
    """Return a variable over exactly these dimensions, in this order.

    Another dimension goes if all its values are equal; one that is missing comes back with the size 1, or
    with its size in `broadcast`, and is refused later if the trials have more.
    """
    for extra in [name for name in values.dims if name not in dimensions]:
        values = _without(values, extra, dimensions)
    missing = [name for name in dimensions if name not in values.dims]
    values = values.drop_vars(list(values.coords))
    values = values.expand_dims({name: 1 if broadcast is None else broadcast[name] for name in missing})
    return values.transpose(*dimensions)


def _without(values: xr.DataArray, extra: Hashable, dimensions: Sequence[str]) -> xr.DataArray:
    """Remove a dimension along which nothing changes."""
    array = np.asarray(values)
    along = values.get_axis_num(extra)
    assert isinstance(along, int)
    first = np.take(array, [0], axis=along) if array.shape[along] else array
    is_float = array.dtype.kind == "f"
    if array.shape[along] == 0 or not np.array_equal(
        array, np.broadcast_to(first, array.shape), equal_nan=is_float
    ):
        missing = [name for name in dimensions if name not in values.dims]
        raise refuse_trials(
            str(values.name),
            f"over {', '.join(str(name) for name in values.dims)}",
            f"{values.name} over {', '.join(dimensions)} is required, and it changes along {extra}",
            f"If {extra} stands for {' or '.join(missing)}, rename it (.rename, .swap_dims or .unstack)."
            if missing
            else f"Select one {extra}, for example with .isel({extra}=0).",
        )
    return values.isel({extra: 0}, drop=True)


def _check_target(target: xr.DataArray) -> xr.DataArray:
    """Return the target over time and axis, and over condition and trial where it is not the same in all."""
    target = _in_dimensions(target, (*PER_TRIAL, "time", "axis"))
    for name in PER_TRIAL:
        first = target.isel({name: 0}, drop=True)
        if target.sizes[name] == 1 or bool(np.all(np.asarray(target == first))):
            target = first
    dimensions = [name for name in PER_SAMPLE if name in target.dims]
    return target.transpose(*dimensions)


def _check_sizes(name: str, values: xr.DataArray, sizes: Any) -> None:
    """Refuse a variable that lacks a dimension of which the trials have more than one."""
    for dimension in values.dims:
        if values.sizes[dimension] != sizes[dimension]:
            raise refuse_trials(
                name,
                f"{values.sizes[dimension]} {dimension}",
                f"{name} must have {sizes[dimension]} {dimension}, as position has",
            )
