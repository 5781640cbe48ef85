"""The HEBI modules: the only file that touches hebi-py."""

from __future__ import annotations

import time
from pathlib import Path

import hebi
import numpy as np

from drivers.hebi.kinematics import Matrix, Pair
from drivers.hebi.robot import Feedback
from drivers.hebi.settings import BadSetting, Settings

LOOK_UP = 2.0  # s, how long modules may take to answer a look-up
WAIT = 10  # ms, the longest wait for feedback


def _pair(values: np.ndarray) -> Pair:
    return (float(values[0]), float(values[1]))


class RobotModel:
    """The two-joint chain of a HEBI robot description (HRDF), in the plane x, y of its base."""

    def __init__(self, path: Path) -> None:
        try:
            self._model = hebi.robot_model.import_from_hrdf(str(path))
            self.position((0.0, 0.0))
            self.jacobian((0.0, 0.0))
        except Exception as error:  # hebi-py has an exception of its own that is not public
            raise BadSetting(f"{path} is no chain of two joints with an end effector: {error}") from error

    def position(self, angles: Pair) -> Pair:
        """Return the place of the end effector, m."""
        transform = self._model.get_end_effector(np.array(angles))
        return (float(transform[0, 3]), float(transform[1, 3]))

    def jacobian(self, angles: Pair) -> Matrix:
        """Return the change of the place per change of the joints."""
        (a, b), (c, d) = self._model.get_jacobian_end_effector(np.array(angles))[:2].tolist()
        return ((a, b), (c, d))


class Modules:
    """Two modules on the network, commanded by efforts."""

    def __init__(self, settings: Settings) -> None:
        self._group = self._find(settings)
        self._group.command_lifetime = round(1000 * settings.lifetime)
        self._group.feedback_frequency = settings.rate
        self._feedback = hebi.GroupFeedback(2)
        self._command = hebi.GroupCommand(2)

    def _find(self, settings: Settings) -> hebi.Group:
        lookup = hebi.Lookup()
        time.sleep(LOOK_UP)
        group = lookup.get_group_from_names([settings.family], list(settings.names))
        if group is None:
            seen = ", ".join(f"{entry.family}/{entry.name}" for entry in lookup.entrylist) or "none"
            wanted = ", ".join(f"{settings.family}/{name}" for name in settings.names)
            raise BadSetting(f"modules.names: {wanted} do not both answer; modules on the network: {seen}")
        return group

    def read(self) -> Feedback | None:
        """Wait for the next feedback, and return it; None if none comes in time."""
        feedback = self._group.get_next_feedback(timeout_ms=WAIT, reuse_fbk=self._feedback)
        if feedback is None:
            return None
        return Feedback(
            joints=_pair(feedback.position),
            rates=_pair(feedback.velocity),
            efforts=_pair(feedback.effort),
            # 0 is "triggered", which a module that reports no M-stop says, too
            is_stopped=bool(np.any(np.asarray(feedback.mstop_state) != 1)),
            # 2 and 3: motor or electronics too hot, and the output is off
            is_weak=bool(np.any(np.asarray(feedback.temperature_state) >= 2)),
        )

    def apply(self, efforts: Pair) -> None:
        """Tell the modules their efforts, which they hold for their command lifetime."""
        self._command.effort = np.array(efforts)
        self._group.send_command(self._command)

    def release(self) -> None:
        """Command nothing any more: the modules let go."""
        self._command.clear()
        self._group.send_command(self._command)


class Imitation(Modules):
    """The imitation group of hebi-py: modules without physics that report what they are told.

    It stands in the middle of its joints' range, at rest; its efforts are those commanded.
    """

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self._middle = np.array([(low + high) / 2.0 for low, high in settings.limits.joints])
        self._period = 1.0 / settings.rate
        self.apply((0.0, 0.0))

    def _find(self, settings: Settings) -> hebi.Group:  # noqa: ARG002 (nobody to look for)
        return hebi.util.create_imitation_group(2)

    def read(self) -> Feedback | None:
        """Return what was commanded last, a period later."""
        time.sleep(self._period)
        told = super().read()
        return told and Feedback(joints=told.joints, rates=(0.0, 0.0), efforts=told.efforts)

    def apply(self, efforts: Pair) -> None:
        """Take the efforts, and stay in the middle."""
        self._command.position = self._middle
        super().apply(efforts)
