"""Functions that `Study.replace` and `Study.with_robot` have taken over; kept for one release."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from telespring.model import Study
from telespring.study.robot_file import RobotRecord, robot_record

__all__ = ["RobotRecord", "robot_record", "with_robot", "with_values"]


def with_values(study: Study, values: Mapping[str, Mapping[str, object] | str]) -> Study:
    """Replace values of a study, as `Study.replace` does.

    Examples
    --------
    >>> import telespring as ts
    >>> with_values(ts.Study.paper(), {"coupling": {"stiffness": 140.0}}).stiffness
    140.0
    """
    return study.replace(**values)


def with_robot(study: Study, side: int, robot_toml: str | Path) -> Study:
    """Replace a robot of a study by that of a robot file, as `Study.with_robot` does."""
    return study.with_robot(side, robot_toml)
