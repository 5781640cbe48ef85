"""The study that a command works on: its file, and what the command line puts in place of parts of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from telespring._errors import InvalidInput
from telespring.cli.common import robot_records
from telespring.cli.robots import GivenRobot, read_robots
from telespring.model import Study

if TYPE_CHECKING:
    from telespring.study.robot_file import RobotRecord

__all__ = ["StudyOptions"]

_PAPER_TITLE = "The paper's two H-MANs (Du, Kulkarni, Kager and Campolo)"


@dataclass
class StudyOptions:
    """A study file and the options that override it; they are merged before anything is checked.

    Attributes
    ----------
    file
        The study file; None for the paper's robots.
    robots
        Robots 1 and 2 of the command line.
    options
        The option that gave a field of the study, for refusals.
    notes
        Sentences that say how the options were understood.
    """

    file: Path | None
    robots: tuple[GivenRobot | None, GivenRobot | None] = (None, None)
    options: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    _sections: dict[str, Any] = field(default_factory=dict)
    _backward: float | None = None

    def take_robots(
        self, both: list[str] | None = None, robot1: str | None = None, robot2: str | None = None
    ) -> None:
        """Take robots from the command line."""
        self.robots = read_robots(both, robot1, robot2, is_study_given=self.file is not None)
        for number, robot in enumerate(self.robots, start=1):
            # A file's own fields and lines are named, and the file itself.
            if robot is not None and not isinstance(robot.source, Path):
                self.options[f"robot{number}"] = f"{robot.option} ({robot.name})"

    def take(self, section: str, key: str, value: object, option: str) -> None:
        """Take one value from an option, unless it is None."""
        if value is None:
            return
        self._sections.setdefault(section, {})[key] = value
        self.options[f"{section}.{key}"] = option

    def take_delay(self, delay: float | None, backward: float | None) -> None:
        """Take the one-way delays from --delay and --backward."""
        if backward is None:
            self.take("network", "delay", delay, "--delay")
        elif delay is None:
            self._backward = backward
            self.options["network.delay.backward"] = "--backward"
        else:
            self.take("network", "delay", {"forward": delay, "backward": backward}, "--delay")
            self.options = {
                "network.delay.forward": "--delay",
                "network.delay.backward": "--backward",
                **self.options,
            }

    def allow_unusual(self, *, is_allowed: bool) -> None:
        """Accept values that no laboratory has."""
        if is_allowed:
            self._sections["allow_unusual"] = True

    def read(self, base: Study | None = None) -> Study:
        """Read the study, changed as the options ask.

        Without a file it is `base`, or the paper's robots with neither stiffness nor delay.
        """
        sources = tuple(None if robot is None else robot.source for robot in self.robots)
        robots = (sources[0], sources[1])
        if self.file is not None:
            study = Study.read(self.file, robots=robots, **self._sections)
        else:
            base = base or Study.paper().replace(coupling=None, network=None, controller=None)
            changes = dict(self._sections)
            if any(self.robots):
                changes["name"] = self.title(base)
            study = Study.from_toml(base.to_toml(), robots=robots, **changes)
        if self._backward is None:
            return study
        if not study.has_delay:
            raise InvalidInput("--delay", "", "s, one way", "Give --delay too, the delay from robot 1 to 2.")
        delay = {"forward": study.delay[0], "backward": self._backward}
        return study.replace(network={"delay": delay})

    def title(self, study: Study) -> str:
        """Name the study, and the robots that were put into it."""
        given = [robot for robot in self.robots if robot is not None]
        if self.file is None:
            if not given:
                return _PAPER_TITLE
            return f"Robot 1 ({given[0].name}) and robot 2 ({given[1].name})"
        named = [
            f"robot {number} ({robot.name})"
            for number, robot in enumerate(self.robots, start=1)
            if robot is not None
        ]
        return f"{study.name}, with {' and '.join(named)}" if named else study.name

    def records(self) -> tuple[RobotRecord | None, RobotRecord | None]:
        """Read what identification recorded about the robots of the command line."""
        return robot_records(*(None if robot is None else robot.source for robot in self.robots))
