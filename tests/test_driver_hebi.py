"""The HEBI driver: kinematics against closed forms, and what the robot does with commands and feedback."""

from __future__ import annotations

import ast
import math
import socket
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.device_protocol import COMMAND, STATE, Command, State
from drivers.hebi import kinematics
from drivers.hebi.kinematics import Arm, Axes, TwoLink
from drivers.hebi.robot import Feedback, Limits, Robot
from drivers.hebi.settings import BadSetting, Settings, read

ROOT = Path(__file__).resolve().parent.parent
ARM_FILE = ROOT / "drivers" / "hebi" / "arm.toml"
ENVIRONMENT = ROOT / "drivers" / "hebi" / ".venv" / "bin" / "python"
MILLISECOND = 0.001

ARM = Arm(TwoLink((0.325, 0.3)), zero=(0.1, -0.2), direction=(1.0, -1.0), base=(0.05, -0.4), turn=0.3)
LIMITS = Limits(
    force=20.0,
    effort=(1.0, 1.0),
    velocity=1.0,
    workspace=((-0.1, 0.1), (-0.2, 0.2)),
    joints=((-1.0, 1.0), (-2.0, 2.0)),
    deadline=0.02,
    fall=0.1,
    feedback=0.02,
)
# a drive per axis whose effort is the force
PLAIN = Arm(Axes((1.0, 1.0)))
REST = Feedback(joints=(0.0, 0.0), rates=(0.0, 0.0), efforts=(0.0, 0.0))


class Run:
    """A robot, ticked every millisecond."""

    def __init__(self, limits: Limits = LIMITS) -> None:
        self.robot = Robot(PLAIN, limits)
        self.now = 100.0
        self.sequence = 0.0
        self.state: State | None = None
        self.efforts = (0.0, 0.0)
        self.tick((0.0, 0.0), is_running=False, times=2)

    def tick(
        self,
        force: tuple[float, float] | None = (0.5, 0.0),
        feedback: Feedback | None = REST,
        *,
        is_running: bool = True,
        times: int = 1,
    ) -> None:
        for _ in range(times):
            self.now += MILLISECOND
            if force is not None:
                self.sequence += 1.0
                self.robot.hear(self.now, [Command(self.sequence, force, is_running)])
            self.state, self.efforts = self.robot.tick(self.now, feedback)

    def fault(self) -> str | None:
        return self.robot.fault

    def up(self) -> Run:
        """Tick until the whole force acts."""
        self.tick(times=110)
        assert self.efforts == (0.5, 0.0)
        return self


def test_ref_two_links_are_where_trigonometry_says() -> None:
    chain = TwoLink((0.3, 0.2))
    assert chain.position((0.0, 0.0)) == (0.5, 0.0)
    np.testing.assert_allclose(chain.position((math.pi / 2, -math.pi / 2)), (0.2, 0.3), atol=1e-15)
    # a cubit-and-hand triangle: the law of cosines
    x, y = chain.position((0.4, 1.1))
    expected = 0.3**2 + 0.2**2 + 2 * 0.3 * 0.2 * math.cos(1.1)
    assert math.isclose(x * x + y * y, expected, rel_tol=1e-14)


def test_law_the_jacobian_is_the_slope_of_the_position() -> None:
    for arm in (ARM, Arm(Axes((0.02, 1.0)), zero=(3.0, 0.1), direction=(-1.0, 1.0), turn=-0.7)):
        joints, step = np.array([0.4, -1.3]), 1e-6
        slope = np.column_stack(
            [
                (
                    np.array(arm.position((joints + move).tolist()))
                    - np.array(arm.position((joints - move).tolist()))
                )
                / (2 * step)
                for move in step * np.eye(2)
            ]
        )
        jacobian = arm.jacobian(joints.tolist())
        np.testing.assert_allclose(jacobian, slope, atol=1e-9)
        rates = (0.7, -0.2)
        np.testing.assert_allclose(kinematics.velocity(jacobian, rates), slope @ rates, atol=1e-9)


def test_law_efforts_do_the_work_of_the_force_and_tell_it_back() -> None:
    jacobian, force, rates = ARM.jacobian((0.2, -1.0)), (3.0, -5.0), (0.4, 0.9)
    efforts = kinematics.efforts(jacobian, force)
    assert math.isclose(np.dot(efforts, rates), np.dot(force, kinematics.velocity(jacobian, rates)))
    told = kinematics.force(jacobian, efforts)
    assert told is not None
    np.testing.assert_allclose(told, force, rtol=1e-12)


def test_law_a_stretched_arm_is_singular() -> None:
    chain = TwoLink((0.3, 0.2))
    for elbow, is_singular in ((0.0, True), (math.pi, True), (0.01, True), (0.3, False), (1.5, False)):
        jacobian = chain.jacobian((0.4, elbow))
        assert kinematics.is_singular(jacobian) is is_singular, elbow
        assert (kinematics.force(jacobian, (1.0, 1.0)) is None) is is_singular
    # the ratio of the singular values is what the name says
    values = np.linalg.svd(chain.jacobian((0.4, 0.05)), compute_uv=False)
    expected = bool(values[1] * values[0] <= 0.01 * (values**2).sum())
    assert kinematics.is_singular(chain.jacobian((0.4, 0.05))) is expected
    assert kinematics.is_singular(((math.nan, 0.0), (0.0, 1.0)))


def test_law_the_force_rises_and_falls_with_the_commands() -> None:
    run = Run()
    run.tick((0.5, 0.0), times=50)
    assert math.isclose(run.efforts[0], 0.25, rel_tol=0.05)
    run.tick(times=60)
    assert run.efforts == (0.5, 0.0)
    # silence: held for the deadline, then a ramp
    run.tick(None, times=19)
    assert run.efforts == (0.5, 0.0)
    run.tick(None, times=52)
    assert math.isclose(run.efforts[0], 0.25, rel_tol=0.05)
    assert run.state is not None
    assert run.state.is_enabled
    run.tick(None, times=60)
    assert run.efforts == (0.0, 0.0)
    # and in again from zero
    run.tick()
    assert 0.0 < run.efforts[0] < 0.01


def test_law_no_tick_changes_the_force_by_more_than_the_ramp_does() -> None:
    run, last = Run(), 0.0
    for tick in range(1500):
        silent, blind = 300 < tick < 400, 900 < tick < 950
        run.tick(None if silent else (1.0, 0.0), None if blind else REST)
        assert abs(run.efforts[0] - last) <= 1.0 * MILLISECOND / LIMITS.fall + 1e-12, tick
        last = run.efforts[0]


def test_law_a_long_tick_is_no_step() -> None:
    run = Run()
    run.tick((1.0, 0.0))
    run.now += 5.0
    run.tick((1.0, 0.0))
    assert run.efforts[0] <= 0.25
    run.tick((1.0, 0.0), times=200)
    run.now += 5.0
    run.tick(None)
    assert run.efforts == (0.0, 0.0)


def test_law_the_force_is_limited_along_its_direction() -> None:
    run = Run(replace(LIMITS, force=0.5, effort=(100.0, 100.0)))
    run.tick((30.0, -40.0), times=200)
    np.testing.assert_allclose(run.efforts, (0.3, -0.4))
    run = Run(replace(LIMITS, effort=(1.0, 0.1)))
    run.tick((0.5, 0.5), times=200)
    np.testing.assert_allclose(run.efforts, (0.1, 0.1))


@pytest.mark.parametrize(
    ("cause", "feedback"),
    [
        ("not-homed", Feedback((1.1, 0.0), (0.0, 0.0), (0.0, 0.0))),
        ("outside", Feedback((0.0, 0.21), (0.0, 0.0), (0.0, 0.0))),
        ("too-fast", Feedback((0.0, 0.0), (0.8, -0.8), (0.0, 0.0))),
        ("weak", Feedback((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), is_weak=True)),
        ("no-feedback", None),
        ("no-feedback", Feedback((0.0, math.nan), (0.0, 0.0), (0.0, 0.0))),
    ],
)
def test_law_a_fault_lets_the_force_fall_and_stays_while_the_session_runs(
    cause: str, feedback: Feedback | None
) -> None:
    run = Run().up()
    run.tick(feedback=feedback, times=25)
    assert run.fault() == cause
    assert run.state is not None
    assert not run.state.is_enabled
    assert run.state.is_homed is (cause != "not-homed")
    run.tick(feedback=feedback, times=110)
    assert run.efforts == (0.0, 0.0)
    run.tick(times=200)
    assert (run.fault(), run.efforts) == (cause, (0.0, 0.0))
    # the session has ended
    run.tick((0.0, 0.0), is_running=False)
    assert run.fault() is None
    assert run.state.is_enabled


def test_law_a_robot_that_starts_amid_a_session_waits_for_its_end() -> None:
    robot = Robot(PLAIN, LIMITS)
    for tick, is_running in ((1, True), (2, True), (3, False), (4, True)):
        robot.hear(0.001 * tick, [Command(float(tick), (1.0, 0.0), is_running)])
        state, efforts = robot.tick(0.001 * tick, REST)
        assert state is not None
        assert state.is_enabled is (tick > 2)
        assert (efforts[0] > 0.0) is (tick > 3)


def test_law_a_short_gap_of_the_feedback_is_no_fault_and_no_row() -> None:
    run = Run().up()
    run.tick(feedback=None, times=10)
    assert (run.fault(), run.state, run.efforts) == (None, None, (0.5, 0.0))


def test_law_an_m_stop_ends_the_force_at_once() -> None:
    run = Run().up()
    run.tick(feedback=Feedback((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), is_stopped=True))
    assert run.efforts == (0.0, 0.0)
    assert run.state is not None
    assert (run.state.is_stopped, run.state.is_enabled) == (True, False)
    run.tick()
    assert 0.0 < run.efforts[0] < 0.01


def test_law_a_released_robot_lets_go_for_good() -> None:
    run = Run().up()
    run.robot.release()
    run.tick(times=101)
    assert run.efforts == (0.0, 0.0)
    assert run.state is not None
    assert not run.state.is_enabled


def test_law_old_commands_change_nothing() -> None:
    run = Run().up()
    run.robot.hear(run.now, [Command(3.0, (-1.0, 0.0), True)])
    run.tick(None)
    assert run.efforts == (0.5, 0.0)
    # a telespring-link started anew counts from 1; it is believed once the force is long gone
    run.now += 1.1
    run.tick(None)
    run.robot.hear(run.now, [Command(1.0, (-1.0, 0.0), True)])
    run.tick(None)
    assert -0.02 < run.efforts[0] < 0.0


def test_law_the_row_says_what_the_modules_report() -> None:
    robot = Robot(Arm(Axes((0.5, 2.0)), base=(0.01, 0.02)), LIMITS)
    feedback = Feedback(joints=(0.1, 0.05), rates=(0.2, -0.1), efforts=(0.5, 3.0))
    assert robot.tick(5.0, None)[0] is None
    first, _ = robot.tick(5.001, feedback)
    second, _ = robot.tick(5.002, feedback)
    assert first is not None
    assert second is not None
    assert (first.sequence, second.sequence) == (1.0, 2.0)
    assert math.isclose(second.time, 0.002, rel_tol=1e-6)
    np.testing.assert_allclose(second.position, (0.06, 0.12))
    np.testing.assert_allclose(second.velocity, (0.1, -0.2))
    assert second.measured_force == (1.0, 1.5)


def test_law_rows_are_those_of_the_page() -> None:
    page = (ROOT / "docs" / "device-protocol.md").read_text(encoding="utf-8")
    assert f"From the device: {STATE.size // 8} doubles, {STATE.size} bytes" in page
    assert f"To the device: {COMMAND.size // 8} doubles, {COMMAND.size} bytes" in page
    state = State(7.0, 8.0, (1.0, 2.0), (3.0, 4.0), (5.0, 6.0), True, False, True)
    assert STATE.unpack(state.encode()) == (1, 7, 8, 1, 2, 3, 4, 5, 6, 1, 1, 0, 1)
    row = COMMAND.pack(1, 9, 7, 8, -1.0, 2.0, 1, 0)
    assert Command.decode(row) == Command(9.0, (-1.0, 2.0), True)
    for bad in (
        bytes(64),
        row[:56],
        COMMAND.pack(2, 9, 7, 8, 0, 0, 1, 0),
        COMMAND.pack(1, 9, 7, 8, 0, 0, 0.5, 0),
        COMMAND.pack(1, 9, 7, 8, math.nan, 0, 1, 0),
    ):
        assert Command.decode(bad) is None


def _read(path: Path) -> Settings:
    def no_model(_path: Path) -> TwoLink:
        raise AssertionError("no HRDF is named")

    return read(path, no_model)


def test_law_the_arm_file_is_refused_with_the_key(tmp_path: Path) -> None:
    good = ARM_FILE.read_text(encoding="utf-8")
    settings = _read(ARM_FILE)
    assert settings.arm.chain == TwoLink((0.325, 0.3))
    for old, new, said in (
        ("rate = 1000.0", "rate = 1e4", "modules.rate"),
        ('names = ["shoulder", "elbow"]', 'names = ["shoulder"]', "modules.names"),
        ('family = "Arm"', "", "modules.family is missing"),
        ('kind = "two-link"', 'kind = "delta"', "arm.kind"),
        ("direction = [1.0, 1.0]", "direction = [1.0, 0.5]", "arm.direction"),
        ("force = 20.0", "force = nan", "limits.force"),
        ("force = 20.0", "force = true", "limits.force"),
        ("x = [-0.12, 0.12]", "x = [0.12, -0.12]", "limits.x"),
        ("x = [-0.12, 0.12]", "x = [-0.12, 0.5]", "limits.x and limits.y"),
        ("base = [0.0, -0.4]", "base = [0.0, 0.0]", "limits.x and limits.y"),
        ("lifetime = 0.1", "lifetime = 0.02", "modules.lifetime"),
        ("deadline = 0.02", "deadlin = 0.02", "limits.deadlin"),
        ("[limits]", "[limit]", "limits"),
    ):
        assert old in good
        path = tmp_path / "arm.toml"
        path.write_text(good.replace(old, new), encoding="utf-8")
        with pytest.raises(BadSetting, match=said):
            _read(path)
    with pytest.raises(BadSetting, match="cannot be read"):
        _read(tmp_path / "absent.toml")


HRDF = """<?xml version="1.0" encoding="UTF-8"?>
<robot version="1.4.0">
  <actuator type="X5-4"/> <link type="X5" extension="0.325" twist="0"/>
  <actuator type="X5-4"/> <link type="X5" extension="0.3" twist="0"/>
  <end-effector type="Custom"/>
</robot>
"""
POSE = """
from pathlib import Path
from drivers.hebi.modules import RobotModel
model = RobotModel(Path(r"{path}"))
print(model.position((0.3, 1.2)), *model.jacobian((0.3, 1.2)), sep="\\n")
"""


def _environment() -> str:
    """Return the Python of the driver's own environment; skip the test without it."""
    if not ENVIRONMENT.exists():
        pytest.skip("hebi-py was not tried: set drivers/hebi/.venv up as its README.md says")
    return str(ENVIRONMENT)


def test_cross_the_robot_model_of_hebi_py_is_the_two_link_arm(tmp_path: Path) -> None:
    python, path = _environment(), tmp_path / "arm.hrdf"
    path.write_text(HRDF, encoding="utf-8")
    command = [python, "-c", POSE.format(path=path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=60)
    said = [ast.literal_eval(line) for line in done.stdout.splitlines()[-3:]]
    chain = TwoLink((0.325, 0.3))
    # hebi-py computes with single precision in places
    np.testing.assert_allclose(said, [chain.position((0.3, 1.2)), *chain.jacobian((0.3, 1.2))], atol=1e-6)


def test_cross_the_imitated_modules_of_hebi_py_are_commanded_and_report() -> None:
    """The efforts go through hebi-py and back; its imitation has no physics."""
    python = _environment()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as site:
        site.bind(("127.0.0.1", 0))
        site.settimeout(30.0)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            device = free.getsockname()
        command = [python, "-m", "drivers.hebi", str(ARM_FILE), "--imitation"]
        ends = ["--listen", f"127.0.0.1:{device[1]}", "--site", f"127.0.0.1:{site.getsockname()[1]}"]
        program = subprocess.Popen([*command, *ends], cwd=ROOT, stdout=subprocess.PIPE, text=True)
        try:
            settings, start = _read(ARM_FILE), time.monotonic()
            rows, measured, sequence = [], (0.0, 0.0), 0.0
            while math.dist(measured, (2.0, -1.0)) > 1e-5 and time.monotonic() - start < 30.0:
                rows.append(STATE.unpack(site.recv(512)))
                measured, sequence = rows[-1][7:9], sequence + 1.0
                site.sendto(COMMAND.pack(1, sequence, *rows[-1][1:3], 2.0, -1.0, 1, 0), device)
            middle = [(low + high) / 2.0 for low, high in settings.limits.joints]
            np.testing.assert_allclose(rows[-1][3:5], settings.arm.position(middle), atol=1e-6)
            np.testing.assert_allclose(measured, (2.0, -1.0), atol=1e-5)
            assert rows[-1][9:] == (1.0, 1.0, 1.0, 0.0)
            assert len(rows) > 10
            # the ramp of the driver
            assert math.hypot(*rows[1][7:9]) < 1.0
        finally:
            program.terminate()
            said, _ = program.communicate(timeout=30)
        assert program.returncode == 0
        assert "ready" in said
