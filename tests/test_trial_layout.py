"""A dataset of trials after the usual operations of xarray: the same numbers and labels, or a refusal."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import telespring as ts
from made_trials import PER_SAMPLE, offsets, small
from telespring.analysis import Trials, analyse_trials, measure, read_recorded, write_recorded
from telespring.analysis.sources import open_trials
from telespring.cli import app
from telespring.show.drawings.trials import draw_errors, draw_trajectories

FLAGS = ("completed", "diverged", "out of reach", "too stiff", "absent")
CONDITIONS = [(math.nan, 0.0), (36.0, 0.0), (36.0, 0.167)]
PER_TRIAL = ("condition", "trial")

Operation = Callable[[xr.Dataset], xr.Dataset]


def coded(dataset: xr.Dataset) -> xr.Dataset:
    """Write the status as a rehearsal does, in numbers with their meanings."""
    codes = np.vectorize(FLAGS.index)(np.asarray(dataset["status"])).astype(np.int8)
    meanings = " ".join(word.replace(" ", "_") for word in FLAGS)
    attributes = {"flag_values": np.arange(len(FLAGS), dtype=np.int8), "flag_meanings": meanings}
    return dataset.assign(status=(PER_TRIAL, codes, attributes))


def concatenated(name: str, **options: Any) -> Operation:
    def operation(dataset: xr.Dataset) -> xr.Dataset:
        parts = [dataset.isel({name: slice(0, 1)}), dataset.isel({name: slice(1, None)})]
        return xr.concat(parts, dim=name, **options)

    return operation


def merged(dataset: xr.Dataset) -> xr.Dataset:
    return xr.merge([dataset[["position", "target"]], dataset.drop_vars(["position", "target"])])


def outer(dataset: xr.Dataset) -> xr.Dataset:
    """Combine conditions that have different trials: what is missing is filled with NaN."""
    parts = [
        dataset.isel(condition=[0]),
        dataset.isel(condition=[1], trial=[0, 1]),
        dataset.isel(condition=[2]),
    ]
    return xr.concat(parts, dim="condition", join="outer", data_vars="all")


SAME: dict[str, Operation] = {
    "transposed": lambda dataset: dataset.transpose("axis", "time", "trial", "robot", "condition"),
    "concatenated trials": concatenated("trial", data_vars="all", coords="minimal", compat="override"),
    "concatenated trials, all coordinates": concatenated("trial", data_vars="all", coords="all"),
    "concatenated conditions": concatenated("condition", data_vars="all"),
    "concatenated with an outer join": outer,
    "merged": merged,
    "robots the other way round": lambda dataset: dataset.isel(robot=[1, 0]),
    "axes the other way round": lambda dataset: dataset.isel(axis=[1, 0]),
    "target of every trial": lambda dataset: dataset.assign(
        target=dataset["target"].broadcast_like(dataset["position"].isel(robot=0, drop=True))
    ),
    "target of every robot": lambda dataset: dataset.assign(
        target=dataset["target"].expand_dims(robot=[1, 2])
    ),
    "status where trials exist": lambda dataset: dataset.where(
        dataset["position"].notnull().any(PER_SAMPLE[2:])
    ),
    "without labels": lambda dataset: dataset.drop_vars(["condition", "trial", "robot", "axis"]),
    "object numbers": lambda dataset: dataset.assign(position=dataset["position"].astype(object)),
}


def same_numbers(found: xr.Dataset, expected: xr.Dataset) -> None:
    for name in expected.data_vars:
        one, other = np.asarray(found[name]), np.asarray(expected[name])
        if one.dtype.kind == "U":
            assert np.array_equal(one, other), name
        else:
            # sums in another order
            assert one == pytest.approx(other, rel=1e-9, nan_ok=True), name


@pytest.mark.parametrize("how", SAME)
@pytest.mark.parametrize("encode", [lambda dataset: dataset, coded], ids=["words", "flags"])
def test_law_the_usual_operations_change_no_number(how: str, encode: Operation) -> None:
    dataset = encode(small())
    same_numbers(measure(SAME[how](dataset)), measure(small()))


def test_law_a_table_and_back_changes_no_number() -> None:
    """Every variable then has all dimensions."""
    dataset = small().isel(time=slice(0, 90))
    dataset["status"][:] = "completed"
    filled = dataset.fillna(dict.fromkeys(("position", "velocity", "coupling_force", "agent_force"), 0.0))
    filled["position"] = filled["position"].fillna(0.0)
    filled = filled.drop_vars(["seed", "ended_at"]).reset_coords(["stiffness", "delay"])
    back = filled.to_dataframe().to_xarray().sel(condition=filled["condition"])
    same_numbers(measure(back, 0.5), measure(filled, 0.5))


def test_law_float32_changes_numbers_in_the_seventh_digit() -> None:
    dataset = small()
    rounded = dataset.map(lambda values: values.astype("float32") if values.dtype.kind == "f" else values)
    rounded = rounded.assign_coords(time=dataset["time"].astype("float32"))
    # 0.5 s is a sample, and stays the first that is analysed
    assert np.array_equal(Trials.from_dataset(rounded).window, Trials.from_dataset(dataset).window)
    late = dataset.assign_attrs(discard=0.7)
    late32 = late.assign_coords(time=late["time"].astype("float32"))
    assert np.array_equal(Trials.from_dataset(late32).window, Trials.from_dataset(late).window)
    found, expected = measure(rounded), measure(dataset)
    for name in ("tracking_error", "interaction_force_rms", "effort_rms"):
        assert np.asarray(found[name]) == pytest.approx(np.asarray(expected[name]), rel=1e-5, nan_ok=True)


@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
def test_law_a_file_of_any_engine_has_the_same_numbers(
    engine: Literal["h5netcdf", "scipy"], tmp_path: Path
) -> None:
    dataset = small().drop_vars("seed")
    for name, each in (("words", dataset), ("flags", coded(dataset))):
        each.to_netcdf(tmp_path / f"{name}.nc", engine=engine)
        same_numbers(measure(open_trials(tmp_path / f"{name}.nc")), measure(dataset))


def test_law_one_condition_or_trial_is_measured_as_it_is() -> None:
    dataset = small()
    alone = measure(dataset.isel(condition=2, trial=0))
    expected = measure(dataset).isel(condition=[2], trial=[0])
    same_numbers(alone, expected)
    assert alone["trial"].values.tolist() == [1]
    assert alone["condition"].values.tolist() == ["CM-36-167"]
    same_numbers(measure(dataset.isel(condition=2)), measure(dataset).isel(condition=[2]))


def test_law_a_trial_that_a_join_adds_is_absent() -> None:
    for dataset in (small(), coded(small())):
        more = dataset.reindex(trial=[1, 2, 3, 9])
        rows, before = analyse_trials(more)["table1"], analyse_trials(dataset)["table1"]
        assert rows == before
        assert Trials.from_dataset(more).status[:, 3].tolist() == ["absent"] * 3


def wrong_status(values: Any, **attributes: Any) -> xr.Dataset:
    return small().assign(status=(PER_TRIAL, values, attributes))


def replaced(name: str, change: Callable[[xr.DataArray], xr.DataArray]) -> xr.Dataset:
    dataset = small()
    return dataset.assign({name: change(dataset[name])})


def with_units(name: str, units: str) -> xr.Dataset:
    dataset = small()
    dataset[name].attrs["units"] = units
    return dataset


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "float status": (lambda: wrong_status(np.zeros((3, 3))), "of type float64, without its meanings"),
    "bare integers": (lambda: wrong_status(np.zeros((3, 3), dtype=int)), "flag_values and flag_meanings"),
    "unknown flag": (
        lambda: wrong_status(np.full((3, 3), 7), flag_values=[0, 1], flag_meanings="completed diverged"),
        "7, trial 1 of UM: one of 0, 1 is required",
    ),
    "unknown word": (
        lambda: wrong_status(np.full((3, 3), "complete")),
        "complete, trial 1 of UM: one of completed, stopped",
    ),
    "no status of a trial with positions": (
        lambda: coded(small()).assign(status=lambda each: each["status"].where(each["trial"] != 1)),
        "missing, trial 1 of UM",
    ),
    "unknown word of a trial with a number": (
        lambda: wrong_status(np.full((3, 3), "done")).isel(condition=[2], trial=[1, 2]),
        "done, trial 2 of CM-36-167: one of",
    ),
    "truth values": (lambda: wrong_status(np.full((3, 3), True)), "of type bool"),
    "target of each robot": (
        lambda: replaced(
            "target", lambda each: each.expand_dims(robot=[1, 2]) * xr.DataArray([1.0, 2.0], dims="robot")
        ),
        "it changes along robot",
    ),
    "another dimension": (
        lambda: replaced(
            "position", lambda each: each.expand_dims(day=2) * xr.DataArray([1.0, 2.0], dims="day")
        ),
        "it changes along day",
    ),
    "force of one robot": (
        lambda: replaced("coupling_force", lambda each: each.isel(robot=0, drop=True)),
        "coupling_force must have 2 robot, as position has",
    ),
    "status of a condition": (
        lambda: replaced("status", lambda each: each.isel(trial=0, drop=True)),
        "status must have 3 trial, as position has",
    ),
    "labels of robots": (lambda: small().assign_coords(robot=[0, 1]), "the labels 1 and 2 are required"),
    "labels of axes": (lambda: small().assign_coords(axis=["y", "z"]), "the labels x and y are required"),
    "one robot": (lambda: small().isel(robot=[0]), "the labels 1 and 2 are required"),
    "a dropped robot": (lambda: small().isel(robot=0, drop=True), "two robots, two axes"),
    "millimetres": (lambda: with_units("position", "mm"), "position = in mm: m is required"),
    "milliseconds": (lambda: with_units("delay", "ms"), "delay = in ms: s is required"),
    "text": (lambda: replaced("position", lambda each: each.astype(str)), "real numbers are required"),
    "complex numbers": (lambda: replaced("position", lambda each: each + 0j), "real numbers are required"),
    "a condition that a join adds": (
        lambda: small().reindex(condition=["UM", "CM-36-0", "CM-36-500"]),
        "a delay of 0 s or more for every condition is required",
    ),
    "a stiffness of zero": (
        lambda: small().assign_coords(stiffness=("condition", [0.0, 36.0, 36.0])),
        "a stiffness above 0 N/m is required",
    ),
    "samples": (
        lambda: small().assign(samples=(PER_TRIAL, np.full((3, 3), 50.5))),
        "a whole number of samples for every completed trial",
    ),
    "discard": (lambda: small().assign_attrs(discard="two"), "the attribute must be a time in s"),
    "a variable": (lambda: small()["position"], "an xarray.Dataset of trials is required"),
    "mean of the trials": (
        lambda: small().drop_vars("status").mean("trial"),
        "single trials, not their mean",
    ),
    "another name of a dimension": (
        lambda: small().rename(trial="repetition"),
        "If repetition stands for trial, rename it",
    ),
    "stacked": (lambda: small().stack(place=PER_TRIAL), "position"),
    "dyad and participant": (
        lambda: small().assign(
            dyad=(PER_TRIAL, np.full((3, 3), "a")), participant=(PER_TRIAL, np.full((3, 3), "a"))
        ),
        "only one of them",
    ),
    "a dyad in two spellings": (
        lambda: small().assign(dyad=("trial", ["Dyad 1", "dyad1", "dyad 2"])),
        "'Dyad 1' and 'dyad1': labels that differ in more than case and spaces are required",
    ),
    "no dyad": (
        lambda: small().assign(dyad=(PER_TRIAL, [["a", "", "a"]] * 3)),
        "a label for every trial is required, and trial 2 of UM has none",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_law_what_has_no_one_meaning_is_refused(what: str) -> None:
    make, words = REFUSED[what]
    with pytest.raises(ts.InvalidInput, match=re.escape(words)):
        measure(make())


def test_law_times_as_durations_are_seconds() -> None:
    dataset = small()
    durations = pd.to_timedelta(np.asarray(dataset["time"]), unit="s")
    same_numbers(measure(dataset.assign_coords(time=durations)), measure(dataset))


def test_law_a_dyad_may_be_named_once_for_all_conditions() -> None:
    per_trial = Trials.from_dataset(small().assign(dyad=("trial", [1.0, 2.0, 2.0])))
    assert per_trial.dyads is not None
    assert per_trial.dyads.tolist() == [["1", "2", "2"], ["1", "2", ""], ["1", "2", "2"]]
    per_condition = Trials.from_dataset(small().assign(participant=("condition", ["a", "b", "c"])))
    assert per_condition.dyads is not None
    assert per_condition.dyads.tolist() == [["a"] * 3, ["b", "b", ""], ["c"] * 3]


def test_law_the_command_analyses_what_was_concatenated_and_refuses_a_bare_status(tmp_path: Path) -> None:
    runner = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"})

    def analysed(dataset: xr.Dataset, name: str) -> Result:
        dataset.to_netcdf(tmp_path / name, engine="h5netcdf")
        words = ["analyse", str(tmp_path / name), "--out", str(tmp_path / "out"), "--json", "--no-figures"]
        return runner.invoke(app, words)

    expected = analysed(coded(small()), "whole.nc")
    assert expected.exit_code == 0, expected.output
    assert json.loads(expected.stdout) == analyse_trials(small())
    both = analysed(SAME["concatenated trials"](coded(small())), "both.nc")
    assert both.exit_code == 0, both.output
    assert json.loads(both.stdout)["table1"] == json.loads(expected.stdout)["table1"]
    bare = coded(small())
    bare["status"] = bare["status"].astype(float)
    bare["status"].attrs.clear()
    found = analysed(bare, "bare.nc")
    assert found.exit_code == 2
    assert "of type float64, without its meanings" in " ".join(found.stderr.split())


# labels


def test_law_results_have_the_labels_of_the_trials() -> None:
    errors = np.arange(1.0, 25.0).reshape(1, 12, 2) * 1e-3
    dataset = offsets(errors, CONDITIONS[:1]).isel(trial=[2, 6, 11])
    found = measure(dataset)
    table = found["tracking_error"].to_dataframe().reset_index()
    assert table["trial"].unique().tolist() == [3, 7, 12]
    by_label = found["tracking_error"].sel(condition="UM", trial=7, robot=2)
    assert float(by_label) == pytest.approx(errors[0, 6, 1])
    joined = xr.merge([dataset, found["tracking_error"]], join="exact", compat="no_conflicts")
    assert joined.sizes["trial"] == 3
    assert analyse_trials(dataset)["conditions"][0]["trials"] == [3, 7, 12]


def renumber(folder: Path, numbers: list[int], **columns: list[Any]) -> None:
    table = pd.read_csv(folder / "trials.csv", keep_default_na=False)
    table.assign(trial=numbers, **columns).to_csv(folder / "trials.csv", index=False)


def recorded(folder: Path, conditions: int = 2, trials: int = 3) -> np.ndarray[Any, np.dtype[np.float64]]:
    errors = np.arange(1.0, 1.0 + 2 * conditions * trials).reshape(conditions, trials, 2) * 1e-3
    write_recorded(offsets(errors, CONDITIONS[:conditions]), folder)
    return errors


def test_law_recorded_numbers_are_kept(tmp_path: Path) -> None:
    errors = recorded(tmp_path / "lab")
    renumber(tmp_path / "lab", [3, 7, 12, 1, 3, 7])
    dataset = read_recorded(tmp_path / "lab")
    assert dataset["trial"].values.tolist() == [1, 3, 7, 12]
    found = measure(dataset)["tracking_error"]
    assert float(found.sel(condition="UM", trial=12, robot=1)) == pytest.approx(errors[0, 2, 0])
    assert float(found.sel(condition="CM-36-0", trial=3, robot=1)) == pytest.approx(errors[1, 1, 0])
    rows = analyse_trials(dataset)["table1"]
    assert [row["trials"] for row in rows] == [3, 3]
    again = read_recorded(write_recorded(dataset, tmp_path / "copy"))
    assert again.identical(dataset)


def test_law_numbers_that_differ_between_conditions_stay_beside_the_trials(tmp_path: Path) -> None:
    """Numbered through the session: a column per number would leave most of the grid empty."""
    errors = recorded(tmp_path / "lab")
    renumber(tmp_path / "lab", [4, 1, 6, 5, 2, 3])
    dataset = read_recorded(tmp_path / "lab")
    assert "trial" not in dataset.coords
    table = (
        measure(dataset)["tracking_error"].to_dataframe().reset_index().set_index(["trial_number", "robot"])
    )
    assert table.loc[(4, 1), "tracking_error"] == pytest.approx(errors[0, 0, 0])
    assert table.loc[(3, 2), "tracking_error"] == pytest.approx(errors[1, 2, 1])
    assert [each["trials"] for each in analyse_trials(dataset)["conditions"]] == [[1, 4, 6], [2, 3, 5]]
    assert read_recorded(write_recorded(dataset, tmp_path / "copy")).identical(dataset)


def test_law_dyads_number_their_own_trials(tmp_path: Path) -> None:
    errors = recorded(tmp_path / "lab", trials=4)
    renumber(tmp_path / "lab", [1, 2, 1, 2] * 2, dyad=["B", "B", "A", "A"] * 2)
    dataset = read_recorded(tmp_path / "lab")
    assert dataset["dyad"].values.tolist() == [["A", "A", "B", "B"]] * 2
    table = measure(dataset)["tracking_error"].to_dataframe().reset_index()
    [value] = table.query("dyad == 'B' and trial_number == 2 and condition == 'UM' and robot == 1")[
        "tracking_error"
    ]
    assert value == pytest.approx(errors[0, 1, 0])
    assert analyse_trials(dataset)["analysed"]["dyads"] == ["A", "B"]
    assert read_recorded(write_recorded(dataset, tmp_path / "copy")).identical(dataset)
    renumber(tmp_path / "lab", [1, 2, 2, 2] * 2, dyad=["A", "B", "A", "A"] * 2)
    with pytest.raises(ts.InvalidInput, match="every trial may be listed only once"):
        read_recorded(tmp_path / "lab")
    renumber(tmp_path / "lab", [1, 2, 3, 4] * 2, dyad=["A", "", "A", "A"] * 2)
    with pytest.raises(ts.InvalidInput, match="a label in every line is required"):
        read_recorded(tmp_path / "lab")


def test_law_a_participant_is_as_good_as_a_dyad(tmp_path: Path) -> None:
    recorded(tmp_path / "lab", trials=4)
    renumber(tmp_path / "lab", [1, 2, 3, 4] * 2, participant=["p1", "p1", "p2", "p2"] * 2)
    dataset = read_recorded(tmp_path / "lab")
    assert dataset["trial"].values.tolist() == [1, 2, 3, 4]
    found = analyse_trials(dataset)
    assert (found["analysed"]["dyads"], found["analysed"]["unit"]) == (["p1", "p2"], "dyad")


def test_law_warnings_name_trials_by_their_numbers() -> None:
    dataset = offsets(np.random.default_rng(1).normal(0.03, 0.002, (1, 12, 2)), CONDITIONS[:1])
    dataset["position"][0, 6, :, 0] = 0.01
    dataset["position"][0, 2, 50] = np.nan
    chosen = dataset.isel(trial=[3, 6, 11])
    [warning] = analyse_trials(chosen)["warnings"]
    assert warning.startswith("Trial 7 of UM: the handle of robot 1")
    with pytest.raises(ts.InvalidInput, match="trial 3 of UM counts as completed"):
        measure(dataset.isel(trial=[2, 6]))
    with pytest.raises(ts.InvalidInput, match="trial 12 of UM ends at 2 s"):
        measure(dataset.isel(trial=[11]), discard=2.0)


def test_law_numbers_that_occur_twice_are_reported_and_not_exported(tmp_path: Path) -> None:
    errors = 0.03 + 0.001 * np.random.default_rng(2).normal(size=(2, 4, 2))
    both = xr.concat(
        [offsets(errors[:, :2], CONDITIONS[:2]), offsets(errors[:, 2:], CONDITIONS[:2])],
        "trial",
        data_vars="all",
    )
    found = analyse_trials(both)
    assert [row["te1_n"] for row in found["table1"]] == [4, 4]
    assert found["warnings"][0].startswith("UM: 2 trial numbers (1, 2) occur more than once")
    with pytest.raises(ts.InvalidInput, match="every number may occur only once in a condition"):
        write_recorded(both, tmp_path)


@pytest.mark.parametrize(
    "conditions",
    [
        [(math.nan, 0.0), (math.nan, 0.1), (36.0, 0.1)],
        [(math.nan, 0.0), (36.0, 0.1), (36.00000001, 0.1)],
        [(math.nan, 0.0), (36.0, 0.1), (36.0, 0.1)],
        [(math.nan, 0.0), (36.0, 0.1), (36.0, 0.1000004)],
        [(math.nan, 0.0), (36.0, 0.1), (36.4, 0.1)],
    ],
)
@pytest.mark.parametrize("has_names", [True, False])
def test_law_conditions_of_one_name_stay_apart_everywhere(
    conditions: list[tuple[float, float]], has_names: bool, tmp_path: Path
) -> None:
    errors = 1e-3 * (
        20.0 + np.arange(3)[:, None, None] + 0.01 * np.random.default_rng(2).normal(size=(3, 5, 2))
    )
    made = offsets(errors, conditions)
    made = made if has_names else made.drop_vars("condition")
    numbers = analyse_trials(made)
    rows = numbers["table1"]
    assert len({row["condition"] for row in rows}) == 3
    # all names, so also those of the groups in the tests, have their own values
    assert [row["te1_mean"] for row in rows] == pytest.approx((1e3 * errors[..., 0]).mean(axis=1), rel=1e-9)
    assert numbers["wilcoxon"]["te1_pairs"]["size"] == 3
    assert {each["superiority"] for each in numbers["wilcoxon"]["te1_pairs"]["comparisons"]} == {0.0}
    tests = [(each["over"], each["robot"]) for each in numbers["kruskal_wallis"]]
    assert len(set(tests)) == len(tests)
    json.dumps(numbers, allow_nan=False)
    trajectories, boxes = draw_trajectories(Trials.from_dataset(made)), draw_errors(numbers)
    # a pair of panels per condition, each with its own title
    titles = [axes.get_title(loc="left") for axes in trajectories.axes]
    assert len(trajectories.axes) == 6
    assert len({title for title in titles if title}) == 3
    axes = boxes.axes[-1]
    stiffnesses = {k for k, _ in conditions if not math.isnan(k)}
    brackets = [text.get_text() for text in axes.texts if text.get_text().endswith("N/m")]
    assert len(brackets) == len(set(brackets)) == len(stiffnesses)
    ticks = [label.get_text() for label in axes.get_xticklabels()]
    if len({delay for _, delay in conditions[1:]}) == 2 and not math.isnan(conditions[1][0]):
        assert len(set(ticks)) == 3
    if conditions[1] == conditions[2]:
        # a list of trials tells conditions apart by stiffness and delay alone
        with pytest.raises(ts.InvalidInput, match="every number may occur only once in a condition"):
            write_recorded(made, tmp_path)
        return
    labels = read_recorded(write_recorded(made, tmp_path))["condition"]
    assert len(set(labels.values.tolist())) == 3


def test_law_conditions_that_are_the_same_are_reported() -> None:
    errors = 0.03 + 0.001 * np.random.default_rng(2).normal(size=(3, 3, 2))
    [warning] = analyse_trials(offsets(errors, [(math.nan, 0.0), (math.nan, 0.1), (36.0, 0.1)]))["warnings"]
    assert warning.startswith("UM, UM (2): all are unconnected, with the delays 0 ms, 100 ms.")
    [warning] = analyse_trials(offsets(errors, [(math.nan, 0.0), (36.0, 0.1), (36.0, 0.1)]))["warnings"]
    assert warning == "CM-36-100, CM-36-100 (2): stiffness and delay are the same, but are listed separately."


def test_law_a_rehearsal_keeps_conditions_and_numbers_apart(tmp_path: Path) -> None:
    protocol = {
        "stiffness": [36.0, 36.00000001],
        "delay": [0.05],
        "trials": 3,
        "duration": 1.0,
        "discard": 0.2,
    }
    dataset = ts.rehearse(ts.Study.paper().replace(protocol=protocol), tmp_path)
    assert len(set(dataset["condition"].values.tolist())) == 3
    found = measure(dataset.isel(trial=[0, 2]))
    assert found["trial"].values.tolist() == [1, 3]
    assert found["condition"].values.tolist() == dataset["condition"].values.tolist()
    # everything is stored, and a rehearsal's unconnected robot 1 has nothing random
    numbers = analyse_trials(dataset)
    assert [(row["te1_n"], row["te1_copies"]) for row in numbers["table1"]] == [(1, 2), (3, 0), (3, 0)]
    same_numbers(
        measure(xr.concat([dataset.isel(trial=[0]), dataset.isel(trial=[1, 2])], "trial", data_vars="all")),
        measure(dataset),
    )
