"""What a study's network and session make of the ages in use is what `decide` judges."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import telespring as ts
from questions import flat, run

#: Hands that hardly hold, so that the spring decides.
LOOSE = {"kind": "skilled", "stiffness": 2.0}
STUDY = ts.Study.paper().replace(controller={"sample_period": 0.001}, agent1=LOOSE, agent2=LOOSE)
LATE = "time_s,delay_ms\n" + "".join(f"{0.02 * n:.2f},250\n" for n in range(100))
ONE_WAY = "time_s,delay_ms,lost\n" + "".join(f"{0.01 * n:.2f},{20 + n % 3},0\n" for n in range(50))


def growth(study: ts.Study, stiffness: float, traces: tuple[str | None, str | None]) -> float:
    """How much the distance between the handles grows from the second quarter of a trial to its end."""
    assert study.experiment is not None
    laboratory = study.experiment.laboratory_on(traces)
    motion = laboratory.run(stiffness, study.delay, 1, 24.0, 100.0)
    apart = np.abs(motion.position[:, 0] - motion.position[:, 1]).max(axis=1)
    quarter = len(apart) // 4
    return float(apart[3 * quarter :].max() / apart[quarter : 2 * quarter].max())


@pytest.mark.parametrize(
    ("stiffness", "network", "session"),
    [
        pytest.param(90.0, {"delay": 0.0, "trace": "late.csv"}, {}, id="trace of 250 ms beside delay 0"),
        pytest.param(
            90.0, {"delay": 0.05, "rate": {"bits_per_second": 1e6, "queue": 400}}, {}, id="rate below need"
        ),
        pytest.param(150.0, {"delay": 0.05, "burst": {"to_bad": 0.5, "to_good": 0.005}}, {}, id="bursts"),
        pytest.param(
            150.0, {"delay": 0.05, "blackout": {"duration": 0.25, "period": 0.27}}, {}, id="blackouts"
        ),
        pytest.param(90.0, {"delay": 0.05}, {"playout": {"kind": "fixed", "delay": 0.3}}, id="late play-out"),
    ],
)
def test_cross_what_runs_away_in_a_trial_is_not_called_stable(
    stiffness: float, network: dict[str, Any], session: dict[str, Any]
) -> None:
    study = STUDY.replace(network=network, session=session)
    traces = (LATE, LATE) if "trace" in network else (None, None)
    assert growth(study, stiffness, traces) > 2.0
    assert ts.decide(STUDY.replace(network={"delay": network["delay"]}), stiffness).status == "stable"
    found = ts.decide(study, stiffness, traces=traces)
    assert found.status in {"unstable", "not proven"}
    assert not found.is_stable
    assert found.stiffness_limit is not None
    assert found.stiffness_limit < stiffness
    # what is then called stable dies out
    usable = ts.decide(study.replace(coupling={"stiffness": None}), traces=traces).limits
    assert usable is not None
    row = usable.delays[0]
    most = row.usable_stiffness if row.varying is None else row.varying.usable_stiffness
    assert 10.0 < most < stiffness
    assert growth(study, 0.99 * most, traces) < 1.5
    assert ts.decide(study, 0.99 * most, traces=traces).status == "stable"


def test_law_a_constant_age_is_judged_as_that_delay() -> None:
    """A play-out at 300 ms on 50 ms is the same as 300 ms, and a sufficient one as a playout buffer."""
    later = STUDY.replace(network={"delay": 0.05}, session={"playout": {"kind": "fixed", "delay": 0.3}})
    waits = STUDY.replace(
        network={"delay": 0.05, "jitter": 0.02}, session={"playout": {"kind": "fixed", "delay": 0.07}}
    )
    promised = STUDY.replace(network={"delay": 0.05, "jitter": 0.02, "playout_buffer": True})
    for stiffness in (30.0, 52.0, 90.0, 124.0, 130.0):
        for study, delay in ((later, 0.3), (waits, 0.07), (promised, 0.07)):
            plain = ts.decide(STUDY.replace(network={"delay": delay}), stiffness)
            assert ts.decide(study, stiffness).status == plain.status


def test_law_each_way_has_its_own_ages() -> None:
    """One way with losses costs less than both."""
    limits = [
        ts.decide(STUDY.replace(network={"delay": 0.05, "loss": loss}), 60.0).stiffness_limit
        for loss in (0.0, {"forward": 0.2}, {"backward": 0.2}, 0.2)
    ]
    none, forward, backward, both = (limit or 0.0 for limit in limits)
    assert both < min(forward, backward) <= max(forward, backward) < none
    # the robots differ, the ways play the same part
    assert forward == pytest.approx(backward, rel=0.05)


@pytest.mark.parametrize(
    ("session", "word"),
    [
        ({"predictor": "linear"}, "predictor"),
        ({"predictor": "kalman"}, "predictor"),
        ({"strategy": "wave-variables"}, "strategy"),
        ({"strategy": "injected-damping"}, "strategy"),
    ],
)
def test_law_what_no_verdict_judges_is_not_proven(session: dict[str, str], word: str) -> None:
    for stiffness in (10.0, 60.0, 1000.0):
        found = ts.decide(STUDY.replace(network={"delay": 0.05}, session=session), stiffness)
        assert (found.status, found.is_stable, found.stiffness_limit) == ("not proven", False, 0.0)
        answer = found.to_dict()
        assert answer["network"]["judged"]["unjudged"] == [word]
        assert any("Nothing is proven" in warning for warning in answer["warnings"])
        assert answer["stiffness_allowed"] is None
        assert not any(each["assumption_met"] for key, each in answer["verdicts"].items() if key != "paper")
        assert "NOT PROVEN" in str(found)


@pytest.mark.parametrize("predictor", ["hold", "shared-target"])
def test_law_a_predictor_that_changes_no_root_changes_no_answer(predictor: str) -> None:
    study = STUDY.replace(network={"delay": 0.05}, session={"predictor": predictor})
    plain = STUDY.replace(network={"delay": 0.05})
    for stiffness in (60.0, 168.0, 250.0):
        assert ts.decide(study, stiffness).status == ts.decide(plain, stiffness).status


def test_law_the_guard_has_the_answer_of_the_bare_spring() -> None:
    plain = STUDY.replace(network={"delay": 0.05})
    for predictor in ("hold", "linear"):
        study = plain.replace(session={"strategy": "guard", "predictor": predictor})
        found = ts.decide(study, 250.0)
        assert found.status == ts.decide(plain, 250.0).status == "unstable"
        assert ("predictor is not in this answer" in flat(str(found))) == (predictor == "linear")


def test_law_a_network_without_a_bound_leaves_what_holds_on_any() -> None:
    study = STUDY.replace(network={"delay": 0.05, "loss": 1.0})
    soft, stiff, hard = (ts.decide(study, stiffness) for stiffness in (14.0, 60.0, 250.0))
    assert (soft.status, stiff.status, hard.status) == ("stable", "not proven", "unstable")
    anything = ts.verdicts(STUDY.dyad, 60.0, 0.05, sample_period=0.001).tier("any network")
    assert stiff.stiffness_limit == anything.stiffness_bound
    answer = stiff.to_dict()
    met = {key for key, each in answer["verdicts"].items() if each["assumption_met"]}
    assert met == {"any_network"} | ({"paper"} & met)
    assert answer["network"]["judged"]["ages"] is None
    assert answer["allowing_verdict"] == "any network"


def test_law_the_command_reads_the_trace_beside_the_study(tmp_path: Path) -> None:
    study = STUDY.replace(network={"delay": 0.03, "trace": "uplink.csv"}, coupling={"stiffness": 60.0})
    file = tmp_path / "study.toml"
    file.write_text(study.to_toml(), encoding="utf-8")
    missing = run("decide", str(file))
    assert missing.exit_code == 2
    assert "uplink.csv" in "".join(missing.output.split())
    (tmp_path / "uplink.csv").write_text(ONE_WAY, encoding="utf-8")
    shown = run("decide", "--json", str(file), "--check")
    assert shown.exit_code == 0, shown.output
    judged = json.loads(shown.stdout)["network"]["judged"]
    assert judged["ages"] == [[0.03, 0.03], [0.03, 0.03]]
    assert judged["sources"] == ["trace"]
    assert ts.decide(study).status == "not proven"
    assert "traces=(text, text)" in str(ts.decide(study))
    assert ts.decide(study, traces=(ONE_WAY, ONE_WAY)).status == "stable"
    (tmp_path / "uplink.csv").write_text(LATE, encoding="utf-8")
    assert run("decide", str(file), "--stiffness", "90", "--check").exit_code == 1


def test_law_the_delays_of_a_list_have_their_own_ages() -> None:
    study = STUDY.replace(network={"delay": None, "loss": 0.05}, coupling={"stiffness": None})
    found = ts.decide(study).limits
    assert found is not None
    for row in found.delays:
        own = ts.decide(study.replace(network={"delay": row.delay[0]})).limits
        assert own is not None
        assert row.varying == own.delays[0].varying
        assert row.question.ages == own.delays[0].question.ages
    longest = ts.decide(study, 60.0).limits
    assert longest is not None
    assert longest.stiffness is not None
    usable = longest.stiffness.usable_delay_while_varying
    assert usable is not None
    assert ts.decide(study, 60.0, 0.999 * usable).status == "stable"
    assert ts.decide(study, 60.0, 2.0 * usable).status != "stable"


@pytest.mark.parametrize("playout", ["adaptive", {"kind": "fixed", "delay": 0.05}])
def test_law_a_promise_of_a_buffer_beside_another_playout_is_refused(playout: object) -> None:
    study = STUDY.replace(network={"delay": 0.05, "jitter": 0.02}, session={"playout": playout})
    for ask in (
        lambda: study.replace(network={"playout_buffer": True}),
        lambda: ts.decide(study, 60.0, playout_buffer=True),
    ):
        with pytest.raises(ts.InvalidInput, match=r"network\.playout_buffer"):
            ask()
    assert ts.decide(study.replace(session=None), 60.0, playout_buffer=True).status == "stable"


def test_law_simulate_says_what_it_leaves_out(tmp_path: Path) -> None:
    study = STUDY.replace(network={"delay": 0.05, "loss": 0.1}, session={"strategy": "guard"})
    file, out = tmp_path / "study.toml", str(tmp_path / "out.csv")
    file.write_text(study.to_toml(), encoding="utf-8")
    shown = run("simulate", str(file), "--duration", "0.1", "--out", out)
    assert shown.exit_code == 0, shown.output
    assert "Not simulated, since the delay is constant here: lost packets and the strategy guard." in flat(
        shown.output
    )
    plain = run("simulate", "--delay", "50ms", "--stiffness", "60", "--duration", "0.1", "--out", out)
    assert "Not simulated" not in plain.output


def test_law_the_answer_with_jitter_fits_a_screen() -> None:
    plain = ts.Study.paper().replace(controller={"sample_period": 0.001})
    for network in ({"delay": 0.05, "jitter": 0.02}, {"delay": 0.05, "loss": 0.05}):
        for stiffness in (60.0, 125.0, 300.0):
            shown = str(ts.decide(plain.replace(network=network), stiffness))
            assert len(shown.splitlines()) <= 30, shown


def limit(study: ts.Study) -> float:
    found = ts.decide(study).stiffness_limit
    assert found is not None
    return found


def test_law_a_force_that_acts_late_is_judged_as_late_and_a_lag_not_at_all() -> None:
    study = STUDY.replace(network={"delay": 0.05}, coupling={"stiffness": 60.0})
    late = study.replace(laboratory={"computing_tick": True})
    assert late.judged_network().has_computing_tick
    stated = study.replace(controller={"computing_time": 0.001})
    assert not stated.judged_network().has_computing_tick
    assert late.judged_network().network == stated.judged_network().network == stated.network
    assert limit(late) == limit(stated)
    assert limit(late) < limit(study)
    lagging = study.replace(laboratory={"actuator_lag": 0.005})
    assert ts.decide(study).status == "stable"
    assert ts.decide(lagging).status == "not proven"
    assert lagging.judged_network().unjudged == ("actuator lag",)


def test_law_continuous_controllers_are_judged_as_the_laboratory_samples_them() -> None:
    slow = {"laboratory": {"sample_period": 0.025}, "protocol": {"record_rate": 40.0}}
    study = STUDY.replace(network={"delay": 0.05}, coupling={"stiffness": 60.0}, controller=None, **slow)
    continuous = study.replace(controller={"sample_period": 0.0})
    assert limit(continuous) == limit(study)
    plain = continuous.replace(laboratory=None, protocol={"record_rate": None})
    assert limit(plain) > 1.3 * limit(study)
