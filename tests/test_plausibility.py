"""Trials that look wrong are named: units, axes, origins, stuck handles and spikes; right ones are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from made_trials import FREQUENCY, RATE, experiment, figure_eight
from telespring.analysis import compare_conditions
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
        (spiked, ["Trial 2 of UM", "robot 1", "single samples (2)", "mm at 3 s"]),
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
