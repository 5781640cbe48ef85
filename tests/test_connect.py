"""The command `connect`, with a stand-in for the live program, and once with the program itself."""

from __future__ import annotations

import contextlib
import io
import json
import os
import pty
import re
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console, RenderableType
from typer.testing import CliRunner

import telespring as ts
from telespring import cli
from telespring.cli.keyboard import Keyboard
from telespring.connection import LiveSession, RunningProgram, find_program, outcome
from telespring.show.live_words import describe_event, describe_phase
from telespring.show.screens.live import live_screen, status_line
from telespring.show.screens.live_outcome import live_outcome_screen

ROOT = Path(__file__).parents[1]
FAKE = Path(__file__).parent / "fake_link.py"
VERSION = ts.__version__


@pytest.fixture
def fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, Any]]:
    """Put the stand-in in the program's place; call it with how it behaves."""
    program = tmp_path / "telespring-link"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{FAKE}" "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("TELESPRING_LINK", str(program))
    monkeypatch.chdir(tmp_path)

    def behave(**behaviour: Any) -> dict[str, Any]:
        whole = {"version": VERSION, **behaviour}
        monkeypatch.setenv("FAKE_LINK", json.dumps(whole))
        return whole

    behave()
    return behave


def connect(*arguments: str) -> Any:
    return CliRunner().invoke(cli.app, ["connect", *arguments])


def as_process(*arguments: str, **streams: Any) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "telespring", "connect", *arguments],
        **{"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
    )


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def _child(process: subprocess.Popen[bytes]) -> int:
    (child,) = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return int(child)


@pytest.mark.usefixtures("fake")
def test_law_json_is_one_object_with_the_worse_of_both_sides() -> None:
    found = connect("--demo", "--json")
    assert found.exit_code == 0, found.output
    result = json.loads(found.stdout)
    assert result["round_trip"] == pytest.approx(0.122)
    assert result["age"] == pytest.approx(0.072)
    assert result["loss"] == 0.02
    assert result["lateness"] == 2e-4
    assert result["te"] == 0.014
    assert result["limited_share"] == 0.25
    assert [(event["side"], event["event"]) for event in result["events"]] == [
        (1, "running"),
        (2, "running"),
        (1, "ended"),
        (2, "ended"),
    ]
    assert result["recording"] == "out/side-1.mcap"
    assert result["recordings"] == ["out/side-1.mcap", "out/side-2.mcap"]
    assert [site["side"] for site in result["sites"]] == [1, 2]


def test_law_what_nobody_knows_is_null() -> None:
    session = LiveSession()
    session.take({"type": "summary", "side": 1, "age": None, "round_trip": {"latest": None}}, 0.0)
    result = outcome(session, 1)
    keys = ("round_trip", "age", "loss", "lateness", "te", "limited_share", "recording")
    assert [result[key] for key in keys] == [None] * 7
    assert result["events"] == []


@pytest.mark.usefixtures("fake")
def test_law_without_a_terminal_events_and_a_summary_are_plain_lines() -> None:
    found = connect("--site", "a.toml")
    assert found.exit_code == 0, found.output
    lines = found.stdout.splitlines()
    assert lines[0] == "    0.10 s  force ramps out: no packet came"
    assert "running; 1.23 N; round trip 121.3 ms; age 71.2 ms; lost 2.1 %; coupling holds back" in lines[1]
    assert "Side 1: coupled for 18.0 of 20.0 s" in found.stdout
    assert "\x1b" not in found.stdout


def test_law_a_summary_hides_nothing_that_went_wrong() -> None:
    def said(**changes: Any) -> str:
        session = LiveSession()
        site = {
            "type": "summary", "side": 1, "seconds": 20.0, "coupled_share": 0.5, "cause": "stop-requested",
            "limited_share": 0.0, "cut_share": 0.0, "softened_share": 0.0, "events": [],
            "recording": {"path": "a.mcap", "status": "complete", "missed": 0},
        }  # fmt: skip
        session.take(site | changes, 0.0)
        console = Console(width=200, file=io.StringIO())
        with console.capture() as captured:
            live_outcome_screen(console, session)
        return " ".join(captured.get().split())

    fine = said()
    assert "Nothing held the spring's force back." in fine
    assert fine.endswith("Recording: a.mcap")
    cut = said(cut_share=0.25, softened_share=0.5)
    assert "Nothing held" not in cut
    assert "A limit of the force cut it in 25 % of the ticks. A bad network softened it in 50 %" in cut
    events = [
        {"event": "interrupted", "cause": "velocity"},
        {"event": "interrupted", "cause": "pause-ordered"},
        {"event": "emergency-stop", "cause": "here"},
        {"event": "recording-broken"},
    ]
    wrong = said(events=events)
    for words in (
        "the handle was too fast (1 time)",
        "emergency stop pressed: at this side",
        "has broken off",
    ):
        assert words in wrong
    assert "somebody wants a pause" not in wrong
    broken = {"path": "a.mcap", "status": "broken", "cause": "No space left\x1b[2J", "missed": 7}
    assert said(recording=broken).endswith("Recording: a.mcap (broken: No space left[2J; 7 items missed)")


def test_law_the_exit_status_is_the_programs(fake: Callable[..., Any]) -> None:
    fake(status=1)
    assert connect("--demo", "--json").exit_code == 1
    fake(refuses="network.loss = 2: 0 to 1. Give a share.")
    found = connect("--demo", "--loss", "2")
    assert found.exit_code == 2
    assert found.stderr == "Refused: network.loss = 2: 0 to 1. Give a share.\n"
    assert found.stdout == ""


def test_law_options_reach_the_program_in_si_units(fake: Callable[..., Any], tmp_path: Path) -> None:
    note = tmp_path / "arguments"
    fake(arguments=str(note), seconds=0.0)
    path = ["--delay", "80 ms", "--jitter", "4ms", "--loss", "0.05", "--stiffness", "0.2 N/mm"]
    assert connect("--demo", "--strategy", "spring", *path, "--seconds", "3").exit_code == 0
    said = json.loads(note.read_text())
    assert said[:2] == ["demo", "--console"]
    pairs = dict(zip(said[2::2], said[3::2], strict=True))
    assert {name: pairs[name] for name in ("--strategy", "--delay", "--jitter", "--loss", "--stiffness")} == {
        "--strategy": "spring",
        "--delay": "0.08",
        "--jitter": "0.004",
        "--loss": "0.05",
        "--stiffness": "200.0",
    }
    assert pairs["--seconds"] == "3.0"
    assert pairs["--record"] == "out/connect"
    assert connect("--demo", "--imposed-delay", "120ms").exit_code == 0
    assert json.loads(note.read_text())[-2:] == ["--imposed-delay", "0.12"]
    marks = ["--trial", "-1 to 1", "--condition", "soft", "--participant", "P-07"]
    for kind in (["--demo"], ["--site", "a.toml"]):
        assert connect(*kind, *marks).exit_code == 0
        said = json.loads(note.read_text())
        assert said[-3:] == ["--participant=P-07", "--condition=soft", "--trial=-1 to 1"]
    assert (tmp_path / "out" / "connect").is_dir()
    assert connect("--site", "a.toml", "--record", "here").exit_code == 0
    assert json.loads(note.read_text()) == ["run", "a.toml", "--console", "--record", "here"]
    assert connect("--site", "a.toml").exit_code == 0
    assert json.loads(note.read_text()) == ["run", "a.toml", "--console"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "exactly one is needed"),
        (("--demo", "--site", "a.toml"), "exactly one is needed"),
        (("--site", "a.toml", "--strategy", "spring"), "--strategy = spring"),
        (("--check", "a.toml", "--loss", "0.1"), "--loss = 0.1"),
        (("--check", "a.toml", "--record", "here"), "--record = here"),
        (("--check", "a.toml", "--trial", "7"), "--trial = 7"),
        (("--site", "a.toml", "--imposed-delay", "0.1"), 'playout = {kind = "fixed", delay = …}'),
    ],
)
@pytest.mark.usefixtures("fake")
def test_law_options_that_contradict_each_other_are_refused(arguments: tuple[str, ...], said: str) -> None:
    found = connect(*arguments)
    assert found.exit_code == 2
    assert said in " ".join(found.stderr.split())


def test_law_a_program_that_is_absent_or_another_is_refused_with_the_remedy(
    fake: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fake(version="9.9.9")
    found = connect("--demo")
    assert found.exit_code == 2
    assert "version 9.9.9" in found.stderr
    assert "make link" in found.stderr
    monkeypatch.setenv("TELESPRING_LINK", str(tmp_path / "absent"))
    assert "$TELESPRING_LINK" in connect("--demo").stderr
    monkeypatch.delenv("TELESPRING_LINK")
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))
    monkeypatch.setattr("telespring.connection.program.__file__", str(tmp_path / "a" / "b" / "c" / "d.py"))
    said = " ".join(connect("--demo").stderr.split())
    assert "no part of a wheel" in said
    assert "`make link` builds it in the folder of telespring's sources" in said
    monkeypatch.setattr(sys, "platform", "darwin")
    assert "Linux" in connect("--demo").stderr


def test_law_typed_lines_are_orders(fake: Callable[..., Any]) -> None:
    fake(seconds=60.0)
    process = as_process("--site", "a.toml", stdin=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(b"consent\nmark trial 7\n")
    process.stdin.close()  # whoever types may go
    told = b""
    while b"order mark trial 7" not in told:
        piece = process.stdout.readline()
        assert piece
        told += piece
    assert b"order consent" in told
    process.stdin = None
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 0


def test_law_ctrl_c_ends_the_session_in_order_and_once(fake: Callable[..., Any], tmp_path: Path) -> None:
    note = tmp_path / "note"
    fake(seconds=60.0, note=str(note))
    process = as_process("--site", "a.toml", start_new_session=True)
    assert process.stdout is not None
    process.stdout.readline()  # it runs
    assert os.getpgid(_child(process)) != process.pid
    # as a terminal does: to all of the group
    os.killpg(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert note.read_text() == "stop-requested 1\n"
    assert b"Side 1: coupled" in out


def test_law_ctrl_c_again_ends_a_program_that_does_not_leave(fake: Callable[..., Any]) -> None:
    fake(stuck=True)
    process = as_process("--site", "a.toml")
    assert process.stdout is not None
    process.stdout.readline()
    for _ in range(10):
        process.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(5)
            break
    process.communicate(timeout=60)
    assert process.returncode == 1


def test_law_if_the_parent_is_killed_the_program_hears_that_its_input_has_ended(
    fake: Callable[..., Any], tmp_path: Path
) -> None:
    note = tmp_path / "note"
    fake(seconds=600.0, note=str(note))
    process = as_process("--site", "a.toml", stdin=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(0.5)
    assert not note.exists()
    process.kill()
    process.communicate()
    wait_for(lambda: note.exists() and note.read_text().endswith("\n"))
    assert note.read_text() == "operator-gone 0\n"


def test_law_keys_are_orders_and_the_terminal_is_left_as_it_was(fake: Callable[..., Any]) -> None:
    fake(seconds=60.0)
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    process = as_process("--demo", stdin=slave, stdout=slave, stderr=slave, start_new_session=True)
    shown = bytearray()

    def sees(text: bytes) -> bool:
        shown.extend(os.read(master, 65_536))
        return text in shown

    wait_for(lambda: sees(b"side 2"))
    during = termios.tcgetattr(slave)
    assert not during[3] & termios.ICANON
    os.write(master, b"p")
    wait_for(lambda: sees(b"order pause"))
    os.write(master, b"m")
    wait_for(lambda: sees(b"Enter sets it"))
    os.write(master, b"trial 7\r")
    wait_for(lambda: sees(b"order mark trial 7"))
    process.send_signal(signal.SIGINT)
    # the files of this session, however many others the folder has
    wait_for(lambda: sees(b"telespring merge out/side-1.mcap out/side-2.mcap --out session.mcap"))
    assert b"Recording: out/side-2.mcap" in shown
    assert process.wait(60) == 0
    assert termios.tcgetattr(slave) == before
    os.close(master)
    os.close(slave)


def typed(*pieces: bytes) -> tuple[list[str], str | None]:
    """Return the orders of keys that come in these pieces, and the marker that is being typed then."""
    reading, writing = os.pipe()
    keys, orders = Keyboard(reading, has_keys=True), []
    for piece in pieces:
        os.write(writing, piece)
        orders += keys.orders()
    os.close(reading)
    os.close(writing)
    return orders, keys.typed()


def test_law_a_key_is_an_order_and_no_other_key_lets_a_force_come() -> None:
    keys = [b"p", b" ", b"w", b"s", b"c", b"r", b"x", b"C", b"q"]
    assert typed(*keys)[0] == ["pause", "pause", "withdraw", "stop", "consent", "resume", "clear", "consent"]
    # arrows, F1 to F4, Home, Delete, and a sequence in two pieces
    for sequence in (
        b"\x1b[A",
        b"\x1b[C",
        b"\x1bOC",
        b"\x1bOP",
        b"\x1bOR",
        b"\x1bOS",
        b"\x1b[1;5C",
        b"\x1b[3~",
    ):
        assert typed(sequence)[0] == [], sequence
        assert typed(sequence[:1], sequence[1:])[0] == [], sequence
    # a pasted text may stop a force, never let one come
    assert typed(b"scarce")[0] == ["stop"]
    assert typed(b"accept")[0] == ["pause"]


def test_law_a_marker_is_typed_up_to_enter_or_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    assert typed(b"m", b"trial 7\n", b"p") == (["mark trial 7", "pause"], None)
    assert typed(b"m", b"no", b"\x7f", b"te C", b"s") == ([], "nte Cs")
    assert typed(b"mtrial 7", b"\x1b", b"p") == (["pause"], None)
    assert typed(b"m", b"  \n", b"s") == (["stop"], None)
    orders, text = typed(b"m", 50 * "ä".encode() + 300 * b"x")
    assert (orders, text) == ([], 80 * "x")
    now = [100.0]
    monkeypatch.setattr("telespring.cli.keyboard.time.monotonic", lambda: now[0])
    reading, writing = os.pipe()
    keys = Keyboard(reading, has_keys=True)
    for piece, time_of_it in ((b"m", 100.0), (b"t", 114.0), (b"p", 130.0)):
        now[0] = time_of_it
        os.write(writing, piece)
        orders = keys.orders()
    # nobody went on typing: the key is an order again
    assert (orders, keys.typed()) == (["pause"], None)
    os.close(reading)
    os.close(writing)


def test_law_the_last_line_of_an_input_is_an_order_without_its_end() -> None:
    reading, writing = os.pipe()
    os.write(writing, b"mark trial 1\nconsent")
    os.close(writing)
    lines = Keyboard(reading, has_keys=False)
    assert lines.orders() == ["mark trial 1"]
    assert lines.orders() == ["consent"]
    assert lines.file is None
    os.close(reading)


def test_law_whatever_the_program_says_the_screen_stays_whole(fake: Callable[..., Any]) -> None:
    fake(
        says=[
            "no json",
            '["no", "object"]',
            '{"type": "status"}',
            '{"type": "status", "side": 1, "phase": 7, "force": "many", "limits": [null], "latency": 3}',
            '{"type": "event", "side": 1, "event": "\\u001b[2Jboo", "cause": "\\u0007x"}',
        ]
    )
    found = connect("--site", "a.toml")
    assert found.exit_code == 0, found.output
    assert "\x1b" not in found.stdout
    assert "\x07" not in found.stdout
    assert "[2Jboo: x" in found.stdout


def _session(phase: str = "running") -> LiveSession:
    session = LiveSession()
    for side in (1, 2):
        status = {
            "type": "status", "side": side, "time": 12.3, "phase": phase, "watchdog": "holding",
            "watchdog_cause": "silence", "round_trip": 0.1213, "age": 0.0712, "loss": 0.021,
            "lateness": {"median": 1e-5, "quantile_99": 9e-5, "largest": 2e-4}, "overruns": 3,
            "latency": {"device": 0.0, "loop": 1e-4, "network": 0.0601, "playout": 0.0111},
            "force": 1.234, "stiffness": 142.0, "stiffness_in_use": 101.0, "limited_share": 0.125,
            "limits": ["force"], "balance": 0.0123, "te": 0.0141, "offset": 0.0123,
        }  # fmt: skip
        session.take(status, 5.0)
        session.take({"type": "event", "side": side, "time": 1.0, "event": "engaged"}, 5.0)
    return session


def _shown(screen: RenderableType, width: int) -> str:
    console = Console(width=width, file=io.StringIO())
    with console.capture() as captured:
        console.print(screen)
    return captured.get()


@pytest.mark.parametrize("width", [80, 120])
def test_law_the_screen_says_all_at_every_width(width: int) -> None:
    text = _shown(live_screen(_session(), "Demonstration", 5.1, 40), width)
    assert all(len(line) <= width for line in text.splitlines())
    words = " ".join(text.split())
    for said in (
        "running", "1.23 N", "101 of 142 N/m", "holds the force", "no packet came", "12.5 %", "12.3 mJ",
        "14.1 mm", "121.3 ms", "71.2 ms", "60.1 ms", "11.1 ms", "2.1 %", "0.09 ms", "3 missed",
        "cut at the force limit", "full force", "Ctrl-C",
    ):  # fmt: skip
        assert said in words, said
    assert words.count("full force") == 2


def test_law_a_side_that_says_nothing_is_seen() -> None:
    assert "no word for 3 s" in _shown(live_screen(_session(), "Demonstration", 8.0, 40), 80)


def test_law_the_offset_is_told_while_the_handles_are_aligned() -> None:
    line = status_line(_session("aligning").sides[1]).plain
    assert "align the handles: 12 mm apart" in line


def test_law_every_word_of_the_program_is_known() -> None:
    """A word that is not is printed as it is; the words of the program's sources have a sentence."""
    sources = ROOT / "crates" / "telespring-link" / "src"
    words: set[str] = set()
    for pattern in ("summary*", "summary/*", "site/*", "transport/mod.rs", "device/mod.rs", "hello/*"):
        for path in sources.glob(pattern):
            if path.is_file():
                code = path.read_text().partition("#[cfg(test)]")[0]
                words |= set(re.findall(r'=>\s*\(?"([a-z]+(?:-[a-z]+)*)"', code))
    assert len(words) > 30
    for word in words - {"granted", "not-asked", "mark", "phase"}:
        plain = word.replace("-", " ")
        said = [
            describe_event({"event": "x", "cause": word}).removeprefix("x: "),
            describe_event({"event": word}),
            describe_phase({"phase": word}),
        ]
        assert any(sentence != plain for sentence in said) or word in {"running", "ended"}, word


@pytest.mark.parametrize(("verdict", "status"), [("ok", 0), ("warning", 0), ("failed", 1)])
def test_law_a_check_says_what_was_found_and_what_to_do(
    fake: Callable[..., Any], verdict: str, status: int
) -> None:
    fake(device=verdict)
    found = connect("--check", "b.toml")
    assert found.exit_code == status
    words = " ".join(found.stdout.split())
    assert "Side 2" in words
    assert f"device {verdict} no row came Start it." in words
    assert "No force was commanded" in words
    assert json.loads(connect("--check", "b.toml", "--json").stdout)["verdict"] == verdict


def test_law_a_program_that_is_left_behind_is_ended(fake: Callable[..., Any], tmp_path: Path) -> None:
    note = tmp_path / "note"
    fake(seconds=600.0, note=str(note))
    with RunningProgram(find_program(), ["run"]) as running:
        while not running.read(0.1)[0]:
            pass
    assert note.read_text() == "stop-requested 1\n"


def test_law_no_order_is_lost_or_cut_while_the_program_does_not_listen(fake: Callable[..., Any]) -> None:
    fake(seconds=600.0, deaf=0.5)
    heard: list[str] = []
    with RunningProgram(find_program(), ["run"]) as running:
        # more than a pipe holds
        for number in range(1500):
            running.order(f"mark note {number} {60 * 'x'}")
        running.order("stop")
        end = time.monotonic() + 60.0
        while "order-stop" not in heard and time.monotonic() < end:
            lines, _ = running.read(0.1)
            heard += [str(line["event"]) for line in lines if str(line.get("event")).startswith("order-")]
    assert heard == [*(f"order-mark note {number} {60 * 'x'}" for number in range(1500)), "order-stop"]


@pytest.mark.usefixtures("live_program")
def test_cross_the_demonstration_ends_by_itself_with_json(tmp_path: Path) -> None:
    process = as_process("--demo", "--seconds", "3", "--delay", "30ms", "--json", cwd=tmp_path)
    out, errors = process.communicate(timeout=100)
    assert process.returncode == 0, errors
    result = json.loads(out)
    assert result["round_trip"] > 0.058
    assert 0.0 <= result["loss"] < 0.5
    assert result["te"] > 0.0
    assert 0.0 <= result["limited_share"] <= 1.0
    assert {event["side"] for event in result["events"]} == {1, 2}
    assert len(result["recordings"]) == 2
    assert (tmp_path / result["recording"]).stat().st_size > 0


@pytest.mark.usefixtures("live_program")
def test_cross_the_program_leaves_when_its_parent_is_killed(tmp_path: Path) -> None:
    process = as_process("--demo", "--seconds", "600", stdin=subprocess.PIPE, cwd=tmp_path)
    assert process.stdout is not None
    process.stdout.readline()
    child = _child(process)
    process.kill()
    process.communicate()

    def is_gone() -> bool:
        # A zombie has ended; whoever adopted it has yet to notice.
        state = Path(f"/proc/{child}/stat")
        return not state.exists() or state.read_text().rsplit(")", 1)[1].split()[0] == "Z"

    wait_for(is_gone)
