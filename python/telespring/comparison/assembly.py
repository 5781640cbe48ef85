"""The dataset of a comparison: what its rehearsals left, side by side, with labels and units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._core import Study
from telespring.comparison.grounds import Place, find_grounds
from telespring.comparison.growth import GROWTH, PAID, have_run_away
from telespring.comparison.schedule import ComparisonSchedule
from telespring.comparison.spring_verdicts import SpringVerdicts
from telespring.rehearsal.encoding import STATUSES

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["assemble_comparison"]

_CELL = ("architecture", "network")
_PLACE = (*_CELL, "condition")

#: Dimensions behind those of the place, unit and meaning of every variable that is taken from the rehearsals.
_TAKEN: dict[str, tuple[tuple[str, ...], str, str]] = {
    "tracking_error": (("trial", "robot"), "m", "mean distance to the target (Eq. 15)"),
    "ended_at": (("trial",), "s", "time at which the trial ended early; NaN if it was completed"),
    "limited_share": (
        ("trial", "robot"), "1", "share of ticks at which the strategy gave less force than was wanted",
    ),
    "withheld_share": (("trial", "robot"), "1", "share of the wanted force that was withheld"),
    "given_out": (("trial", "robot"), "J", "energy given out at the handle"),
    "energy_sent": (("trial", "robot"), "J", "energy sent to the partner"),
    "coupling_energy": (
        ("trial",), "J", "energy that the coupling took at both handles less what it gave out there",
    ),
    "coupling_energy_minimum": (("trial",), "J", "smallest value of that at any tick"),
    "hand_energy": (("trial", "robot"), "J", "energy that the hand got"),
    "paid_share": (
        ("trial",), "1", "what the coupling gave over what the robots' damping took, after a quarter",
    ),
    "held_share": (("trial", "robot"), "1", "share of ticks at which an old sample was held"),
    "lost": (("trial", "robot"), "1", "packets that were lost"),
    "age_mean": (("robot",), "s", "mean age of the partner's samples as played"),
    "age_low": (("robot",), "s", "smallest age of the partner's samples as played"),
    "age_high": (("robot",), "s", "largest age of the partner's samples as played"),
    "within_age_range": (
        ("robot",), "1", "share of time with an age for which the verdict on an age in a range holds",
    ),
    "force_fidelity": (
        ("trial", "robot"), "1", "share of the force of the undelayed spring that was delivered",
    ),
    "force_gain": (("frequency",), "1", "delivered over intended force"),
    "force_phase": (("frequency",), "rad", "phase of the delivered over the intended force"),
    "force_coherence": (("frequency",), "1", "coherence of the delivered with the intended force"),
    "account": (("time", "robot"), "J", "balance of the account, first trial; NaN without one"),
    "position": (("time", "robot", "axis"), "m", "position of the handle, first trial"),
    "coupling_force": (("time", "robot", "axis"), "N", "force on the handle, first trial"),
}  # fmt: skip

#: What is judged of every place, and its meaning.
_JUDGED = {
    "verdict": "answer of `telespring decide` for the bare spring",
    "grounds": "why the strategy is safe there; empty if nothing proves it",
    "lack": "what the strategy lacks for that; empty if nothing",
}


def assemble_comparison(
    schedule: ComparisonSchedule, unconnected: xr.Dataset, cells: Mapping[str, xr.Dataset]
) -> xr.Dataset:
    """Lay the measured rehearsals out over architectures, networks and conditions.

    Parameters
    ----------
    schedule
        The comparison.
    unconnected
        What was measured without a partner.
    cells
        What was measured in each rehearsal, by its folder.

    Returns
    -------
    xarray.Dataset
        Conditions that a network does not have are NaN there; ``is_rehearsed`` tells.
    """
    import xarray as xr

    first = cells[schedule.cells[0].folder]
    places = {cell.folder: _places(cells[cell.folder], schedule) for cell in schedule.cells}
    variables: dict[str, Any] = {}
    for name, (dimensions, units, long_name) in _TAKEN.items():
        values = _spread(schedule, cells, places, name, dimensions)
        variables[name] = ((*_PLACE, *dimensions), values, {"units": units, "long_name": long_name})
    status = _spread(schedule, cells, places, "status", ("trial",), missing=-1, dtype=np.int8)
    quarters = _spread(schedule, cells, places, "quarter_error", ("trial", "robot", "quarter"))
    words = np.array([*STATUSES, ""])[status]
    paid = np.asarray(variables["paid_share"][1])
    diverged = have_run_away(words, quarters, np.asarray(unconnected["quarter_error"]), paid)
    with np.errstate(invalid="ignore", divide="ignore"):
        growth = quarters[..., 1] / quarters[..., 0]
    judged = _judge_places(schedule, cells, places)
    variables |= {
        "status": (
            (*_PLACE, "trial"),
            status,
            {
                "units": "1",
                "long_name": "how the trial ended; -1 if it was not run",
                "flag_values": np.arange(-1, len(STATUSES), dtype=np.int8),
                "flag_meanings": " ".join(["not_run", *(word.replace(" ", "_") for word in STATUSES)]),
            },
        ),
        "diverged": (
            (*_PLACE, "trial"),
            diverged,
            {
                "units": "1",
                "long_name": "whether the trial ran away",
                "growth_threshold": GROWTH,
                "paid_threshold": PAID,
            },
        ),
        "growth": (
            (*_PLACE, "trial", "robot"),
            growth,
            {"units": "1", "long_name": "error in the last over that in the first quarter of the trial"},
        ),
        **{
            name: (_PLACE, judged[name], {"units": "1", "long_name": long_name})
            for name, long_name in _JUDGED.items()
        },
        "guard_overdraft": (
            ("condition",),
            np.array([schedule.study.guard_overdraft(k).ratio for k, _ in schedule.conditions]),
            {"units": "1", "long_name": "overdraft of a guard's account over the robot's energy"},
        ),
        "is_rehearsed": (
            ("network", "condition"),
            _is_rehearsed(schedule, places),
            {"units": "1", "long_name": "whether the network has the condition"},
        ),
        "tracking_error_unconnected": (
            ("trial", "robot"),
            np.asarray(unconnected["tracking_error"]),
            {"units": "m", "long_name": "mean distance to the target without a partner"},
        ),
        "target": (("time", "axis"), np.asarray(first["target"]), {"units": "m", "long_name": "target"}),
    }
    return xr.Dataset(variables, coords=_coordinates(schedule, first), attrs=_attributes(schedule))


def _places(measured: xr.Dataset, schedule: ComparisonSchedule) -> list[int]:
    """Return the places of a rehearsal's conditions among all."""
    index = {(k, delay): place for place, (k, delay) in enumerate(schedule.conditions)}
    conditions = zip(measured["stiffness"].values.tolist(), measured["delay"].values.tolist(), strict=True)
    return [index[condition] for condition in conditions]


def _spread(
    schedule: ComparisonSchedule,
    cells: Mapping[str, xr.Dataset],
    places: Mapping[str, list[int]],
    name: str,
    dimensions: tuple[str, ...],
    *,
    missing: float = np.nan,
    dtype: Any = None,
) -> NDArray[Any]:
    """Lay a variable of all rehearsals out over architecture, network and condition."""
    example = cells[schedule.cells[0].folder][name].transpose("condition", *dimensions)
    shape = (len(schedule.labels), len(schedule.networks), len(schedule.conditions), *example.shape[1:])
    values = np.full(shape, missing, dtype=dtype or example.dtype)
    for cell in schedule.cells:
        measured = cells[cell.folder][name].transpose("condition", *dimensions)
        values[cell.architecture, cell.network, places[cell.folder]] = measured.values
    return values


def _is_rehearsed(schedule: ComparisonSchedule, places: Mapping[str, list[int]]) -> NDArray[np.bool_]:
    found = np.zeros((len(schedule.networks), len(schedule.conditions)), dtype=bool)
    for cell in schedule.cells:
        found[cell.network, places[cell.folder]] = True
    return found


def _judge_places(
    schedule: ComparisonSchedule, cells: Mapping[str, xr.Dataset], places: Mapping[str, list[int]]
) -> dict[str, NDArray[Any]]:
    """Ask at every place, with the ages of the samples that were used there, for spring and strategy."""
    shape = len(schedule.labels), len(schedule.networks), len(schedule.conditions)
    words = {name: np.full(shape, "", dtype=object) for name in _JUDGED}
    known: dict[Study, SpringVerdicts] = {}
    for cell in schedule.cells:
        # Of an architecture only the play-out counts for the bare spring.
        bare = cell.study.replace(session={"strategy": "spring", "predictor": "hold"})
        if bare not in known:
            known[bare] = SpringVerdicts(bare)
        asked = known[bare]
        measured = cells[cell.folder]
        ages = [
            measured[name].transpose("condition", "robot").values.tolist() for name in ("age_low", "age_high")
        ]
        for place, youngest, oldest in zip(places[cell.folder], *ages, strict=True):
            stiffness, delay = schedule.conditions[place]
            assert stiffness is not None  # a comparison has connected conditions only
            here = cell.architecture, cell.network, place
            verdict = asked.status(stiffness, delay, (youngest[0], youngest[1]), (oldest[0], oldest[1]))
            latest = asked.oldest(delay, (oldest[0], oldest[1]))
            grounds, lack = find_grounds(Place(cell.study, stiffness, delay, latest, verdict))
            words["verdict"][here], words["grounds"][here], words["lack"][here] = verdict, grounds, lack
    return words


def _coordinates(schedule: ComparisonSchedule, first: xr.Dataset) -> dict[str, Any]:
    def words(values: list[str]) -> NDArray[Any]:
        return np.array(values, dtype=object)

    def along(name: str, values: Any, units: str, long_name: str) -> tuple[str, Any, dict[str, str]]:
        return name, values, {"units": units, "long_name": long_name}

    parts = {}
    for name in ("strategy", "predictor", "playout"):
        part = words([getattr(each, name) for each in schedule.architectures])
        parts[name] = along("architecture", part, "1", name)
    stiffness, delay = np.array([tuple(each) for each in schedule.conditions], dtype=np.float64).T
    return {
        "architecture": along("architecture", words(list(schedule.labels)), "1", "what both sides do"),
        **parts,
        "network": along("network", words(list(schedule.networks)), "1", "name of the network"),
        "condition": along(
            "condition", words(schedule.condition_labels), "1", "stiffness in N/m and one-way delay in ms"
        ),
        "stiffness": along("condition", stiffness, "N/m", "stiffness of the virtual spring"),
        "delay": along("condition", delay, "s", "one-way delay, each way"),
        "trial": along("trial", first["trial"].values, "1", "number of the trial"),
        "robot": along("robot", np.array([1, 2]), "1", "number of the robot"),
        "axis": along("axis", words(["x", "y"]), "1", "axis of motion"),
        "time": along("time", first["time"].values, "s", "time since the beginning of the trial"),
        "frequency": along("frequency", first["frequency"].values, "Hz", "frequency of the force"),
    }


def _attributes(schedule: ComparisonSchedule) -> dict[str, Any]:
    experiment = schedule.experiment
    return {
        "name": schedule.study.name,
        "study": schedule.study.to_toml(),
        "duration": experiment.duration,
        "discard": experiment.discard,
        "trials": experiment.trials,
        "master_seed": np.uint64(experiment.seed),
    }
