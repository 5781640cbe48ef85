"""The devices in Python and C that docs/device-protocol.md shows: which commands they believe."""

from __future__ import annotations

import math
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from drivers.device_protocol import COMMAND, STATE

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def command(sequence: float, x: float, *, version: float = 1.0, is_over: bool = False) -> bytes:
    return COMMAND.pack(version, sequence, 0.0, 0.0, x, 0.0, 1.0, float(is_over))


@pytest.fixture(params=["python", "c"])
def device(request: pytest.FixtureRequest, tmp_path: Path) -> list[str]:
    """Return the command that starts a device."""
    if request.param == "python":
        return [sys.executable, str(EXAMPLES / "device.py")]
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler cc on the path")
    program = tmp_path / "device"
    subprocess.run([compiler, "-std=c11", "-O2", "-o", program, EXAMPLES / "device.c", "-lm"], check=True)
    return [str(program)]


def test_law_a_device_believes_newer_finite_commands_up_to_its_limit(device: list[str]) -> None:
    port = free_port()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as site:
        site.bind(("127.0.0.1", 0))
        site.settimeout(30.0)
        places = ["--listen", f"127.0.0.1:{port}", "--site", f"127.0.0.1:{site.getsockname()[1]}"]
        robot = subprocess.Popen([*device, *places], stdout=subprocess.PIPE, text=True)
        site.recv(1024)  # it runs
        site.connect(("127.0.0.1", port))

        def speed() -> float:
            """Return the mean speed of the handle along x over the next rows, m/s."""
            while True:  # rows that wait
                site.setblocking(False)
                try:
                    site.recv(1024)
                except BlockingIOError:
                    break
            site.settimeout(30.0)
            speeds = [float(STATE.unpack(site.recv(1024))[5]) for _ in range(40)]
            assert all(map(math.isfinite, speeds))
            return sum(speeds) / len(speeds)

        # no commands: no number, infinite, of another version, too short
        for bad in (
            command(1.0, math.nan),
            command(math.inf, 9.0),
            command(2.0, -9.0, version=2.0),
            b"\0" * 63,
        ):
            site.send(bad)
        assert abs(speed()) < 0.1
        site.send(command(1000.0, -1000.0))
        speed()
        # one that is older does not count
        site.send(command(5.0, 0.0, is_over=True))
        time.sleep(0.2)
        assert robot.poll() is None
        site.send(command(2000.0, 0.0, is_over=True))
        said, _ = robot.communicate(timeout=30)
    assert robot.returncode == 0
    largest = float(said.split(" N at most")[0].split()[-1])
    assert largest == pytest.approx(20.0)
