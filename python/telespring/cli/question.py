"""The study that a command works on: its file, and what the command line puts in place of parts of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from telespring._core import check_usual
from telespring._errors import InvalidInput
from telespring.cli.common import robot_records
from telespring.cli.other_files import naming_the_file
from telespring.cli.robots import GivenRobot, read_robots
from telespring.cli.units import WithUnit
from telespring.model import Study
from telespring.show.quantities import format_time

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
    written
        Numbers of options as they were written, if with a unit, for refusals.
    notes
        Sentences that say how the options were understood.
    """

    file: Path | None
    robots: tuple[GivenRobot | None, GivenRobot | None] = (None, None)
    options: dict[str, str] = field(default_factory=dict)
    written: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    _sections: dict[str, Any] = field(default_factory=dict)
    _backward: float | None = None

    @property
    def inputs(self) -> list[Path]:
        """The files that the study is read from."""
        robots = [robot.source for robot in self.robots if robot is not None]
        return [path for path in (self.file, *robots) if isinstance(path, Path)]

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
        if isinstance(value, WithUnit):
            self.written[option] = value.text
            value = float(value)
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

    def take_ping(
        self,
        ping: float | None,
        delay: float | None,
        backward: float | None,
        *,
        jitter: float | None = None,
        ping_jitter: float | None = None,
        check_unusual: bool = True,
    ) -> None:
        """Take the delays and their jitter, one-way or as a round trip; say how a round trip is shared."""
        _refuse_doubled(ping, delay, backward, jitter, ping_jitter)
        if check_unusual:
            _refuse_unusual_ping(ping, ping_jitter)
        if ping is not None:
            delay = 0.5 * ping
            self.notes.append(
                f"A ping of {format_time(ping, 6)} counts as {format_time(delay, 6)} each way. Sampled "
                "controllers round each way up to whole sample periods: if the ping is shared otherwise, "
                "the sum may be one period longer."
            )
        if ping_jitter is not None:
            jitter = ping_jitter
            self.notes.append(
                f"A ping that varies by {format_time(jitter, 6)} may do so on one way alone: each way counts "
                "with all of it." + ("" if ping is None else _ping_range(ping, ping_jitter))
            )
        self.take_delay(delay, backward)
        if ping is not None:
            self.options["network.delay"] = "--ping"
        self.take("network", "jitter", jitter, "--jitter" if ping_jitter is None else "--ping-jitter")

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
        try:
            if self.file is not None:
                study = Study.read(self.file, robots=robots, **self._sections)
            else:
                base = base or Study.paper().replace(coupling=None, network=None, controller=None)
                changes = dict(self._sections)
                if any(self.robots):
                    changes["name"] = self.title(base)
                study = Study.from_toml(base.to_toml(), robots=robots, **changes)
        except InvalidInput as refused:
            raise naming_the_file(refused, self.file) from None
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

    def heading(self, study: Study) -> str:
        """Name the study without its robots; empty where only the robots are given."""
        if self.file is not None:
            return study.name
        return "" if any(self.robots) else _PAPER_TITLE

    def robot_names(self, study: Study) -> tuple[str | None, str | None]:
        """Name the robots: by the command line, or as the study does."""
        one, other = (
            named if robot is None else robot.label
            for robot, named in zip(self.robots, study.robot_names, strict=True)
        )
        return one, other

    def note_robots(self, study: Study) -> None:
        """Say which robots of the command line have one number for several axes."""
        axes = study.dyad.axes
        for number, robot in enumerate(self.robots, start=1):
            if robot is not None and robot.is_for_every_axis and len(axes) > 1:
                self.notes.append(
                    f"Robot {number} is given by one mass and one damping: they count for each of the axes "
                    f"{' and '.join(axes)}."
                )

    def records(self) -> tuple[RobotRecord | None, RobotRecord | None]:
        """Read what identification recorded about the robots of the command line."""
        return robot_records(*(None if robot is None else robot.source for robot in self.robots))


def _refuse_doubled(
    ping: float | None,
    delay: float | None,
    backward: float | None,
    jitter: float | None,
    ping_jitter: float | None,
) -> None:
    if ping is not None and (delay is not None or backward is not None):
        raise InvalidInput(
            "--ping",
            format_time(ping, 6),
            "it gives the delay both ways",
            "Leave out --delay and --backward, or --ping.",
        )
    if ping_jitter is not None and jitter is not None:
        raise InvalidInput(
            "--ping-jitter",
            format_time(ping_jitter, 6),
            "it gives the jitter of both ways",
            "Leave out --jitter or --ping-jitter.",
        )


def _ping_range(ping: float, jitter: float) -> str:
    """Say which round trips are meant; a jitter above the ping may be the largest ping."""
    text = f" Pings from {format_time(ping, 6)} (the smallest) to {format_time(ping + jitter, 6)} are meant."
    if jitter > ping:
        text += " If the jitter that you gave is itself the largest ping, subtract the smallest."
    return text


def _refuse_unusual_ping(ping: float | None, ping_jitter: float | None) -> None:
    """Refuse a ping that no laboratory has as it was written, not the half of it that goes one way."""
    if ping is not None:
        try:
            check_usual("delay", "--ping", 0.5 * ping)
        except InvalidInput:
            check_usual("delay", "--ping", ping)
    if ping_jitter is not None:
        check_usual("time span", "--ping-jitter", ping_jitter)
