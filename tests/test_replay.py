"""A recorded session through its endpoints once more: what a replay tells, and what it refuses."""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from rich.console import Console, RenderableType
from typer.testing import CliRunner, Result

import telespring as ts
from made_session import SESSIONS, TRAVEL, made_session, with_forces, write_recording
from telespring import cli
from telespring.replays.networks import rehearsal_study, session_traces, write_traces
from telespring.replays.reading import site_recording
from telespring.show.screens.replay import replay_screen

Pair = tuple[ts.SiteRecording, ts.SiteRecording]


@pytest.fixture(scope="module")
def session() -> Pair:
    return with_forces(made_session())


def run(arguments: list[str], status: int = 0) -> Result:
    done = CliRunner(env={"COLUMNS": "120", "NO_COLOR": "1"}).invoke(cli.app, ["replay", *arguments])
    assert done.exit_code == status, done.output
    return done


def shown(screen: RenderableType) -> str:
    console = Console(width=120, file=io.StringIO())
    with console.capture() as captured:
        console.print(screen)
    return " ".join(captured.get().split())


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


@pytest.fixture(scope="module")
def files(session: Pair, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("recordings")
    one, two = (write_recording(folder / f"site{site.side}.mcap", site) for site in session)
    return one, two


def test_cross_a_recorded_session_reproduces_itself(session: Pair, files: tuple[Path, Path]) -> None:
    for sources in (files, files[::-1], files[:1]):
        found = ts.replay(*sources)
        assert found.is_reproduced
        for side in found.sides:
            made = session[side.side - 1]
            assert np.array_equal(side.replayed.force, made.force)
            assert side.recording.session == made.session
            assert np.array_equal(side.recording.datagram, made.datagram)
            assert np.array_equal(side.recording.answered, made.answered)
            assert np.allclose(side.recording.clock_offset, made.clock_offset, rtol=0, atol=1e-9)
    softer = ts.replay(*files, stiffness=30.0)
    assert np.array_equal(softer.sides[0].replayed.force, 0.5 * session[0].force)


def test_law_the_share_and_the_limits_of_a_site_are_those_of_its_file(
    files: tuple[Path, Path], session: Pair
) -> None:
    (side,) = ts.read_recording(files[0]).sides.values()
    metadata = {**side.metadata, "safety": side.metadata["safety"] | {"rise": "40", "scale": "0.3"}}
    metadata["safety"]["lock_y"] = "true"
    share = np.linspace(0.0, 1.0, len(side.ticks))
    ticks = dataclasses.replace(side.ticks, columns={**side.ticks.columns, "share": share})
    site = site_recording(dataclasses.replace(side, metadata=metadata, ticks=ticks))
    assert np.array_equal(site.share, np.column_stack([share * 0.3, 0.0 * share]))
    assert (site.largest_force, site.steepest_rise) == (20.0, 40.0)
    found = ts.replay(site, session[1], stiffness=150.0)
    force = sizes(found.sides[0].replayed.force)
    assert np.diff(force).max() <= 40.0 * 0.002 + 1e-9
    assert (found.sides[0].replayed.force[:, 1] == 0.0).all()
    # a file without them is of another release
    for key in ("rise", "scale", "force"):
        safety = {name: text for name, text in side.metadata["safety"].items() if name != key}
        with pytest.raises(ts.InvalidInput, match=f"safety.{key}"):
            site_recording(dataclasses.replace(side, metadata={**side.metadata, "safety": safety}))
    columns = {name: column for name, column in side.ticks.columns.items() if name != "share"}
    with pytest.raises(ts.InvalidInput, match="without a share"):
        site_recording(dataclasses.replace(side, ticks=dataclasses.replace(side.ticks, columns=columns)))


def test_law_a_replay_says_what_of_the_device_it_does_not_know(files: tuple[Path, Path]) -> None:
    """A device that lags told its force: under other settings nobody knows what it would have told."""
    sites = [site_recording(side) for path in files for side in ts.read_recording(path).sides.values()]
    assert not any(site.has_measured_force for site in sites)
    sites[1] = dataclasses.replace(sites[1], has_measured_force=True)
    own, other = ts.replay(*sites), ts.replay(*sites, stiffness=30.0)
    assert [own.acted_force, other.acted_force] == ["as recorded", "as commanded"]
    assert other.to_dict()["acted_force"] == "as commanded"
    assert [side["device_measured_force"] for side in other.to_dict()["sides"]] == [False, True]
    said = [shown(replay_screen(found, "session")) for found in (own, other)]
    assert "device" not in said[0]
    assert "what a device would have made of it (a lag, a limit of its own) is not replayed." in said[1]
    assert "The device of site 2 measured it in the session." in said[1]


def test_law_a_recording_cut_off_reproduces_what_is_left(files: tuple[Path, Path], tmp_path: Path) -> None:
    content = files[1].read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: int(0.6 * len(content))])
    found = ts.replay(files[0], cut)
    assert found.is_reproduced
    one, two = found.sides
    assert 500 < len(two.time) < len(one.time)
    # what the cut side cannot tell any more keeps its content
    assert 0 < one.replayed.renewed < len(one.recording.arrival_time)


def test_law_the_command_prints_and_writes_a_replay(files: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    own = run([*map(str, files), "--out", str(out)])
    assert own.stdout.count("give the recorded forces, bit for bit") == 2
    done = run([*map(str, files), "--strategy", "guard", "--stiffness", "150", "--out", str(out)])
    assert "guard at 150 N/m" in done.stdout
    assert "nobody reacted to the replayed force" in " ".join(done.stdout.split())
    numbers = json.loads((out / "replay.json").read_text(encoding="utf-8"))
    assert numbers["replayed_session"]["strategy"] == "guard"
    assert numbers["sides"][0]["replayed"]["limited_share"] > 0.3
    assert (out / "replay.svg").read_text(encoding="utf-8").count("force on handle") == 4
    for name in ("site1.nc", "site2.nc"):
        assert (out / name).stat().st_size > 10_000
    later = run([str(files[0]), "--playout-delay", "90ms", "--json", "--no-figure", "--out", str(out)])
    printed = json.loads(later.stdout)
    assert printed["partner"] == "as recorded"
    assert printed["replayed_session"]["playout"] == {"kind": "fixed", "delay": 0.09}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--strategy", "guad"], "guard"),
        (["--stiffness", "-1"], "stiffness"),
        (["--playout", "adaptive", "--playout-delay", "0.1"], "Leave out one of them"),
        (["--strategy", "wave-variables"], "Give the recording of the other side"),
    ],
)
def test_law_the_command_refuses_with_a_remedy(
    files: tuple[Path, Path], tmp_path: Path, arguments: list[str], words: str
) -> None:
    refused = run([str(files[0]), *arguments, "--out", str(tmp_path)], status=2)
    assert words in " ".join(refused.stderr.split())


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
