"""The bridge to LSL: rows, samples, events; and real outlets where pylsl is set up."""

from __future__ import annotations

import json
import math
import os
import re
import socket
import subprocess
import threading
import time
from pathlib import Path

import pytest

from drivers.lsl.bridge import CHANNELS, Bridge, Stream
from drivers.telemetry import (
    COLUMNS,
    PHASES,
    PLACE,
    ROW,
    WATCHDOGS,
    Mark,
    Row,
    Source,
    decode,
    decode_mark,
    word,
)

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = ROOT / "drivers" / "lsl" / ".venv" / "bin" / "python"


def row(sequence: float, **values: float) -> Row:
    """Return a row: what is not given is not known."""
    given = {
        "version": 1.0,
        "sequence": sequence,
        "side": 2.0,
        "time": 10.0 + 0.002 * sequence,
        "interval": 0.002,
    }
    given |= {"phase": 0.0, "missed": 0.0} | {name.replace("_", " "): value for name, value in values.items()}
    filled = [math.nan] * (ROW.size // 8)
    for name, value in given.items():
        filled[PLACE[name]] = value
    return tuple(filled)


class Kept:
    """Outlets that keep what they take."""

    def __init__(self, stream: Stream) -> None:
        self.stream = stream
        self.samples: list[tuple[float, list[float]]] = []
        self.events: list[tuple[float, str]] = []

    def push_samples(self, samples: list[list[float]], stamps: list[float]) -> None:
        self.samples += zip(stamps, samples, strict=True)

    def push_event(self, event: str, stamp: float) -> None:
        self.events.append((stamp, event))


def test_law_the_places_are_those_of_the_page() -> None:
    page = (ROOT / "docs" / "telemetry.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\| (\d+) \| ([^|]+?) \| ([^|]*?) ?\| ([^|]*?) ?\|$", page, re.MULTILINE)
    assert [(int(place), (name, unit)) for place, name, unit, _ in lines] == list(enumerate(COLUMNS))
    for name, words in (("phase", PHASES), ("watchdog", WATCHDOGS)):
        codes = ", ".join(f"{code} {each}" for code, each in enumerate(words))
        assert lines[PLACE[name]][3] == codes
    assert f"{ROW.size // 8} little-endian doubles (IEEE 754), 8 bytes each, {ROW.size} bytes" in page


def test_cross_a_row_of_the_program_is_read_place_by_place() -> None:
    """The program's own test writes this row: names and bytes, place by place."""
    lines = (ROOT / "tests" / "telemetry_row.txt").read_text(encoding="ascii").splitlines()
    written = [re.fullmatch(r"(\d+) (.+): ([0-9a-f]{16})", line) for line in lines]
    assert [int(each[1]) for each in written if each] == list(range(ROW.size // 8))
    names = [each[2] for each in written if each]
    assert names == [*(name for name, _ in COLUMNS), *["not used"] * (len(names) - len(COLUMNS))]
    read = decode(bytes.fromhex("".join(each[3] for each in written if each)))
    assert read is not None
    for name, value in {
        "side": 2.0,
        "time": 2.5,
        "position y": 2.0,
        "partner velocity x": 15.0,
        "force y": 10.0,
        "stiffness in use": 17.0,
        "balance": 11.0,
        "lateness": 0.00025,
        "interval": 0.002,
        "missed": 3.0,
    }.items():
        assert read[PLACE[name]] == value, name
    assert word(PHASES, read[PLACE["phase"]]) == "running"
    assert word(WATCHDOGS, read[PLACE["watchdog"]]) == "engaged"
    assert math.isnan(read[PLACE["marker"]])


def test_law_what_is_no_row_is_refused() -> None:
    good = row(1.0)
    packed = ROW.pack(*good)
    unpacked = decode(packed)
    assert unpacked is not None
    assert all(a == b or math.isnan(b) for a, b in zip(unpacked, good, strict=True))
    assert decode(packed[:-8]) is None
    assert decode(packed + bytes(8)) is None
    assert decode(bytes(ROW.size)) is None
    for bad in (
        {"version": 2.0},
        {"side": 3.0},
        {"side": math.nan},
        {"time": math.inf},
        {"interval": 0.0},
        {"interval": math.nan},
    ):
        assert decode(ROW.pack(*row(1.0, **bad))) is None, bad


def test_law_codes_become_words() -> None:
    assert word(PHASES, 5.0) == "running"
    assert word(PHASES, 17.0) == "17"
    assert word(PHASES, 0.5) == "0.5"
    assert word(PHASES, math.nan) is None


def test_law_samples_have_every_channel_and_the_time_of_the_tick() -> None:
    kept: list[Kept] = []

    def open_outlets(stream: Stream) -> Kept:
        kept.append(Kept(stream))
        return kept[-1]

    bridge = Bridge(open_outlets)
    assert not kept
    bridge.take([row(1.0, position_x=0.1), row(2.0, position_x=0.2)], offset=5.0)
    bridge.take([row(3.0, position_x=0.3)], offset=5.0)
    bridge.take([], offset=5.0)
    [outlets] = kept
    assert outlets.stream == Stream(2, 500.0)
    place = [name for name, _ in CHANNELS].index("position x")
    assert [(stamp, values[place]) for stamp, values in outlets.samples] == [
        (15.002, 0.1),
        (15.004, 0.2),
        (15.006, 0.3),
    ]
    assert all(len(values) == len(CHANNELS) for _, values in outlets.samples)
    # another rate is another stream
    bridge.take([row(4.0), row(5.0, interval=0.001), row(6.0, interval=0.001)], offset=0.0)
    assert [(each.stream.rate, len(each.samples)) for each in kept] == [(500.0, 4), (1000.0, 2)]


def test_law_what_changes_is_an_event() -> None:
    kept = Kept(Stream(2, 500.0))
    bridge = Bridge(lambda _stream: kept)
    bridge.take(
        [
            row(1.0),
            row(2.0),
            row(3.0, phase=5.0, watchdog=0.0),
            row(4.0, phase=5.0, watchdog=1.0, marker=7.0),
            row(5.0, phase=5.0, watchdog=1.0, marker=7.0, missed=12.0),
            row(6.0, phase=9.0, missed=12.0),
            row(1.0, phase=0.0),
        ],
        offset=0.0,
    )
    assert [event for _, event in kept.events] == [
        "session",
        "phase connecting",
        "phase running",
        "watchdog disengaged",
        "watchdog ramping-in",
        "marker 7",
        "missed 12",
        "phase ended",
        "session",
        "phase connecting",
    ]
    assert kept.events[2][0] == 10.006


def test_law_the_source_takes_rows_and_nothing_else() -> None:
    source = Source(("127.0.0.1", 0))
    listen = source._socket.getsockname()  # a free port was asked for
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        mark = b"mark 2.500000001 trial 7 with eyes closed"
        for datagram in (b"hello", ROW.pack(*row(1.0)), bytes(ROW.size), b"", mark, ROW.pack(*row(2.0))):
            sender.sendto(datagram, listen)
        rows: list[Row] = []
        marks: list[Mark] = []
        start = time.monotonic()
        while len(rows) < 2 and time.monotonic() - start < 30.0:
            taken = source.rows(0.1)
            rows += taken[0]
            marks += taken[1]
    assert marks == [Mark(2.500000001, "trial 7 with eyes closed")]
    assert [each[PLACE["sequence"]] for each in rows] == [1.0, 2.0]
    assert source.rows(0.0) == ([], [])
    source.close()


def test_law_a_marker_is_an_event() -> None:
    for bad in (b"", b"mark", b"mark 1.0", b"mark nan trial 7", b"note 1.0 trial 7", b"mark 1.0 note \xff"):
        assert decode_mark(bad) is None, bad
    assert decode_mark(b"mark 1.0 note " + 200 * b"x") is None
    page = (ROOT / "docs" / "telemetry.md").read_text(encoding="utf-8")
    example = "mark 2.500000001 trial 7 with eyes closed"
    assert f"`{example}`" in page
    mark = decode_mark(example.encode())
    assert mark is not None
    kept = Kept(Stream(2, 500.0))
    bridge = Bridge(lambda _stream: kept)
    bridge.mark([mark], offset=5.0)
    bridge.take([row(1.0)], offset=5.0)
    bridge.mark([mark], offset=5.0)
    assert kept.events[-1] == (7.500000001, "mark trial 7 with eyes closed")
    # the one before the first row has waited for it
    assert [event for _, event in kept.events].count("mark trial 7 with eyes closed") == 2
    # while nobody sends rows they take no memory
    late = Kept(Stream(2, 500.0))
    bridge = Bridge(lambda _stream: late)
    bridge.mark([mark] * 1000, offset=0.0)
    bridge.take([row(1.0)], offset=0.0)
    assert sum(event.startswith("mark ") for _, event in late.events) == 64


def test_law_two_sides_on_one_port_keep_their_outlets() -> None:
    kept: list[Kept] = []

    def open_outlets(stream: Stream) -> Kept:
        kept.append(Kept(stream))
        return kept[-1]

    bridge = Bridge(open_outlets)
    for number in range(1, 20):
        bridge.take([row(float(number)), row(float(number), side=1.0)], offset=0.0)
    assert [(each.stream.side, len(each.samples)) for each in kept] == [(2, 19), (1, 19)]
    assert [event for _, event in kept[0].events] == ["session", "phase connecting"]


READER = """
import json, sys, pylsl
def inlet(name):
    found = pylsl.resolve_byprop("name", name, timeout=60)
    return pylsl.StreamInlet(found[0])
samples, events = inlet("telespring-2"), inlet("telespring-2-events")
info = samples.info(timeout=60)
for each in (samples, events):
    each.open_stream(timeout=60)
channels = [info.get_channel_labels(), info.get_channel_units()]
print(json.dumps([info.nominal_srate(), info.type(), *channels]), flush=True)
taken = [samples.pull_sample(timeout=60) for _ in range(50)]
print(json.dumps([[stamp, values] for values, stamp in taken]), flush=True)
print(json.dumps(events.pull_sample(timeout=60)), flush=True)
"""


def test_cross_an_inlet_of_pylsl_reads_the_stream(tmp_path: Path) -> None:
    if not ENVIRONMENT.exists():
        pytest.skip("pylsl was not tried: set drivers/lsl/.venv up as its README.md says")
    # stay on this machine
    (tmp_path / "lsl_api.cfg").write_text("[multicast]\nResolveScope = machine\n", encoding="utf-8")
    environment = os.environ | {"LSLAPICFG": str(tmp_path / "lsl_api.cfg")}

    def start(*arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [str(ENVIRONMENT), *arguments], cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True
        )

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.bind(("127.0.0.1", 0))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            listen = free.getsockname()
        bridge = start("-m", "drivers.lsl", "--listen", f"127.0.0.1:{listen[1]}")
        reader = start("-c", READER)
        try:
            assert bridge.stdout is not None
            assert reader.stdout is not None
            clock = re.search(r"(-?[\d.]+) ± ([\d.]+) µs", bridge.stdout.readline())
            assert clock is not None
            # both clocks are the monotonic one of the machine
            assert abs(float(clock[1])) <= float(clock[2]) + 1.0
            sequence, phase, sent = 0.0, 0.0, {}
            said: list[str] = []
            listening = threading.Thread(target=lambda lines: said.extend(lines), args=(reader.stdout,))
            listening.start()
            while listening.is_alive():
                sequence += 1.0
                # after the inlets have opened, an event
                phase = float(PHASES.index("running")) if len(said) == 2 else 0.0
                now = time.monotonic()
                sent[sequence] = now
                values = row(sequence, time=now, phase=phase, position_x=sequence, balance=0.25)
                sender.sendto(ROW.pack(*values), listen)
                time.sleep(0.002)
        finally:
            for program in (reader, bridge):
                program.terminate()
                program.communicate(timeout=30)
    assert bridge.returncode == 0
    described, samples, (event, event_stamp) = map(json.loads, said)
    assert described[:2] == [500.0, "Haptics"]
    assert list(zip(*described[2:], strict=True)) == [(name, unit or "none") for name, unit in CHANNELS]
    place = {name: at for at, (name, _) in enumerate(CHANNELS)}
    for stamp, values in samples:
        number = values[place["position x"]]
        assert abs(stamp - sent[number]) < 1e-5
        assert values[place["balance"]] == 0.25
        assert math.isnan(values[place["age"]])
    numbers = [values[place["position x"]] for _, values in samples]
    assert numbers == sorted(set(numbers))
    assert event == ["phase running"]
    assert min(abs(event_stamp - stamp) for stamp in sent.values()) < 1e-5
