"""The virtual laboratory as Python sees it: shapes, threads, programs as agents, refusals."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from typing import Any

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
for name in sorted(got.to_dict()):
    digest.update(np.ascontiguousarray(getattr(got, name)).tobytes())
print(digest.hexdigest())
"""


def test_law_arrays_have_the_documented_shapes() -> None:
    got = LABORATORY.run(71.2, 0.0836, 1, 2.0, 100.0)
    assert got.status == "completed"
    assert got.ended_at is None
    assert got.time.shape == (201,)
    np.testing.assert_array_equal(got.time, np.arange(201) / 100.0)
    assert got.target.shape == (201, 2)
    for name in VARIABLES:
        assert getattr(got, name).shape == (201, 2, 2), name
        assert np.isfinite(getattr(got, name)).all()
    # robot 1's agent sees the target itself, robot 2's the mean of its spots
    np.testing.assert_array_equal(got.aim[:, 0], got.target)
    assert np.abs(got.aim[:, 1] - got.target).max() > 0.01


def test_law_many_trials_are_the_single_ones() -> None:
    stiffness, delay = [np.nan, 35.6, 500.0], [0.0, 0.167, 0.3]
    seed = [_core.trial_seed(3, 0, trial) for trial in range(3)]
    many = LABORATORY.run_many(stiffness, delay, seed, 30.0, 50.0)
    assert many.position.shape == (3, 1501, 2, 2)
    assert many.status == ("completed", "completed", "diverged")
    for trial in range(3):
        one = LABORATORY.run(
            None if np.isnan(stiffness[trial]) else stiffness[trial], delay[trial], seed[trial], 30.0, 50.0
        )
        rows = len(one.time)
        np.testing.assert_array_equal(many.target[trial, :rows], one.target)
        for name in VARIABLES:
            np.testing.assert_array_equal(getattr(many, name)[trial, :rows], getattr(one, name))
            assert np.isnan(getattr(many, name)[trial, rows:]).all()
        ended_at = np.nan if one.ended_at is None else one.ended_at
        np.testing.assert_array_equal(many.ended_at[trial], ended_at)
    assert many.ended_at[2] > 0.0
    assert rows < 1501


def test_law_recordings_are_values() -> None:
    one = LABORATORY.run(71.2, 0.05, 1, 0.1, 100.0)
    moved = _core.simulate_handle({"mass": 1.0, "damping": 1.0}, {}, [[1, 0]], [[0, 0]], 1e-3, [0, 0])
    for recorded in (one, moved):
        assert pickle.loads(pickle.dumps(recorded)) == recorded
        assert recorded.to_dict()["status"] == "completed"
        with pytest.raises(AttributeError):
            recorded.status = "diverged"  # type: ignore[misc]
    assert one == LABORATORY.run(71.2, 0.05, 1, 0.1, 100.0)
    assert one != LABORATORY.run(71.2, 0.05, 2, 0.1, 100.0)


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
    np.testing.assert_allclose(given.position, own.position, rtol=0, atol=1e-14)


def test_law_different_delays_each_way_and_a_damper_are_taken() -> None:
    got = LABORATORY.run(71.2, (0.02, 0.05), 1, 0.2, 1000.0, coupling_damping=1.0)
    first = [int(np.flatnonzero(got.coupling_force[:, robot, 0])[0]) for robot in range(2)]
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
    assert refused.value.field == "stiffness[1]"
    with pytest.raises(ts.InvalidInput) as refused:
        LABORATORY.run_many([1.0, 2.0], [0.0, 200.0], [1, 2], 1.0, 100.0)
    assert refused.value.field == "delay[1]"
    with pytest.raises(ts.InvalidInput, match="shape"):
        LABORATORY.run(1.0, 0.0, 1, 1.0, 100.0, target=np.zeros((5, 2)))
    with pytest.raises(ts.InvalidInput, match="python"):
        LABORATORY.run(1.0, 0.0, 1, 1.0, 100.0, agents=(lambda *_: (0.0, 0.0), None))


@pytest.mark.parametrize(
    ("keywords", "field"),
    [
        ({"agents": "ab"}, "agents[0]"),
        ({"agents": 5}, "agents"),
        ({"agents": (None, None, None)}, "agents"),
        ({"target": "circle"}, "target"),
        ({"target": [1.0, 2.0]}, "target"),
        ({"duration": 1e5, "record_rate": 1000.0}, "record_rate"),
    ],
)
def test_law_wrong_kinds_and_too_many_rows_are_refused(keywords: dict[str, Any], field: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        LABORATORY.run(
            **{"stiffness": 1.0, "delay": 0.0, "seed": 1, "duration": 1.0, "record_rate": 100.0, **keywords}
        )
    assert refused.value.field == field


def test_law_many_trials_of_too_many_rows_are_refused() -> None:
    with pytest.raises(ts.InvalidInput, match="at most 50000000 rows"):
        LABORATORY.run_many([1.0] * 1000, [0.0] * 1000, range(1000), 60.0, 1000.0)


@pytest.mark.parametrize("kind", [list, np.float32, np.int64])
def test_law_a_target_may_be_any_array_like(kind: Any) -> None:
    ones = np.ones((101, 2))
    given = ones.tolist() if kind is list else ones.astype(kind)
    got = LABORATORY.run(20.0, 0.0, 1, 0.1, 100.0, target=given)
    np.testing.assert_array_equal(got.target, np.ones((11, 2)))


def test_law_the_target_is_told_without_a_trial() -> None:
    got = LABORATORY.run(20.0, 0.0, 1, 2.0, 50.0)
    np.testing.assert_array_equal(LABORATORY.target(2.0, 50.0), got.target)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"position0": [np.nan, 0.0]}, "position0[0]"),
        ({"position0": [0.0]}, "position0"),
        ({"velocity0": [0.0, np.inf]}, "velocity0[1]"),
        ({"velocity0": "fast"}, "velocity0"),
        ({"hand_force": [[0.0, 0.0], [np.nan, 0.0]]}, "hand_force[1, 0]"),
        ({"robot_force": [0.0, 0.0]}, "robot_force"),
        ({"handle": 5}, "handle"),
        ({"arm": None}, "arm"),
    ],
)
def test_law_a_handle_is_not_simulated_from_what_is_no_number(change: dict[str, Any], field: str) -> None:
    given: dict[str, Any] = {
        "handle": {"mass": 1.0, "damping": 1.0},
        "arm": {},
        "hand_force": [[0.0, 0.0]] * 2,
        "robot_force": [[0.0, 0.0]] * 2,
        "sample_period": 1e-3,
        "position0": [0.0, 0.0],
    }
    with pytest.raises(ts.InvalidInput) as refused:
        _core.simulate_handle(**(given | change))
    assert refused.value.field == field


def test_law_friction_that_just_balances_the_force_gives_numbers() -> None:
    got = _core.simulate_handle(
        {"mass": 1e-4, "damping": 100.0, "coulomb": 3.0},
        {},
        [[10, 10], [3, 3], [0, 0]],
        [[0, 0]] * 3,
        1e-3,
        [0, 0],
    )
    for name in ("position", "velocity", "handle_force"):
        assert np.isfinite(getattr(got, name)).all()
    assert (got.velocity[2:] == 0.0).all()


def test_law_ctrl_c_ends_a_long_run_of_many() -> None:
    """Trials that would take far longer than the test may: nine hours of virtual time in each."""
    code = """
import signal, threading
import numpy as np
from telespring import _core
threading.Timer(0.5, signal.raise_signal, [signal.SIGINT]).start()
n = 40
try:
    _core.Laboratory.paper().run_many(np.full(n, 20.0), np.zeros(n), range(n), 33_000.0, 1.0)
except KeyboardInterrupt:
    print("interrupted")
try:
    threading.Timer(0.5, signal.raise_signal, [signal.SIGINT]).start()
    _core.Laboratory.paper().run(20.0, 0.0, 1, 90_000.0, 1.0)
except KeyboardInterrupt:
    print("interrupted")
"""
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.split() == ["interrupted"] * 2


def test_law_an_interrupt_check_ends_a_trial_by_what_it_raises() -> None:
    def interrupt_check() -> None:
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        LABORATORY.run(20.0, 0.0, 1, 1.0, 100.0, interrupt_check=interrupt_check)


def test_law_a_laboratory_survives_pickling() -> None:
    study = ts.Study.paper().replace(network={"jitter": 0.002})
    assert study.experiment is not None
    laboratory = study.experiment.laboratory
    assert pickle.loads(pickle.dumps(laboratory)) == laboratory
    assert repr(laboratory) == "<Laboratory of two stations, controllers at 1000.0 Hz>"
    paper = _core.Laboratory.paper()
    assert pickle.loads(pickle.dumps(paper)) == paper != laboratory
