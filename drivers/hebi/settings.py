"""The arm file: what this program is told of a robot, checked."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivers.hebi.kinematics import Arm, Axes, Chain, Pair, TwoLink
from drivers.hebi.robot import Limits

LARGEST = 1e6


class BadSetting(Exception):
    """A key of the arm file, and what is wrong with it."""


@dataclass(frozen=True)
class Settings:
    """What an arm file says."""

    family: str
    names: tuple[str, str]
    arm: Arm
    limits: Limits
    rate: float  # Hz, how often the modules report
    lifetime: float  # s, after which a module drops the effort by itself


class _Table:
    """One table of the file: every key is taken once, and none is left over."""

    def __init__(self, name: str, table: object) -> None:
        if not isinstance(table, Mapping):
            raise BadSetting(f"[{name}] is missing" if table is None else f"{name} must be a table")
        self._name, self._table = name, dict(table)

    def take(self, key: str, usual: object = None) -> Any:
        if key not in self._table and usual is None:
            raise BadSetting(f"{self._name}.{key} is missing")
        return self._table.pop(key, usual)

    def number(self, key: str, least: float, most: float, usual: float | None = None) -> float:
        return _number(f"{self._name}.{key}", self.take(key, usual), least, most)

    def pair(self, key: str, least: float, most: float, usual: Pair | None = None) -> Pair:
        name, value = f"{self._name}.{key}", self.take(key, usual)
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise BadSetting(f"{name} must be two numbers")
        return (_number(name, value[0], least, most), _number(name, value[1], least, most))

    def range(self, key: str) -> Pair:
        low, high = self.pair(key, -LARGEST, LARGEST)
        if not low < high:
            raise BadSetting(f"{self._name}.{key} must be a lower and a higher number")
        return (low, high)

    def text(self, key: str) -> str:
        value = self.take(key)
        if not isinstance(value, str) or not value:
            raise BadSetting(f"{self._name}.{key} must be text")
        return value

    def end(self) -> None:
        for key in self._table:
            raise BadSetting(f"there is no key {self._name}.{key}")


def _number(name: str, value: object, least: float, most: float) -> float:
    # a bool is an int, and NaN lies in no range
    if isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= most:
        return float(value)
    raise BadSetting(f"{name} must be a number from {least:g} to {most:g}, not {value!r}")


def read(path: Path, robot_model: Callable[[Path], Chain]) -> Settings:
    """Return the settings of a file; `robot_model` reads a HEBI robot description (HRDF).

    Raises
    ------
    BadSetting
        With the key, and what is allowed.
    """
    try:
        text = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadSetting(f"{path} cannot be read: {error}") from error
    file = _Table("file", text)
    modules, arm = _Table("modules", file.take("modules")), _Table("arm", file.take("arm"))
    limits = _Table("limits", file.take("limits"))
    file.end()
    names = modules.take("names")
    if not (isinstance(names, list) and len(names) == 2 and all(isinstance(name, str) for name in names)):
        raise BadSetting("modules.names must be the names of two modules")
    settings = Settings(
        family=modules.text("family"),
        names=(names[0], names[1]),
        rate=modules.number("rate", 50.0, 1000.0, 1000.0),
        lifetime=modules.number("lifetime", 0.01, 0.5, 0.1),
        arm=_arm(arm, path.parent, robot_model),
        limits=_limits(limits),
    )
    for table in (modules, arm, limits):
        table.end()
    if not settings.lifetime > settings.limits.deadline:
        raise BadSetting("modules.lifetime must be longer than limits.deadline: the ramp comes first")
    _check_reach(settings)
    return settings


def _arm(table: _Table, folder: Path, robot_model: Callable[[Path], Chain]) -> Arm:
    kind = table.take("kind")
    chain: Chain
    if kind == "two-link":
        chain = TwoLink(table.pair("lengths", 0.01, 10.0))
    elif kind == "axes":
        chain = Axes(table.pair("scale", 1e-4, 10.0))
    elif kind == "hrdf":
        chain = robot_model(folder / table.text("file"))
    else:
        raise BadSetting(f'arm.kind must be "two-link", "axes" or "hrdf", not {kind!r}')
    direction = table.pair("direction", -1.0, 1.0, (1.0, 1.0))
    if not all(abs(sign) == 1.0 for sign in direction):
        raise BadSetting("arm.direction must be 1 or -1 for each joint")
    return Arm(
        chain,
        zero=table.pair("zero", -LARGEST, LARGEST, (0.0, 0.0)),
        direction=direction,
        base=table.pair("base", -100.0, 100.0, (0.0, 0.0)),
        turn=table.number("turn", -2.0 * math.pi, 2.0 * math.pi, 0.0),
    )


def _limits(table: _Table) -> Limits:
    return Limits(
        force=table.number("force", 0.1, 1000.0),
        effort=table.pair("effort", 0.01, 1000.0),
        velocity=table.number("velocity", 0.01, 10.0),
        workspace=(table.range("x"), table.range("y")),
        joints=(table.range("joint1"), table.range("joint2")),
        deadline=table.number("deadline", 0.005, 0.2, 0.02),
        fall=table.number("fall", 0.01, 2.0, 0.1),
        feedback=table.number("feedback", 0.005, 0.2, 0.02),
    )


def _check_reach(settings: Settings) -> None:
    """Refuse a workspace in which a two-link arm is, or is nearly, stretched or folded."""
    chain, (base_x, base_y) = settings.arm.chain, settings.arm.base
    if not isinstance(chain, TwoLink):
        return
    (left, right), (low, high) = settings.limits.workspace
    farthest = max(math.hypot(x - base_x, y - base_y) for x in (left, right) for y in (low, high))
    nearest = math.hypot(min(max(base_x, left), right) - base_x, min(max(base_y, low), high) - base_y)
    longest, shortest = sum(chain.lengths), abs(chain.lengths[0] - chain.lengths[1])
    margin = 0.02 * longest
    if farthest > longest - margin or nearest < shortest + margin:
        raise BadSetting(
            f"limits.x and limits.y lie from {nearest:.3f} to {farthest:.3f} m from arm.base; the arm "
            f"reaches from {shortest + margin:.3f} to {longest - margin:.3f} m with 2 % to spare"
        )
