"""Measures of a trial against closed forms."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import xarray as xr

import telespring as ts
from made_trials import FREQUENCY, PER_SAMPLE, RATE, experiment, figure_eight, offsets, small
from telespring.analysis import Trials, measure

UNCONNECTED = [(np.nan, 0.0)]


def followed(lags: list[float], gain: float = 1.0, offset: float = 0.0, duration: float = 14.0) -> xr.Dataset:
    """Make one trial per lag: robot 1 follows with it, robot 2 with half of it."""
    time = np.arange(round(duration * RATE)) / RATE
    paths = [[gain * figure_eight(time - part * lag) + offset for part in (1.0, 0.5)] for lag in lags]
    return experiment(np.moveaxis(np.array(paths), 1, 2)[None], UNCONNECTED, discard=2.0)


def test_ref_the_error_of_a_constant_distance_is_that_distance() -> None:
    errors = np.array([[[0.01, 0.02], [0.03, 0.0]]])
    found = measure(offsets(errors, UNCONNECTED))["tracking_error"]
    assert found.dims == ("condition", "trial", "robot")
    assert found.attrs["units"] == "m"
    # additions of 0.1 m to it
    assert np.asarray(found) == pytest.approx(errors, abs=1e-15)


def test_ref_the_error_of_a_sine_beside_the_target_is_its_mean_length() -> None:
    """Of a sin over whole periods, 2a/π; Eq. 15 takes lengths, not squares."""
    time = np.arange(1000) / RATE
    beside = np.zeros((1, 1, 1000, 2, 2))
    beside[0, 0, :, 0, 0] = 0.02 * np.sin(2.0 * math.pi * time / 2.0)
    beside[0, 0, :, 1, 1] = 0.04 * np.sin(2.0 * math.pi * time / 2.0)
    found = measure(experiment(figure_eight(time)[:, None, :] + beside, UNCONNECTED))["tracking_error"]
    # 200 samples per period: the mean of |sin| by the trapezoid rule errs by (π/200)²/3
    assert np.asarray(found)[0, 0] == pytest.approx([0.04 / math.pi, 0.08 / math.pi], rel=1e-4)


def test_law_only_what_is_not_discarded_counts_and_the_first_kept_sample_does() -> None:
    trials = offsets(np.full((1, 1, 2), 0.01), UNCONNECTED)
    trials["position"][:, :, :50] += 1.0
    assert float(measure(trials, discard=0.5)["tracking_error"][0, 0, 0]) == pytest.approx(0.01, abs=1e-14)
    trials.attrs["discard"] = 0.5
    assert float(measure(trials)["tracking_error"][0, 0, 0]) == pytest.approx(0.01, abs=1e-14)
    assert float(measure(trials, discard=0.49)["tracking_error"][0, 0, 0]) > 0.015


def test_law_a_trial_that_ended_early_has_no_measures_and_is_counted() -> None:
    trials = small()
    found = measure(trials)
    missing = np.isnan(np.asarray(found["tracking_error"])).all(axis=-1)
    assert missing.tolist() == [[False] * 3, [False, False, True], [False, True, False]]
    for name in ("interaction_force_rms", "interaction_force_peak", "effort_rms", "power"):
        assert np.array_equal(np.isnan(np.asarray(found[name])).all(axis=-1), missing)
    taken = Trials.from_dataset(trials)
    assert taken.ended_early.sum() == 1
    assert taken.completed.sum() == 7


@pytest.mark.parametrize(("gain", "offset"), [(1.0, 0.0), (0.6, 0.0), (1.3, 0.3)])
def test_ref_a_known_lag_is_found_to_a_hundredth_of_a_millisecond(gain: float, offset: float) -> None:
    lags = [0.0, 0.00321, 0.05, 0.1234567, 0.4005, 0.9, -0.2503]
    found = measure(followed(lags, gain, offset))
    expected = np.stack([lags, 0.5 * np.array(lags)], axis=-1)
    # the parabola's bias, largest half-way between samples
    assert np.asarray(found["lag"])[0] == pytest.approx(expected, abs=1e-5)
    assert np.asarray(found["lag_correlation"]).min() > 0.99999


def test_cross_the_lag_of_one_sine_is_its_phase() -> None:
    """By demodulation at the target's frequency over whole periods, with noise on top."""
    rng = np.random.default_rng(12)
    period = 2.0 * math.pi / FREQUENCY
    time = np.arange(round(6.0 * period * RATE)) / RATE
    target = np.stack([0.0 * time, 0.1 * np.sin(FREQUENCY * time)], axis=-1)
    position = np.stack([0.0 * time, 0.08 * np.sin(FREQUENCY * (time - 0.173))], axis=-1)
    noisy = position[:, None] + rng.normal(0.0, 0.005, (len(time), 2, 2))
    trials = experiment(noisy[None, None], UNCONNECTED)
    trials["target"] = ("time", "axis"), target
    found = np.asarray(measure(trials)["lag"])[0, 0]
    for robot in range(2):
        phase = np.angle(np.sum(noisy[:, robot, 1] * np.exp(-1j * FREQUENCY * time))) + math.pi / 2.0
        # both see the noise, over windows that differ by two seconds of fourteen
        assert found[robot] == pytest.approx(-phase / FREQUENCY, abs=0.004)


def test_law_no_lag_where_nothing_moves_or_none_fits() -> None:
    trials = followed([0.1])
    trials["position"][:, :, :, 0] = 0.05
    assert np.isnan(np.asarray(measure(trials)["lag"])[0, 0]).tolist() == [True, False]
    beyond = followed([1.12])
    assert np.isnan(np.asarray(measure(beyond)["lag"])[0, 0]).tolist() == [True, False]
    short = followed([0.1], duration=2.03)
    assert np.isnan(np.asarray(measure(short)["lag"])).all()


def test_law_trials_of_other_lengths_and_targets_are_measured_alone() -> None:
    """Each trial as if it were the only one."""
    long, short = followed([0.07], duration=16.0), followed([0.21], duration=11.0)
    both = followed([0.07, 0.21], duration=16.0)
    count = short.sizes["time"]
    both["position"][:, 1, count:] = np.nan
    goal = np.stack([np.asarray(long["target"]), np.asarray(long["target"]) * 1.1])[None]
    goal[0, 1, count:] = np.nan
    both["target"] = ("condition", "trial", "time", "axis"), goal
    both["samples"] = ("condition", "trial"), [[long.sizes["time"], count]]
    short["target"] = short["target"] * 1.1
    found, first, second = measure(both), measure(long), measure(short)
    for name in ("tracking_error", "lag"):
        together = np.asarray(found[name])[0]
        # fast convolutions of another length
        assert together[0] == pytest.approx(np.asarray(first[name])[0, 0], abs=1e-9)
        assert together[1] == pytest.approx(np.asarray(second[name])[0, 0], abs=1e-9)


def test_law_a_short_trial_takes_no_lag_from_the_others() -> None:
    both = followed([0.07, 0.07])
    alone = np.asarray(measure(followed([0.07]))["lag"])[0, 0]
    both["samples"] = ("condition", "trial"), [[both.sizes["time"], 203]]
    both["position"][:, 1, 203:] = np.nan
    found = np.asarray(measure(both)["lag"])[0]
    # fast convolutions over other trials too
    assert found[0] == pytest.approx(alone, abs=1e-9)
    assert np.isnan(found[1]).all()


def test_ref_forces_and_power_of_closed_forms() -> None:
    time = np.arange(800) / RATE
    wave = np.sin(2.0 * math.pi * time / 2.0)
    trials = experiment(np.zeros((1, 1, 800, 2, 2)) + figure_eight(time)[:, None, :], UNCONNECTED)
    force = np.zeros((1, 1, 800, 2, 2))
    force[..., 0, :] = [3.0, -4.0]
    force[0, 0, :, 1, 0] = 6.0 * wave
    velocity = np.zeros_like(force)
    velocity[0, 0, :, 1, 0] = 0.5 * wave
    trials["coupling_force"] = PER_SAMPLE, force
    assert "effort_rms" not in measure(trials).variables
    trials["agent_force"] = PER_SAMPLE, 2.0 * force
    assert "power" not in measure(trials).variables
    trials["velocity"] = PER_SAMPLE, velocity
    found = measure(trials)
    # sums over whole periods of sin² are exact up to rounding
    assert np.asarray(found["interaction_force_rms"])[0, 0] == pytest.approx(
        [5.0, 6.0 / math.sqrt(2.0)], rel=1e-12
    )
    assert np.asarray(found["interaction_force_peak"])[0, 0] == pytest.approx([5.0, 6.0], rel=1e-12)
    assert np.asarray(found["effort_rms"])[0, 0] == pytest.approx([10.0, 12.0 / math.sqrt(2.0)], rel=1e-12)
    assert np.asarray(found["power"])[0, 0] == pytest.approx([0.0, 3.0], abs=1e-12)


def test_law_the_order_of_dimensions_does_not_matter() -> None:
    trials = small()
    turned = trials.transpose("axis", "robot", "time", "trial", "condition")
    assert measure(turned).identical(measure(trials))


def spoilt(what: str) -> xr.Dataset:
    trials = small()
    if what == "a hole":
        trials["position"][0, 1, 70, 1, 0] = np.nan
    elif what == "no target":
        trials = trials.drop_vars("target")
    elif what == "one robot":
        trials = trials.isel(robot=[0])
    elif what == "no stiffness":
        trials = trials.drop_vars("stiffness")
    elif what == "time":
        trials = trials.assign_coords(time=np.zeros(201))
    elif what == "discard":
        trials.attrs["discard"] = 5.0
    elif what == "negative":
        trials.attrs["discard"] = -1.0
    return trials


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ("a hole", "trial 2 of UM counts as completed, but has no position at 0.7 s"),
        ("no target", "target over time, axis is required"),
        ("one robot", "the labels 1 and 2 are required"),
        ("no stiffness", "a coordinate stiffness is required"),
        ("time", "times that increase are required"),
        ("discard", "trial 1 of UM ends at 2 s, so less must be discarded"),
        ("negative", "a time of 0 s or more is required"),
    ],
)
def test_law_what_is_no_experiment_is_refused(what: str, words: str) -> None:
    with pytest.raises(ts.InvalidInput, match=re.escape(words)):
        measure(spoilt(what))


def test_law_a_single_sample_is_refused() -> None:
    with pytest.raises(ts.InvalidInput, match="time = 1 sample: trials of two samples or more"):
        measure(small().isel(time=slice(0, 1)))


def test_law_endings_may_be_flags() -> None:
    """As the CF conventions write them: numbers, and what they mean in the attributes."""
    plain, flags = small(), small()
    words = ["completed", "diverged", "absent"]
    values = [[words.index(each) for each in row] for row in np.asarray(plain["status"]).tolist()]
    attributes = {"flag_values": np.arange(3, dtype=np.int8), "flag_meanings": " ".join(words)}
    flags["status"] = ("condition", "trial"), np.array(values, dtype=np.int8), attributes
    assert measure(flags).identical(measure(plain))
    attributes["flag_meanings"] = "completed out_of_reach absent"
    flags["status"] = ("condition", "trial"), np.array(values, dtype=np.int8), attributes
    assert Trials.from_dataset(flags).status[2, 1] == "out of reach"
