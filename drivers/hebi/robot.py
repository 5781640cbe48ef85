"""What the robot does with what it hears: limits, ramps and flags. It knows no module, socket or clock."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from drivers.device_protocol import Command, State
from drivers.hebi import kinematics
from drivers.hebi.kinematics import Arm, Matrix, Pair

FORGET = 1.0  # s without a command, after which one of a telespring-link started anew is believed
NOTHING = (0.0, 0.0)


@dataclass(frozen=True)
class Limits:
    """What person and robot bear."""

    force: float  # N, of the motors on the handle
    effort: Pair  # N·m, or N for a linear joint; of each joint
    velocity: float  # m/s, of the handle
    workspace: tuple[Pair, Pair]  # m, lowest and highest x and y of the handle
    joints: tuple[Pair, Pair]  # rad or m, lowest and highest of what each joint reports
    deadline: float  # s without a command, after which the force falls
    fall: float  # s from the whole force to zero, and back
    feedback: float  # s without feedback, after which the robot is not ready


@dataclass(frozen=True)
class Feedback:
    """What the modules report at one time."""

    joints: Pair  # rad or m
    rates: Pair  # rad/s or m/s
    efforts: Pair  # N·m or N, at the outputs of the modules
    is_stopped: bool = False  # the M-stop is pressed
    is_weak: bool = False  # a module cannot give what it is told, for instance for its temperature

    def is_whole(self) -> bool:
        """Return whether every number is one."""
        return all(map(math.isfinite, (*self.joints, *self.rates, *self.efforts)))


class Robot:
    """The robot behind the device protocol.

    The force is a share of the wanted one. The share rises to 1 within `fall` while commands of a running
    session come and nothing is wrong, and falls to 0 within `fall` otherwise; an M-stop makes it 0 at once. A
    fault stays until its cause is gone and no session runs.
    """

    def __init__(self, arm: Arm, limits: Limits) -> None:
        self._arm, self._limits = arm, limits
        self._start: float | None = None
        self._ticked: float | None = None
        self._newest = Command(0.0, NOTHING, is_running=False)
        self._told = -math.inf
        self._seen = -math.inf
        self._rows = 0
        self._position = self._velocity = NOTHING
        self._jacobian: Matrix | None = None
        self._measured: Pair | None = None
        self._is_homed = self._is_stopped = self._is_weak = False
        self._is_released = False
        self.share = 0.0
        self.fault: str | None = "no-feedback"

    def release(self) -> None:
        """Let the force fall, and report that the motors do not act, for good."""
        self._is_released = True

    def hear(self, now: float, commands: Iterable[Command]) -> None:
        """Take commands: each counts if it is newer than all before."""
        for command in commands:
            if now - self._told > FORGET:
                self._newest = Command(0.0, NOTHING, is_running=False)
            if command.sequence > self._newest.sequence:
                self._newest, self._told = command, now

    def tick(self, now: float, feedback: Feedback | None) -> tuple[State | None, Pair]:
        """Return the row to send, if there is anything to say, and the efforts of the joints from now on."""
        start = self._start = now if self._start is None else self._start
        is_new = feedback is not None and feedback.is_whole()
        if feedback is not None and is_new:
            self._see(now, feedback)
        cause = self._cause(now)
        is_running = self._newest.is_running and now - self._told <= FORGET
        if cause is not None:
            self.fault = cause
        elif not is_running:
            self.fault = None
        efforts = self._efforts(now)
        if self._jacobian is None or not (is_new or cause == "no-feedback"):
            return None, efforts
        self._rows += 1
        state = State(
            sequence=float(self._rows),
            time=now - start,
            position=self._position,
            velocity=self._velocity,
            measured_force=self._measured if is_new else None,
            is_enabled=self.fault is None and not self._is_stopped and not self._is_released,
            is_homed=self._is_homed,
            is_stopped=self._is_stopped,
        )
        return state, efforts

    def _see(self, now: float, feedback: Feedback) -> None:
        self._seen = now
        self._jacobian = self._arm.jacobian(feedback.joints)
        self._position = self._arm.position(feedback.joints)
        self._velocity = kinematics.velocity(self._jacobian, feedback.rates)
        self._measured = kinematics.force(self._jacobian, feedback.efforts)
        self._is_stopped, self._is_weak = feedback.is_stopped, feedback.is_weak
        self._is_homed = all(
            low <= joint <= high
            for joint, (low, high) in zip(feedback.joints, self._limits.joints, strict=True)
        )

    def _cause(self, now: float) -> str | None:
        """Return what is wrong now, in a word."""
        limits = self._limits
        if self._jacobian is None or now - self._seen > limits.feedback:
            return "no-feedback"
        if not self._is_homed:
            return "not-homed"
        if kinematics.is_singular(self._jacobian):
            return "singular"
        if not all(
            low <= place <= high for place, (low, high) in zip(self._position, limits.workspace, strict=True)
        ):
            return "outside"
        if not math.hypot(*self._velocity) <= limits.velocity:
            return "too-fast"
        if self._is_weak:
            return "weak"
        return None

    def _efforts(self, now: float) -> Pair:
        limits, jacobian = self._limits, self._jacobian
        span = 0.0 if self._ticked is None else max(now - self._ticked, 0.0)
        self._ticked = now
        is_told = self._newest.is_running and now - self._told <= limits.deadline
        if self.fault is None and is_told and not self._is_released:
            # a late tick takes no longer step
            self.share = min(self.share + min(span, limits.deadline) / limits.fall, 1.0)
        else:
            self.share = max(self.share - span / limits.fall, 0.0)
        if self._is_stopped or jacobian is None:
            self.share = 0.0
        if self.share == 0.0 or jacobian is None:
            return NOTHING
        x, y = self._newest.force
        size = math.hypot(x, y)
        share = self.share * min(1.0, limits.force / size) if size > 0.0 else 0.0
        one, two = kinematics.efforts(jacobian, (share * x, share * y))
        excess = max(abs(one) / limits.effort[0], abs(two) / limits.effort[1], 1.0)
        return (one / excess, two / excess)
