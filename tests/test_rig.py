"""The virtual laboratory as Python sees it: shapes, threads, programs as agents, refusals."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import telespring as ts
from telespring import _core

LABORATORY = _core.Laboratory.paper()
VARIABLES = ("position", "velocity", "coupling_force", "agent_force", "handle_force", "aim")

MANY = """
import sys, hashlib
import numpy as np
from telespring import _core
n = 9
got = _core.Laboratory.paper().run_many(
    [np.nan, 17.8, 142.4] * 3, np.repeat([0.0, 0.0836, 0.3344], 3),
    [_core.trial_seed(1, 0, i) for i in range(n)], 1.5, 100.0)
digest = hashlib.sha256()
for name in sorted(got):
    digest.update(np.ascontiguousarray(got[name]).tobytes())
print(digest.hexdigest())
"""


def test_law_arrays_have_the_documented_shapes() -> None:
    got = LABORATORY.run(71.2, 0.0836, 1, 2.0, 100.0)
    assert got["status"] == "completed"
    assert np.isnan(got["ended_at"])
    assert got["time"].shape == (201,)
    np.testing.assert_array_equal(got["time"], np.arange(201) / 100.0)
    assert got["target"].shape == (201, 2)
    for name in VARIABLES:
        assert got[name].shape == (201, 2, 2), name
        assert np.isfinite(got[name]).all()
    # robot 1's agent sees the target itself, robot 2's the mean of its spots
    np.testing.assert_array_equal(got["aim"][:, 0], got["target"])
    assert np.abs(got["aim"][:, 1] - got["target"]).max() > 0.01


def test_law_many_trials_are_the_single_ones() -> None:
    stiffness, delay = [np.nan, 35.6, 500.0], [0.0, 0.167, 0.3]
    seed = [_core.trial_seed(3, 0, trial) for trial in range(3)]
    many = LABORATORY.run_many(stiffness, delay, seed, 30.0, 50.0)
    assert many["position"].shape == (3, 1501, 2, 2)
    assert many["status"] == ["completed", "completed", "diverged"]
    for trial in range(3):
        one = LABORATORY.run(
            None if np.isnan(stiffness[trial]) else stiffness[trial], delay[trial], seed[trial], 30.0, 50.0
        )
        rows = len(one["time"])
        np.testing.assert_array_equal(many["target"][trial, :rows], one["target"])
        for name in VARIABLES:
            np.testing.assert_array_equal(many[name][trial, :rows], one[name])
            assert np.isnan(many[name][trial, rows:]).all()
        np.testing.assert_array_equal(many["ended_at"][trial], one["ended_at"])
    assert many["ended_at"][2] > 0.0
    assert rows < 1501


def test_law_the_number_of_threads_changes_no_bit() -> None:
    digests = {
        subprocess.run(
            [sys.executable, "-c", MANY],
            env={**os.environ, "RAYON_NUM_THREADS": threads},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for threads in ("1", "2", "5")
    }
    assert len(digests) == 1


def test_law_a_sampled_target_is_followed_where_the_figure_eight_was() -> None:
    time = np.arange(1001) / 1000.0
    eight = np.stack([0.05 * np.sin(2 * 2.59 * time), 0.1 * np.sin(2.59 * time)], axis=1)
    own = LABORATORY.run(71.2, 0.05, 1, 1.0, 100.0)
    given = LABORATORY.run(71.2, 0.05, 1, 1.0, 100.0, target=eight)
    # sines of numpy and Rust may differ in the last bit
    np.testing.assert_allclose(given["position"], own["position"], rtol=0, atol=1e-14)


def test_law_different_delays_each_way_and_a_damper_are_taken() -> None:
    got = LABORATORY.run(71.2, (0.02, 0.05), 1, 0.2, 1000.0, coupling_damping=1.0)
    first = [int(np.flatnonzero(got["coupling_force"][:, robot, 0])[0]) for robot in range(2)]
    assert first == [50, 20]


def test_law_seeds_are_those_of_the_core() -> None:
    assert _core.trial_seed(1, 0, 0) == 7_424_550_030_962_593_201
    assert _core.trial_seed(2**64 - 1, 3, 4) != _core.trial_seed(1, 3, 4)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ((-1.0, 0.0, 1, 1.0, 100.0), "stiffness"),
        (("soft", 0.0, 1, 1.0, 100.0), "stiffness"),
        ((71.2, -0.1, 1, 1.0, 100.0), "delay"),
        ((71.2, (0.1, 0.2, 0.3), 1, 1.0, 100.0), "delay"),
        ((71.2, 0.1, -1, 1.0, 100.0), "seed"),
        ((71.2, 0.1, 1, 0.0, 100.0), "duration"),
        ((71.2, 0.1, 1, 1.0, 300.0), "record_rate"),
    ],
)
def test_law_what_is_out_of_range_is_refused_by_its_name(arguments: tuple[object, ...], field: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        LABORATORY.run(*arguments)  # type: ignore[arg-type]
    assert refused.value.field == field


def test_law_trials_of_unequal_number_or_value_are_refused() -> None:
    with pytest.raises(ts.InvalidInput, match="one value per trial"):
        LABORATORY.run_many([1.0, 2.0], [0.0], [1, 2], 1.0, 100.0)
    with pytest.raises(ts.InvalidInput) as refused:
        LABORATORY.run_many([1.0, -2.0], [0.0, 0.0], [1, 2], 1.0, 100.0)
    assert refused.value.field == "stiffness"
    with pytest.raises(ts.InvalidInput, match="shape"):
        LABORATORY.run(1.0, 0.0, 1, 1.0, 100.0, target=np.zeros((5, 2)))
    with pytest.raises(ts.InvalidInput, match="python"):
        LABORATORY.run(1.0, 0.0, 1, 1.0, 100.0, agents=(lambda *_: (0.0, 0.0), None))
