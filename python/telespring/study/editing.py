"""A study with some of its values replaced, by way of its text, so that the one reader checks the result.

Examples
--------
>>> import telespring as ts
>>> heavier = with_values(ts.Study.paper(), {"arm1": {"kind": "lumped", "mass": 0.8}})
>>> heavier.experiment.arms[0]["mass"]
[0.8, 0.8]
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from telespring._errors import InvalidInput
from telespring.model import Study

__all__ = ["RobotRecord", "robot_record", "with_robot", "with_values"]

#: What a section may say in one of two ways: naming the one removes the other.
_INSTEAD_OF = {
    ("protocol", "conditions"): ("stiffness", "delay"),
    ("protocol", "stiffness"): ("conditions",),
    ("protocol", "delay"): ("conditions",),
}


def with_values(study: Study, values: Mapping[str, Mapping[str, object] | str]) -> Study:
    """Put values into the place of a study's own.

    Parameters
    ----------
    study
        The study to start from; it is not changed.
    values
        Sections as in a study file, each with the keys to set: numbers, texts, booleans, lists, mappings,
        or numpy arrays; None removes a key, so that its default holds. Keys that are not named stay as
        they are, except where a section gets another `kind`, which starts it anew, and where a protocol's
        `conditions` take the place of its lists of `stiffness` and `delay`, or these of those. `name` is
        the study's name.

    Returns
    -------
    telespring.Study
        The new study, checked as if it had been read from a file.

    Raises
    ------
    telespring.InvalidInput
        Where a value is refused, by its dotted field.

    Examples
    --------
    >>> import telespring as ts
    >>> stiff = with_values(ts.Study.paper(), {"coupling": {"stiffness": 140.0}, "protocol": {"trials": 5}})
    >>> stiff.stiffness, stiff.experiment.trials
    (140.0, 5)
    >>> with_values(stiff, {"coupling": {"stiffness": -1.0}})
    Traceback (most recent call last):
    telespring._errors.InvalidInput: coupling.stiffness = -1: a coupling stiffness must be a number ...
    """
    tables = tomllib.loads(study.to_toml())
    for name, changes in values.items():
        if not isinstance(changes, Mapping):
            tables[name] = _plain(name, changes)
            continue
        section = dict(tables.get(name, {}))
        if "kind" in changes and changes["kind"] != section.get("kind"):
            section = {}
        for key in changes:
            for other in _INSTEAD_OF.get((name, key), ()):
                section.pop(other, None)
        for key, value in changes.items():
            if value is None:
                section.pop(key, None)
            else:
                section[key] = _plain(f"{name}.{key}", value)
        if section:
            tables[name] = section
        else:
            tables.pop(name, None)
    return _read(tables)


def with_robot(study: Study, side: int, robot_toml: str | Path) -> Study:
    """Put a robot from a file of its own into a study, as `telespring identify` writes it.

    The file has the section `[robot]` with the keys that `[robot1]` and `[robot2]` have in a study: `name`,
    `axes`, `mass`, `damping`, `coulomb`, `mass_sd`, `damping_sd` and `mass_damping_correlation`. It may
    have a section `[identification]`, which is kept there as a record (`robot_record` reads it).

    Parameters
    ----------
    study
        The study to start from; it is not changed.
    side
        1 or 2: which robot it replaces, whole.
    robot_toml
        The file's path, or its text where it is a `str`.

    Returns
    -------
    telespring.Study
        The new study, checked.

    Raises
    ------
    telespring.InvalidInput
        Where the file is no such text, or the study refuses the robot.
    OSError
        Where the file cannot be read.

    Examples
    --------
    >>> import telespring as ts
    >>> text = '''
    ... [robot]
    ... mass = [0.84, 1.07]
    ... damping = [7.7, 10.1]
    ... mass_sd = 0.01
    ... '''
    >>> study = with_robot(ts.Study.paper(), 1, text)
    >>> study.dyad.robots[0].mass
    array([0.84, 1.07])
    >>> study.uncertainty[0].mass_sd
    array([0.01, 0.01])
    """
    if side not in (1, 2):
        raise InvalidInput("side", repr(side), "a dyad has the robots 1 and 2", "Choose one of them.")
    where, robot, _ = _robot_file(robot_toml)
    tables = tomllib.loads(study.to_toml())
    tables[f"robot{side}"] = robot
    try:
        return _read(tables)
    except InvalidInput as refused:
        allowed, remedy = (
            text.replace(f"[robot{side}]", "[robot]") for text in (refused.allowed, refused.remedy)
        )
        remedy = f"{remedy} See [robot] in {where}."
        raise InvalidInput(refused.field, refused.value, allowed, remedy) from None


@dataclass(frozen=True)
class RobotRecord:
    """What identification found besides a robot's parameters.

    Attributes
    ----------
    independent
        False where the axes are coupled by inertia, None where that is not known.
    warnings
        What was to be known before trusting the numbers, as sentences.
    """

    independent: bool | None
    warnings: tuple[str, ...]


def robot_record(robot_toml: str | Path) -> RobotRecord:
    """Read what identification recorded in a robot file, in its section `[identification]`.

    Parameters
    ----------
    robot_toml
        The file's path, or its text where it is a `str`.

    Returns
    -------
    RobotRecord
        Nothing known and no warnings where the section is missing.

    Raises
    ------
    telespring.InvalidInput
        Where the file is no robot file.
    OSError
        Where the file cannot be read.

    Examples
    --------
    >>> text = '''
    ... [robot]
    ... mass = 0.84
    ... damping = 7.7
    ... [identification]
    ... axes_independent = false
    ... warnings = ["Axes are not independent."]
    ... '''
    >>> robot_record(text)
    RobotRecord(independent=False, warnings=('Axes are not independent.',))
    """
    where, _, record = _robot_file(robot_toml)
    independent, warnings = record.get("axes_independent"), record.get("warnings", [])
    for key, value, right in (
        ("axes_independent", independent, independent is None or isinstance(independent, bool)),
        ("warnings", warnings, isinstance(warnings, list) and all(isinstance(w, str) for w in warnings)),
    ):
        if not right:
            raise InvalidInput(
                f"identification.{key}",
                repr(value)[:60],
                "true or false is needed" if key == "axes_independent" else "a list of texts is needed",
                f"Leave it as `telespring identify --out` wrote it. See [identification] in {where}.",
            )
    return RobotRecord(independent, tuple(warnings))


def _robot_file(robot_toml: str | Path) -> tuple[str, dict[str, Any], dict[str, Any]]:
    """Give the file's name, its section [robot], and [identification] or nothing."""
    where = str(robot_toml) if isinstance(robot_toml, Path) else "the robot's text"
    try:
        text = robot_toml.read_bytes().decode() if isinstance(robot_toml, Path) else robot_toml
        given = tomllib.loads(text)
    except UnicodeDecodeError:
        raise InvalidInput(
            where, "bytes", "a robot file is text in UTF-8", "Save it in that encoding."
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise InvalidInput(
            where,
            "text",
            f"a robot file is TOML text, and this is not: {error}",
            "Mend that line, or check that this is the robot file.",
        ) from None
    robot = given.pop("robot", None)
    record = given.pop("identification", {})
    if not isinstance(robot, dict) or given:
        raise InvalidInput(
            where,
            next((f"[{name}]" for name in given), "no section [robot]"),
            "a robot file has the section [robot], and [identification] as a record",
            "Give a whole study as the study itself."
            if given
            else "Write [robot] on a line of its own and mass and damping below.",
        )
    return where, robot, record if isinstance(record, dict) else {}


def _plain(field: str, value: object) -> Any:
    """Return the value as TOML can write it."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(f"{field}.{key}", each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(f"{field}[{i}]", each) for i, each in enumerate(value)]
    if isinstance(value, (bool, int, float, str)):
        return value
    raise InvalidInput(
        field,
        repr(value)[:60],
        "a study holds numbers, texts, booleans, and lists and tables of these",
        "Convert it to one of them.",
    )


def _read(tables: dict[str, Any]) -> Study:
    import tomli_w

    try:
        return Study.from_toml(tomli_w.dumps(tables))
    except InvalidInput as refused:
        # the line would be one of a text that nobody has seen
        remedy = re.sub(r" See line \d+\.$", "", refused.remedy)
        raise InvalidInput(refused.field, refused.value, refused.allowed, remedy) from None
