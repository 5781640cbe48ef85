"""Lost samples of a log: short gaps are bridged and marked, long ones cut it, and both are reported."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from telespring import InvalidInput
from telespring._types import FloatArray
from telespring.identification import identify, paper_excitation
from telespring.identification.gaps import LONGEST_BRIDGE, bridge_gaps
from telespring.identification.resampling import even_stretches

RATE = 1000.0
MASS, DAMPING = (0.8334, 1.0649), (7.7257, 10.1168)


def recorded(seconds: float = 16.0, seed: int = 3) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Make a log of two axes: times, positions and forces of shape (n,) and (n, 2)."""
    time = np.arange(round(seconds * RATE)) / RATE
    command, random = paper_excitation(), np.random.default_rng(seed)
    late = [time, time - 1.25]
    position = np.column_stack([np.round(command.position(t) / 2e-5) * 2e-5 for t in late])
    force = np.column_stack(
        [
            m * command.acceleration(t) + b * command.velocity(t)
            for m, b, t in zip(MASS, DAMPING, late, strict=True)
        ]
    )
    return time, position, force + random.normal(0.0, 0.1, force.shape)


def smooth(samples: int = 4000) -> tuple[FloatArray, FloatArray, FloatArray]:
    time = np.arange(samples) / RATE
    return time, np.vstack([np.sin(time), np.cos(time)]), np.vstack([2.0 * np.cos(time), np.sin(time)])


def without(lost: NDArray[Any]) -> tuple[FloatArray, FloatArray, FloatArray]:
    time, position, force = smooth()
    kept = np.setdiff1d(np.arange(time.size), lost)
    return time[kept], position[:, kept], force[:, kept]


@pytest.mark.parametrize("lost", [[100], [100, 101], [100, 101, 102, 103], [7, 100, 102, 3990]])
def test_law_a_short_gap_is_bridged_in_place_and_marked(lost: list[int]) -> None:
    """The samples come back at their times, on the line between their neighbours, and no other is touched."""
    time, position, force = smooth()
    [stretch], _ = even_stretches(bridge_gaps(*without(np.array(lost)))[0])
    np.testing.assert_allclose(stretch.time, time, rtol=0.0, atol=1e-12)
    assert np.flatnonzero(~stretch.usable).tolist() == lost
    np.testing.assert_array_equal(stretch.position[:, stretch.usable], position[:, stretch.usable])
    np.testing.assert_array_equal(stretch.force[:, stretch.usable], force[:, stretch.usable])
    # a chord of 5 ms lies (5 ms)²/8 times the acceleration, at most 1 m/s², off the arc
    np.testing.assert_allclose(stretch.position, position, rtol=0.0, atol=(LONGEST_BRIDGE / RATE) ** 2 / 8)


def test_law_missing_numbers_are_as_missing_rows() -> None:
    lost = np.array([100, 101, 2000])
    time, position, force = smooth()
    [expected], told = even_stretches(bridge_gaps(*without(lost))[0])
    for row, value in ((position, np.nan), (force, np.inf), (time[None], np.nan)):
        kept = row[0, lost].copy()
        row[0, lost] = value
        [found], again = even_stretches(bridge_gaps(time, position, force)[0])
        row[0, lost] = kept
        np.testing.assert_array_equal(found.position, expected.position)
        np.testing.assert_array_equal(found.usable, expected.usable)
        assert [warning.message for warning in again] == [warning.message for warning in told]


def test_law_a_long_gap_cuts_the_log() -> None:
    lost = np.arange(2000, 2300)
    parts, told = bridge_gaps(*without(lost))
    time, position, _ = smooth()
    for part, samples in zip(parts, (slice(2000), slice(2300, None)), strict=True):
        np.testing.assert_array_equal(part.time, time[samples])
        np.testing.assert_array_equal(part.position, position[:, samples])
        assert part.usable.all()
    [warning] = told
    assert warning.code == "long gaps"
    assert warning.values["count"] == 1
    assert warning.values["longest"] == pytest.approx(0.301)
    stretches, _ = even_stretches(bridge_gaps(*without(lost))[0])
    assert [stretch.time.size for stretch in stretches] == [2000, 1700]
    assert len({stretch.rate for stretch in stretches}) == 1


def test_law_the_longest_bridge_is_five_periods_also_after_rounding() -> None:
    for lost, parts in ((np.arange(100, 104), 1), (np.arange(100, 105), 2)):
        for begin in (0.0, 4.373, 1e5):
            time, position, force = without(lost)
            assert len(bridge_gaps(begin + time, position, force)[0]) == parts


def test_law_a_few_samples_between_two_gaps_are_left_out_and_told() -> None:
    lost = np.concatenate([np.arange(2000, 2300), np.arange(2305, 2600)])
    parts, told = bridge_gaps(*without(lost))
    assert [part.time.size for part in parts] == [2000, 1400]
    assert told[-1].code == "samples between gaps"
    assert told[-1].values["count"] == 5


def test_law_a_signal_that_is_logged_less_often_sets_the_rate() -> None:
    """Every second position is empty: the log is one of half the rate, without gaps."""
    time, position, force = smooth()
    position[:, 1::2] = np.nan
    [stretch], told = even_stretches(bridge_gaps(time, position, force)[0])
    assert stretch.rate == pytest.approx(500.0)
    assert stretch.usable.all()
    assert told == []


def test_law_signals_that_are_never_logged_together_are_refused() -> None:
    time, position, force = smooth()
    position[:, ::2], force[:, 1::2] = np.nan, np.nan
    with pytest.raises(InvalidInput, match="interpolate them to common times"):
        bridge_gaps(time, position, force)


def test_law_a_log_in_crumbs_is_refused() -> None:
    with pytest.raises(InvalidInput, match="no 10 samples between two of them"):
        bridge_gaps(*without(np.flatnonzero(np.arange(4000) % 17 > 8)))


def test_law_a_jitter_beside_a_gap_is_interpolated_and_the_mark_stays() -> None:
    time, position, force = smooth()
    random = np.random.default_rng(8)
    shifted = time + random.uniform(-2e-4, 2e-4, time.size)
    position, force = np.vstack([np.sin(shifted), np.cos(shifted)]), np.vstack([np.cos(shifted)] * 2)
    kept = np.setdiff1d(np.arange(time.size), [1500, 1501])
    [stretch], told = even_stretches(bridge_gaps(shifted[kept], position[:, kept], force[:, kept])[0])
    assert [warning.code for warning in told] == ["uneven time stamps"]
    np.testing.assert_allclose(
        stretch.position[0][stretch.usable], np.sin(stretch.time[stretch.usable]), atol=2e-6
    )
    marked = np.flatnonzero(~stretch.usable)
    assert 2 <= marked.size <= 5
    assert set(range(1500, 1502)) & set(marked.tolist())


def test_law_a_long_gap_leaves_two_stretches_to_estimate_from() -> None:
    """Also numbers that are missing for long: the robot is that of the whole log, a little less certain."""
    time, position, force = recorded()
    whole = identify(time, position, force)
    kept = np.r_[0:8000, 8400 : time.size]
    empty = force.copy()
    empty[8000:8400, 1] = np.nan
    for found in (identify(time[kept], position[kept], force[kept]), identify(time, position, empty)):
        assert any("Long gaps: 1, the longest 401 ms after 7.999 s" in warning for warning in found.warnings)
        for before, after in zip(whole.axes, found.axes, strict=True):
            assert abs(after.mass.value - before.mass.value) < before.mass.standard_error
            assert abs(after.damping.value - before.damping.value) < before.damping.standard_error


@pytest.mark.parametrize("share", [1 / 4000, 0.01])
def test_law_lost_samples_do_not_change_a_robot(share: float) -> None:
    """One lost sample in 4,000 was reason enough to refuse a log. Only the noise that is left out changes."""
    time, position, force = recorded()
    whole = identify(time, position, force)
    kept = np.random.default_rng(5).random(time.size) >= share
    found = identify(time[kept], position[kept], force[kept])
    assert any("Lost samples: " in warning for warning in found.warnings)
    for before, after in zip(whole.axes, found.axes, strict=True):
        # a tenth of a standard error for a lost sample; with one in a hundred a part of the noise is lost
        scatter = 0.1 if share < 0.001 else 1.0
        assert abs(after.mass.value - before.mass.value) < scatter * before.mass.standard_error
        assert abs(after.damping.value - before.damping.value) < scatter * before.damping.standard_error
