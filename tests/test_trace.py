"""What a recorded trace allows: ages as played, models that fit, and the stiffness that is proven."""

from __future__ import annotations

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import telespring as ts
from telespring._types import FloatArray

ROBOTS = """
robot1 = {mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}
robot2 = {mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}
"""


def study() -> ts.Study:
    return ts.Study.from_toml(ROBOTS)


def steady(delay: float, *, packets: int = 1000, period: float = 0.01) -> ts.Trace:
    return ts.Trace(period * np.arange(packets), np.full(packets, delay))


def test_law_a_constant_trace_gives_the_stiffness_of_one_constant_delay() -> None:
    found = ts.assess_trace(steady(0.105), study())
    decided = ts.decide(study(), delay=0.105).limits
    assert decided is not None
    best = found.recommended
    assert (best.delay, best.in_time, best.tier) == (0.105, 1.0, "constant delay")
    assert best.ages == ((0.105, 0.105), (0.105, 0.105))
    assert best.stiffness_limit == decided.delays[0].stiffness_limit
    assert best.usable_stiffness == decided.delays[0].usable_stiffness
    # tier 4 of the x axis at 105 ms is 98.9 N/m (docs/age-range.md); sampling costs 1 %
    assert 0.98 * 98.9 < best.stiffness_limit < 98.9
    assert found.settings()["network"] == {"delay": 0.105}
    assert not found.needs_guard


def test_ref_a_constant_delay_between_two_ticks_is_played_at_the_next_one() -> None:
    assert [choice.delay for choice in ts.assess_trace(steady(0.0203), study()).playouts] == [0.021]


def test_ref_two_delays_by_hand() -> None:
    # 90 ms for 200 ms and 110 ms for 100 ms in turn: a play-out of 90 ms holds a motion for 20 ms, then jumps
    delays = np.where(np.arange(1200) // 10 % 3 == 2, 0.11, 0.09)
    found = ts.assess_trace(ts.Trace(0.01 * np.arange(1200), delays), study())
    short, long = found.playouts
    assert short.delay == short.ages[0][0] == 0.09
    assert short.ages[0][1] == pytest.approx(0.11)
    assert (long.delay, long.ages[0], long.in_time) == (0.11, (0.11, 0.11), 1.0)
    judged = ts.verdicts(study().dyad, 1.0, 0.09, jitter=0.02, sample_period=0.001)
    assert set(short.bounds) == {"any network", "bounded varying delay", "age in a range"}
    for tier, bound in short.bounds.items():
        assert bound == judged.tier(tier).stiffness_bound
    assert "constant delay" in long.bounds
    assert found.recommended is long
    # what is late comes at most 20 ms late, and never early
    played = ts.Trace(0.01 * np.arange(1200), delays).play(0.09, 0.001)
    assert played.newest.min() > 0.09
    assert played.oldest.max() == pytest.approx(0.11)
    assert played.share_within(0.09, 0.11 + 1e-9) == 1.0


def test_law_lost_packets_widen_the_ages_by_the_gap() -> None:
    # every 20th packet is lost, 10 ms long; the others take 50 ms
    delays = np.full(1200, 0.05)
    delays[10::20] = math.nan
    found = ts.assess_trace(ts.Trace(0.01 * np.arange(1200), delays), study())
    low, high = ts.Trace(0.01 * np.arange(1200), delays).play(0.08, 0.001).ages
    # the packets of one recorded interval are lost, those of a session every ms
    assert low == pytest.approx(0.07, abs=1e-9)
    assert high == pytest.approx(0.09, abs=1e-9)
    assert found.recommended.tier == "age in a range"
    assert found.if_paused is None


def drawn(count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Draw delays of 20 ms and gamma jitter of 4 ± 3 ms cut at 30 ms, and bursts, with numpy alone."""
    random = np.random.default_rng(seed)
    jitter = random.gamma((4.0 / 3.0) ** 2, 9.0e-3 / 4.0, 4 * count)
    delay: FloatArray = (0.02 + jitter[jitter < 0.03][:count]).astype(np.float64)
    bad = False
    for i in range(count):
        bad = random.random() < (0.02 if not bad else 1.0 - 0.25)
        if bad:
            delay[i] = math.nan
    return np.linspace(0.0, 0.005 * (count - 1), count), delay


def test_cross_the_fit_finds_the_models_that_made_the_trace() -> None:
    trace = ts.Trace(*drawn(20_000, 3))
    fit = trace.fit()
    best, burst = fit.jitter[0], fit.burst
    assert best.kind == "gamma"
    assert best.delay == pytest.approx(0.02, abs=2e-4)
    assert best.mean == pytest.approx(0.004, rel=0.05)
    assert best.sd == pytest.approx(0.003, rel=0.05)
    assert best.distance < 1.36 / math.sqrt(20_000)
    assert best.distance < min(other.distance for other in fit.jitter[1:])
    assert burst is not None
    assert burst.to_bad == pytest.approx(0.02, rel=0.1)
    assert burst.to_good == pytest.approx(0.25, rel=0.1)
    assert abs(trace.statistics().autocorrelation) < 0.03
    # the fitted distribution, against numpy's draws
    recorded = np.sort(trace.delay[np.isfinite(trace.delay)])
    shares = np.arange(1, recorded.size + 1) / recorded.size
    assert float(np.abs(best.cumulative(recorded) - shares).max()) == pytest.approx(best.distance, abs=2e-4)


def test_law_outages_of_seconds_leave_any_network_and_the_guard() -> None:
    # an outage of 4 s: all that was sent in it comes at its end, as from a full buffer
    time = 0.02 * np.arange(1500)
    delay = np.where((time > 10.0) & (time < 14.0), 14.0 - time + 0.03, 0.03)
    found = ts.assess_trace(ts.Trace(time, delay), study())
    assert found.needs_guard
    assert found.recommended.delay == 0.03
    assert found.recommended.tier == "any network"
    bound = ts.verdicts(study().dyad, 1.0, 0.03, sample_period=0.001).tier("any network").stiffness_bound
    assert found.recommended.stiffness_limit == bound
    settings = found.settings()
    assert settings["session"]["strategy"] == "guard"
    assert settings["allow_unusual"] is True
    assert found.playouts[-1].delay > 3.9 > found.longest_useful
    assert study().replace(**settings).session.strategy == "guard"


def test_law_missing_rows_are_losses_up_to_a_time_and_pauses_beyond() -> None:
    kept = [n for n in range(1200) if n % 30 not in (7, 8)]
    time = 0.01 * np.array(kept)
    time[time > 5.0] += 20.0
    trace = ts.Trace(time, np.full(time.size, 0.04))
    found = ts.assess_trace(trace, study())
    [way] = found.ways
    assert way.missing is not None
    assert (way.missing.lost, way.missing.steps, way.missing.pauses) == (80, 40, 1)
    assert way.missing.longest_pause == pytest.approx(20.01)
    assert way.statistics.burst_length == 2.0
    assert found.recommended.tier == "age in a range"
    assert found.if_paused is not None
    assert found.if_paused.is_constant
    paused = ts.assess_trace(trace, study(), longest_loss=0.0)
    assert paused.recommended == found.if_paused
    assert paused.ways[0].statistics.loss == 0.0
    # who records losses has a row for each: a step is the sender's
    recorded = ts.assess_trace(ts.Trace(time, np.full(time.size, 0.04), losses_recorded=True), study())
    assert recorded.ways[0].missing is None
    assert recorded.recommended.is_constant


def test_law_what_is_recommended_is_what_decide_calls_stable() -> None:
    for trace in (steady(0.08), ts.Trace(*drawn(4000, 5))):
        found = ts.assess_trace(trace, study())
        told = study().replace(**found.settings())
        k = found.recommended.usable_stiffness
        assert ts.decide(told, 0.999 * k).is_stable
        answer = ts.decide(told, 1.01 * k).decision
        assert answer is not None
        status = answer.status if answer.varying is None else answer.varying.status
        assert status != "stable"


def test_law_hands_that_may_let_go_count_as_free() -> None:
    held = ts.Study.from_toml(ROBOTS, operator1={"stiffness": 300.0}, operator2={"stiffness": 300.0})
    free = ts.assess_trace(steady(0.1), study()).recommended
    assert ts.assess_trace(steady(0.1), held).recommended.usable_stiffness <= free.usable_stiffness


def test_law_the_ways_of_a_measurement_with_two_clocks_are_judged_apart() -> None:
    one, other = steady(0.03), steady(0.07)
    found = ts.assess_trace((one, other), study())
    assert [len(way.trace) for way in found.ways] == [1000, 1000]
    best = found.recommended
    # one play-out serves both ways: that of the slower one
    assert (best.delay, best.ages) == (0.07, ((0.07, 0.07), (0.07, 0.07)))


def test_law_most_of_the_time_leaves_one_percent_out() -> None:
    # one packet in 200 takes 300 ms, the others 20 ms
    delays = np.full(2000, 0.02)
    delays[100::200] = 0.3
    found = ts.assess_trace(ts.Trace(0.01 * np.arange(2000), delays), study())
    short = found.playouts[0]
    assert (short.delay, short.mostly_ages[0]) == (0.02, (0.02, 0.02))
    assert short.ages[0][1] > 0.02
    assert short.mostly_usable_stiffness > 1.5 * short.usable_stiffness
    assert found.guarded is short


def test_law_a_trace_is_a_value() -> None:
    trace = ts.Trace(*drawn(50, 1))
    again = pickle.loads(pickle.dumps(trace))
    assert again == trace
    assert again != steady(0.1)
    assert len(again) == 50
    assert again.lost.sum() == np.isnan(again.delay).sum()
    for thing in (trace.statistics(), trace.fit(), trace.play(0.05, 0.001)):
        assert pickle.loads(pickle.dumps(thing)) == thing
        assert thing.to_dict()


def test_law_a_file_is_read_in_every_form(tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    table.write_text(steady(0.02, packets=3).to_csv())
    assert ts.read_trace(table) == ts.Trace([0.0, 0.01, 0.02], [0.02] * 3, losses_recorded=True)
    assert ts.read_trace(table, round_trip=True).quantile(1.0) == 0.01
    table.write_bytes("time_s;delay_ms\n0;20,5\n1;21\n".encode("utf-16"))
    assert ts.read_trace(table).quantile(0.0) == 0.0205
    table.write_bytes(b"\xff\x00\xe4\xf6")
    with pytest.raises(ts.InvalidInput, match="UTF-8"):
        ts.read_trace(table)
    table.write_text("time_s,rtt_ms\n0,20\n1,21\n")
    with pytest.raises(ts.InvalidInput, match="round trip"):
        ts.read_trace(table)
    assert ts.read_trace(table, round_trip=True).quantile(0.0) == 0.01
    irtt = tmp_path / "a.json"
    delay = {"rtt": 30_000_000, "send": 20_000_000, "receive": 10_000_000}
    trips = [
        {"lost": "false", "timestamps": {"client": {"send": {"wall": 10_000_000 * n}}}, "delay": delay}
        for n in range(3)
    ]
    irtt.write_text(json.dumps({"round_trips": trips}))
    assert ts.read_trace(irtt).quantile(0.5) == 0.02
    assert ts.read_trace(irtt, backward=True).quantile(0.5) == 0.01
    assert ts.read_trace(irtt, round_trip=True).quantile(0.5) == 0.015


@pytest.mark.parametrize(
    ("time", "delay", "field"),
    [
        ([0.0, 1.0], [0.1], "delay"),
        ([0.0, -1.0], [0.1, 0.1], "trace row 2, time"),
        ([0.0, 1.0], [0.1, -0.1], "trace row 2, delay"),
        ([0.0, 1.0], [math.nan, math.nan], "trace"),
    ],
)
def test_law_what_is_no_trace_is_refused(time: list[float], delay: list[float], field: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        ts.Trace(time, delay)
    assert refused.value.field == field


def test_cross_forces_that_act_late_count_as_computing_time() -> None:
    """A laboratory that computes for a tick is judged as controllers that need their whole period."""
    trace = ts.Trace([0.02 * n for n in range(1000)], [0.05 + 0.005 * (n % 2) for n in range(1000)])
    study = ts.Study.paper().replace(controller={"sample_period": 0.025})
    late = ts.assess_trace(trace, study.replace(laboratory={"computing_tick": True}))
    stated = study.replace(controller={"sample_period": 0.025, "computing_time": 0.025})
    assert late.stiffness == ts.assess_trace(trace, stated).stiffness
    assert late.stiffness is not None
    assert late.stiffness < 0.8 * (ts.assess_trace(trace, study).stiffness or 0.0)


def test_law_continuous_controllers_are_timed_as_decide_times_them() -> None:
    slow = study().replace(controller={"sample_period": 0.0}, laboratory={"sample_period": 0.001})
    found = ts.assess_trace(ts.Trace([0.01 * n for n in range(1000)], [0.095] * 1000), slow)
    told = slow.replace(**found.settings())
    assert ts.decide(told, 0.999 * found.recommended.usable_stiffness).is_stable
    assert not ts.decide(told, 1.001 * found.recommended.usable_stiffness).is_stable


def test_law_behind_a_lag_only_the_guard_is_recommended_as_far_as_it_is_proven() -> None:
    trace = ts.Trace([0.02 * n for n in range(1000)], [0.05] * 1000)
    study = ts.Study.paper().replace(controller={"sample_period": 0.001}, laboratory={"actuator_lag": 0.03})
    found = ts.assess_trace(trace, study)
    assert found.needs_guard
    assert found.stiffness is not None
    assert found.stiffness <= found.guard_stiffness < found.recommended.usable_stiffness
    assert found.recommended_study("t.csv").session.strategy == "guard"
    # its own stiffness stays as far as the guard is proven
    for own, expected in ((40.0, 40.0), (20_000.0, found.guard_stiffness)):
        stated = ts.assess_trace(trace, study.replace(coupling={"stiffness": own}))
        assert stated.recommended_study("t.csv").stiffness == pytest.approx(expected, rel=1e-3)
        assert stated.recommended_study("t.csv").stiffness <= expected
