"""A recorded session through its endpoints once more: what a replay tells, and what it refuses."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import telespring as ts
from made_session import SESSIONS, TRAVEL, made_session
from telespring.replays.networks import rehearsal_study, session_traces, write_traces

Pair = tuple[ts.SiteRecording, ts.SiteRecording]


@pytest.fixture(scope="module")
def session() -> Pair:
    return with_forces(made_session())


def with_forces(pair: Pair) -> Pair:
    """Give a made session the forces that its own settings gave."""
    found = ts.replay(*pair)
    one, two = (
        dataclasses.replace(side.recording, wanted=side.own.wanted, force=side.own.force)
        for side in found.sides
    )
    return one, two


def sizes(force: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.hypot(force[:, 0], force[:, 1]))


def test_ref_two_handles_at_rest_feel_the_spring_between_them() -> None:
    found = ts.replay(*made_session(1500, still=True, loss=0.0))
    for side, sign in zip(found.sides, (1.0, -1.0), strict=True):
        # k·(x₂ − x₁) once the force has ramped in
        assert np.allclose(side.replayed.force[-100:], [sign * 60.0 * 0.02, 0.0], rtol=0, atol=1e-12)
        assert [word for _, word, _ in side.events] == ["partner-found", "ramping-in", "engaged"]
        # the play-out holds every motion until it is 40 ms old
        assert side.replayed.age[-1] == pytest.approx(0.04, abs=1e-3)


def test_law_a_session_reproduces_itself_and_says_from_when_it_does_not(session: Pair) -> None:
    found = ts.replay(*session)
    assert found.is_reproduced
    assert found.is_own
    assert found.partner == "replayed"
    assert found.to_dict()["sides"][0]["reproduced"] is True
    forces = session[1].force.copy()
    forces[700, 1] = np.nextafter(forces[700, 1], 1.0)
    found = ts.replay(session[0], dataclasses.replace(session[1], force=forces))
    assert [side.differs_at for side in found.sides] == [None, pytest.approx(0.7)]
    assert not found.is_reproduced


def test_law_the_packets_of_one_side_are_enough_where_only_motion_is_in_them(session: Pair) -> None:
    alone, both = ts.replay(session[0]), ts.replay(*session)
    assert alone.partner == "as recorded"
    assert np.array_equal(alone.sides[0].replayed.force, both.sides[0].replayed.force)
    later = ts.replay(session[0], playout={"kind": "fixed", "delay": 0.09})
    assert later.sides[0].numbers.age_mean == pytest.approx(0.09, abs=1e-3)
    assert ts.replay(session[0], stiffness=30.0).sides[0].numbers.force_rms > 0.0
    with pytest.raises(ts.InvalidInput, match="Give the recording of the other side"):
        ts.replay(session[0], strategy="guard")


def test_law_half_the_stiffness_is_half_the_force(session: Pair) -> None:
    found = ts.replay(*session, stiffness=30.0)
    for side in found.sides:
        assert np.array_equal(side.replayed.force, 0.5 * side.own.force)
        assert side.force_difference_rms == pytest.approx(side.numbers.force_rms)
    assert not found.is_own
    assert (found.recorded_study.stiffness, found.study.stiffness) == (60.0, 30.0)


def test_law_the_guard_spends_no_more_than_it_has(session: Pair) -> None:
    found = ts.replay(*session, strategy="guard", stiffness=150.0)
    stiff = ts.replay(*session, stiffness=150.0)
    for guarded, bare in zip(found.sides, stiff.sides, strict=True):
        assert guarded.numbers.least_account >= 0.0
        assert guarded.replayed.renewed == len(guarded.recording.arrival_time)
        assert (sizes(guarded.replayed.force) <= sizes(bare.replayed.force) + 1e-9).all()
        # a recording of a spring has no account
        assert np.isnan(guarded.recorded_numbers.least_account)
    # the first handle would gain energy, the second one loses some
    first, second = (side.numbers for side in found.sides)
    assert 0.3 < first.limited_share < 1.0
    assert second.limited_share == 0.0
    assert first.given_out < stiff.sides[0].numbers.given_out
    # the account of a guard lives on what the replayed partner sends, not on what the recorded one did
    assert 0.0 < first.energy_received <= second.energy_sent
    assert 0.0 < second.energy_received <= first.energy_sent


def test_law_the_site_lets_through_its_share_up_to_its_limit(session: Pair) -> None:
    share = np.ones_like(session[0].share)
    share[1500:] = [0.5, 0.0]
    site = dataclasses.replace(session[0], share=share, largest_force=1.0)
    side = ts.replay(site, session[1], stiffness=90.0).sides[0]
    assert sizes(side.replayed.force[:1500]).max() == pytest.approx(1.0)
    assert np.array_equal(side.replayed.force[1500:, 1], np.zeros(500))
    small = sizes(side.replayed.wanted[1500:] * [0.5, 0.0]) <= 1.0
    assert np.array_equal(side.replayed.force[1500:, 0][small], 0.5 * side.replayed.wanted[1500:, 0][small])


def test_law_what_is_no_session_is_refused(session: Pair) -> None:
    one, two = session
    with pytest.raises(ts.InvalidInput, match="side"):
        ts.replay(one, one)
    other = dataclasses.replace(two, study=two.study.replace(coupling={"stiffness": 61.0}))
    with pytest.raises(ts.InvalidInput, match="same study"):
        ts.replay(one, other)
    with pytest.raises(ts.InvalidInput, match="site 1 has heard no packet"):
        ts.replay(one, dataclasses.replace(two, session=SESSIONS[1] + 1))
    with pytest.raises(ts.InvalidInput, match="strategy"):
        ts.replay(one, two, strategy="guad")
    with pytest.raises(ts.InvalidInput, match="answered"):
        ts.replay(dataclasses.replace(one, answered=one.answered[1:]))
    with pytest.raises(ts.InvalidInput, match=r"arrivals\[\d+\]\.tick"):
        ts.replay(dataclasses.replace(one, arrival_tick=one.arrival_tick[::-1]))
    with pytest.raises(ts.InvalidInput, match=r"ticks\[1\]\.time"):
        ts.replay(dataclasses.replace(one, time=np.full_like(one.time, 7)))
    with pytest.raises(ts.InvalidInput, match="largest_force"):
        ts.replay(dataclasses.replace(one, largest_force=float("nan")))
    with pytest.raises(ts.InvalidInput, match="side"):
        ts.replay(dataclasses.replace(one, side=3))


def test_law_signals_and_numbers_are_one(session: Pair) -> None:
    found = ts.replay(*session, predictor="linear")
    side = found.sides[1]
    data = side.dataset()
    assert data["force"].dims == ("time", "axis")
    assert data["force"].attrs["units"] == "N"
    assert float(np.sqrt((data["force"] ** 2).sum("axis").mean())) == pytest.approx(side.numbers.force_rms)
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["people_react"] is False
    assert repr(found) == "<Replay of side 1 and 2: spring + linear>"


def test_ref_the_session_s_network_as_traces(session: Pair) -> None:
    for trace in session_traces(ts.replay(*session)):
        shown = trace.statistics()
        assert shown.minimum >= 1e-9 * TRAVEL
        # the travel, up to 4 ms of jitter, and the wait for the tick
        assert shown.maximum <= 1e-9 * TRAVEL + 0.004 + 0.0011
        assert 0.01 < shown.loss < 0.03
        assert shown.interval == pytest.approx(1e-3)


def test_law_the_rehearsal_has_both_settings_on_the_session_s_network(session: Pair, tmp_path: Path) -> None:
    found = ts.replay(*session, strategy="guard", stiffness=100.0)
    study = rehearsal_study(found)
    assert study.comparison.labels == ["spring", "guard"]
    assert [name for name, _, _ in study.comparison.networks] == ["recorded session"]
    write_traces(found, tmp_path)
    short = study.replace(protocol={"trials": 1, "duration": 4.0, "discard": 1.0})
    (tmp_path / "study.toml").write_text(short.to_toml(), encoding="utf-8")
    comparison = ts.compare(tmp_path / "study.toml", tmp_path / "runs")
    assert comparison.dataset.architecture.values.tolist() == ["spring", "guard"]
