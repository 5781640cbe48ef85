"""Shares of a survey of dyads added up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._errors import InvalidInput

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["merge_surveys"]


def merge_surveys(surveys: Sequence[xr.Dataset]) -> xr.Dataset:
    """Add the shares of a survey up.

    Parameters
    ----------
    surveys : sequence of xarray.Dataset
        Results of `survey_dyads` for one population, each with its `shard`; also read from files.

    Returns
    -------
    xarray.Dataset
        What `survey_dyads` returns without shares.

    Raises
    ------
    InvalidInput
        If a share is missing or there twice, or if they are of different populations or maps.

    Examples
    --------
    >>> import telespring as ts
    >>> shares = [ts.survey_dyads(1000, cells=(2, 2), shard=(index, 3)) for index in (1, 2, 3)]
    >>> ts.merge_surveys(shares).identical(ts.survey_dyads(1000, cells=(2, 2)))
    True
    """
    if not surveys:
        raise InvalidInput("surveys", "[]", "at least one survey", "Give the results of survey_dyads.")
    first = surveys[0]
    for other in surveys[1:]:
        if _population(other) != _population(first):
            raise InvalidInput(
                "surveys", "", "surveys of one population on one map", "Give the shares of one survey_dyads."
            )
    _require_all_shares([each.attrs.get("shard") for each in surveys])
    whole = first.drop_attrs(deep=False).assign_attrs(_plain_attributes(first))
    for other in surveys[1:]:
        for name in ("dyads", "unsafe", "histogram"):
            whole[name] = whole[name].copy(data=whole[name].values + other[name].values)
        whole["largest"] = whole["largest"].copy(
            data=np.maximum(whole["largest"].values, other["largest"].values)
        )
    return whole


def _plain_attributes(survey: xr.Dataset) -> dict[str, Any]:
    """Return the attributes but for the share, as they were before the survey was written to a file."""
    found = {name: np.asarray(value).tolist() for name, value in survey.attrs.items()}
    found.pop("shard", None)
    return found


def _population(survey: xr.Dataset) -> tuple[Any, ...]:
    """Return what shares of one survey have in common."""
    coordinates = [survey[name].values.tolist() for name in ("mass_ratio", "damping_ratio")]
    return _plain_attributes(survey), coordinates


def _require_all_shares(named: Sequence[str | None]) -> None:
    """Refuse shares of which one is missing, given twice, or of another division."""
    if len(named) == 1 and named[0] is None:
        return  # a whole survey
    counts = {None if each is None else each.partition("/")[2] for each in named}
    needed = {f"{index}/{len(named)}" for index in range(1, len(named) + 1)}
    if set(named) != needed:
        count = counts.pop() if len(counts) == 1 else None
        allowed = "all shares of one division" if count is None else f"all {count} shares"
        raise InvalidInput(
            "surveys",
            ", ".join("a whole survey" if each is None else each for each in named),
            f"{allowed}, each once, are required",
            "Give the results of survey_dyads with shard=(1, n) to shard=(n, n).",
        )
