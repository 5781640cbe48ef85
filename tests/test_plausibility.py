"""Trials that look wrong are named: units, axes, origins, stuck handles and spikes; right ones are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as FilePath

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.typing import NDArray

import telespring as ts
from made_trials import FREQUENCY, RATE, experiment, figure_eight
from telespring.analysis import compare_conditions, read_recorded, write_recorded
from telespring.analysis.trials import Trials

Path = NDArray[np.float64]


def followed(trials: int = 4, seconds: float = 8.0, lag: float = 0.12) -> xr.Dataset:
    """Two conditions of people who follow the target late, with noise, tremor and a short rest."""
    time = np.arange(round(seconds * RATE) + 1) / RATE
    random = np.random.default_rng(11)
    position = np.empty((2, trials, time.size, 2, 2))
    for place in np.ndindex(2, trials, 2):
        late = figure_eight(time - lag - random.uniform(0.0, 0.1))
        tremor = 0.002 * np.sin(2 * np.pi * 8.0 * time + random.uniform(0.0, 6.0))
        path = late * random.uniform(0.7, 1.2) + tremor[:, None] + random.normal(0.0, 3e-4, late.shape)
        position[place[0], place[1], :, place[2]] = path
    return experiment(position, [(np.nan, 0.0), (36.0, 0.167)])


def warnings_after(change: Callable[[Path], None]) -> list[str]:
    """Return the warnings about trials whose positions (condition, trial, time, robot, axis) were changed."""
    trials = followed()
    change(trials["position"].values)
    return list(compare_conditions(Trials.from_dataset(trials))["warnings"])


def test_law_trials_of_people_are_plausible() -> None:
    assert warnings_after(lambda _: None) == []


def in_centimetres(position: Path) -> None:
    position[..., 1, :] *= 100.0


def mirrored(position: Path) -> None:
    position[..., 0, 0] *= -1.0


def mirrored_along_y(position: Path) -> None:
    position[..., 0, 1] *= -1.0


def swapped(position: Path) -> None:
    position[..., 1, :] = position[..., 1, ::-1].copy()


def turned_by_a_quarter(position: Path) -> None:
    position[..., 1, :] = position[..., 1, ::-1].copy()
    position[..., 1, 0] *= -1.0


def beside(position: Path) -> None:
    position[..., 0, :] += [0.06, -0.05]


def stuck(position: Path) -> None:
    position[1, 2, 150:190, 1] = position[1, 2, 150, 1]


def spiked(position: Path) -> None:
    position[0, 1, 300, 0, 1] += 0.04
    position[0, 1, 500, 0, 0] -= 0.03


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (in_centimetres, ["Robot 2, in 8 of 8", "times further than the target", "its positions in cm"]),
        (mirrored, ["Robot 1, in 8 of 8", "only if the x axis is mirrored"]),
        (mirrored_along_y, ["Robot 1, in 8 of 8", "only if the y axis is mirrored"]),
        (swapped, ["Robot 2, in 8 of 8", "only if x and y are swapped. "]),
        (turned_by_a_quarter, ["Robot 2, in 8 of 8", "swapped and then"]),
        (beside, ["Robot 1, in 8 of 8", "centred 7", "mm beside the target"]),
        (
            stuck,
            ["Trial 3 of CM-36-167", "robot 2", "exactly where it is for 4", "from 1.5 s, then jumps by"],
        ),
        (spiked, ["Trial 2 of UM", "robot 1", "for 2 single samples", "mm at 3 s"]),
    ],
)
def test_law_what_a_set_up_does_wrong_is_said_once(change: Callable[[Path], None], words: list[str]) -> None:
    [warning] = warnings_after(change)
    for word in words:
        assert word in warning


def test_law_the_named_mirror_mends_the_error() -> None:
    """The axes that the warning names are those with which the error is smallest, by brute force."""
    time = np.arange(801) / RATE
    target = figure_eight(time)
    for swap in (False, True):
        for signs in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            if (swap, signs) == (False, (1, 1)):
                continue

            def spoil(position: Path, swap: bool = swap, signs: tuple[int, int] = signs) -> None:
                late = figure_eight(time - 0.15) * signs
                position[..., 0, :] = late[:, ::-1] if swap else late

            [warning] = warnings_after(spoil)
            words = warning.split("only if ")[1]
            assert ("swapped" in words) == swap
            mirrored = {"x": "x axis is mirrored" in words or "x is mirrored" in words}
            mirrored["y"] = "y axis is mirrored" in words or "y is mirrored" in words
            if "both" in words:
                mirrored = {"x": True, "y": True}
            position = np.zeros((1, 1, time.size, 2, 2))
            spoil(position)
            path = position[0, 0, :, 0]
            mended = path[:, ::-1] if swap else path
            mended = mended * [-1.0 if mirrored[axis] else 1.0 for axis in "xy"]
            away = np.hypot(*(mended - target).T).mean()
            assert away < 2 * 0.15 * FREQUENCY * 0.12


def listed(folder: FilePath, trials: xr.Dataset) -> FilePath:
    """Write trials as a lab does: its own names of files, in a list."""
    index = write_recorded(trials, folder)
    table = pd.read_csv(index)
    for row, old in enumerate(table["file"]):
        table.loc[row, "file"] = f"session {row + 1}.csv"
        (folder / old).rename(folder / f"session {row + 1}.csv")
    table.to_csv(index, index=False)
    return folder


def test_law_single_trials_are_named_with_the_file_that_a_user_can_open(tmp_path: FilePath) -> None:
    trials = followed()
    position = trials["position"].values
    position[1, 1, :, 0] = position[1, 1, :, 0, ::-1].copy()  # swapped in one trial of eight
    position[0, 2, 300, 1, 1] += 0.04
    position[1, 3, 150:190, 1] = position[1, 3, 150, 1]
    position[0, 3, 200:, 0] = position[0, 3, 200, 0]
    position[1, 2, :, 1] *= 100.0
    warnings = compare_conditions(Trials.from_dataset(read_recorded(listed(tmp_path, trials))))["warnings"]
    for start, words in (
        ("Trial 2 of CM-36-167 (session 6.csv), robot 1:", "only if x and y are swapped"),
        ("Trial 3 of CM-36-167 (session 7.csv), robot 2:", "its positions in cm"),
        ("Trial 3 of UM (session 3.csv): the handle of robot 2", "for 1 single sample, the"),
        ("Trial 4 of UM (session 4.csv): the handle of robot 1", "set the trial's status to stopped"),
        ("Trial 4 of CM-36-167 (session 8.csv): the handle of robot 2", "set the trial's status to stopped"),
    ):
        assert any(each.startswith(start) and words in each for each in warnings), (start, warnings)
    assert len(warnings) == 5


def test_law_the_same_in_several_trials_is_said_once() -> None:
    def swapped_in_five(position: Path) -> None:
        position[0, :, :, 0] = position[0, :, :, 0, ::-1].copy()
        position[1, 0, :, 0] = position[1, 0, :, 0, ::-1].copy()

    [warning] = warnings_after(swapped_in_five)
    assert warning.startswith(
        "Robot 1, in 5 of 8 completed trials (trial 1 of UM, trial 2 of UM, trial 3 of UM and 2 more): "
    )


def test_law_people_who_follow_badly_are_in_the_right_coordinates() -> None:
    """Late by up to half a second, too wide or narrow, off centre, on one axis only, wandering or resting."""
    time = np.arange(801) / RATE
    random = np.random.default_rng(3)
    position = np.empty((2, 20, time.size, 2, 2))
    for place in np.ndindex(2, 20, 2):
        path = figure_eight(time - random.uniform(0.0, 0.5)) * random.uniform(0.2, 2.5, 2)
        path += random.normal(0.0, 0.03, 2)
        wander = np.cumsum(random.normal(0.0, 1.0, path.shape), axis=0)
        path += random.uniform(0.0, 0.05) * wander / np.abs(wander).max()
        position[place[0], place[1], :, place[2]] = path
    warnings = compare_conditions(Trials.from_dataset(experiment(position, [(np.nan, 0.0), (36.0, 0.1)])))
    assert [each for each in warnings["warnings"] if "Trial" in each] == []


def test_law_a_refusal_names_the_file_of_the_trial(tmp_path: FilePath) -> None:
    trials = read_recorded(listed(tmp_path, followed()))
    trials["position"].values[1, 2, 50, 0, 0] = np.nan
    with pytest.raises(ts.InvalidInput, match=r"trial 3 of CM-36-167 \(session 7.csv\) counts as completed"):
        Trials.from_dataset(trials)


def test_law_an_export_keeps_the_names_of_files_and_replaces_none(tmp_path: FilePath) -> None:
    lab = listed(tmp_path / "lab", followed())
    trials = read_recorded(lab)
    again = read_recorded(write_recorded(trials, tmp_path / "copy"))
    assert again.identical(trials)
    (lab / "trials.csv").rename(lab / "mine.csv")
    before = {file.name: file.read_bytes() for file in lab.iterdir()}
    with pytest.raises(ts.InvalidInput, match=r"session 1\.csv"):
        write_recorded(trials, lab)
    assert {file.name: file.read_bytes() for file in lab.iterdir()} == before
