"""The laboratory with lumped arms against a second one in NumPy that shares no code with it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

import oracle_laboratory as oracle
import telespring as ts
from telespring import _core
from telespring.study.editing import with_values

PERIOD = 2 * math.pi / 2.59  # of the target, s


def laboratory(mass: float, damping: float, coulomb: float, spot_velocity: float | None) -> _core.Laboratory:
    arm = {"kind": "lumped", "mass": mass, "damping": damping}
    second = {"kind": "skilled"} if spot_velocity is None else {"spot_velocity": spot_velocity}
    experiment = with_values(
        ts.Study.paper(),
        {
            "arm1": arm,
            "arm2": arm,
            "robot1": {"coulomb": [coulomb, coulomb]},
            "robot2": {"coulomb": [coulomb, coulomb]},
            "agent2": second,
        },
    ).experiment
    assert experiment is not None
    return experiment.laboratory


def setup(mass: float, damping: float, coulomb: float, spot_velocity: float = 0.3) -> oracle.Setup:
    return oracle.Setup(
        mass=oracle.TABLE_III_MASS + mass,
        damping=oracle.TABLE_III_DAMPING + damping,
        coulomb=np.full((2, 2), coulomb),
        spot_velocity=spot_velocity,
    )


@pytest.mark.parametrize(
    ("mass", "damping", "coulomb", "stiffness", "delay"),
    [
        (0.0, 0.0, 0.0, None, 0.0),
        (0.0, 0.0, 0.0, 142.0, 0.0),
        (0.0, 3.0, 0.0, 142.0, 0.084),
        (0.3, 1.0, 0.4, 142.0, 0.1671863),  # between two samples
        (0.3, 1.0, 1.5, 71.0, 0.0005),  # half a sample; sticks and slips
        (0.0, 6.0, 0.3, 36.0, 0.334),
        (1.0, 0.0, 3.0, 71.0, 0.0432),  # sticks most of the time
    ],
)
def test_cross_without_disturbance_every_position_is_the_same(
    mass: float, damping: float, coulomb: float, stiffness: float | None, delay: float
) -> None:
    ours = laboratory(mass, damping, coulomb, None).run(stiffness, delay, 1, 4.0, 1000.0)
    theirs = oracle.simulate(setup(mass, damping, coulomb), stiffness, delay, 4.0)
    # both are exact within a period: what differs is the rounding of 4000 of them, 1e-16 m in each
    assert np.abs(ours.position - theirs.position[0]).max() < 1e-12
    assert np.abs(ours.velocity - theirs.velocity[0]).max() < 1e-11
    if coulomb >= 1.5:
        resting = np.diff(theirs.position[0], axis=0) == 0.0
        assert resting[1000:].any()


@pytest.mark.parametrize(("stiffness", "delay"), [(None, 0.0), (142.0, 0.084)])
def test_cross_with_disturbance_the_tracking_errors_have_one_distribution(
    stiffness: float | None, delay: float
) -> None:
    trials, duration, discard = 120, 3 * PERIOD, PERIOD
    unknowns = (0.2, 4.0, 0.3, 0.6)
    ours = laboratory(*unknowns).run_many(
        np.full(trials, math.nan if stiffness is None else stiffness),
        np.full(trials, delay),
        np.arange(trials, dtype=np.uint64),
        duration,
        100.0,
    )
    kept = ours.time >= discard
    found = np.linalg.norm(ours.position[:, kept, 1] - ours.target[:, kept], axis=-1).mean(axis=1)
    generator = np.random.default_rng(20)
    motion = oracle.simulate(setup(*unknowns), stiffness, delay, duration, trials, generator)
    expected = motion.tracking_error(discard)[:, 1]
    assert found.std(ddof=1) > 5e-4  # m: there is a disturbance
    error = math.hypot(found.std(ddof=1), expected.std(ddof=1)) / math.sqrt(trials)
    # the seeds are fixed: three standard errors is what a right laboratory misses once in 400 choices
    assert abs(found.mean() - expected.mean()) < 3 * error
    assert stats.ks_2samp(found, expected).pvalue > 0.01
