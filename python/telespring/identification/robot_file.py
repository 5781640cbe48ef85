"""The robot file of an identification, read by studies and by `telespring decide --robot1 FILE`."""

from __future__ import annotations

import os
from pathlib import Path

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.identification.covariance import NORMAL_HALF_WIDTH
from telespring.identification.results import Identification
from telespring.identification.warning_messages import UNITS

__all__ = ["robot_toml", "write_robot"]

#: A study's range of masses begins here, kg.
_SMALLEST_MASS = 1e-4


def robot_toml(identification: Identification, name: str, *, source: str = "") -> str:
    """Return the text of a robot file.

    Its section `[robot]` has the keys of `[robot1]` in a study, standard deviations included; the section
    `[identification]` records how they were estimated.

    Parameters
    ----------
    identification
        The identified robot.
    name
        The robot's name.
    source
        Name of the log, for the record.

    Returns
    -------
    str
        TOML text.

    Raises
    ------
    telespring.InvalidInput
        If a mass is not positive, a damping is negative, or a spring pushes the robot away.
    """
    import tomli_w

    axes = identification.axes
    _refuse_impossible_robot(identification)
    robot: dict[str, object] = {
        "name": name,
        "axes": [axis.axis for axis in axes],
        "mass": [axis.mass.value for axis in axes],
        "damping": [axis.damping.value for axis in axes],
    }
    if any(axis.is_present("coulomb") for axis in axes):
        # Friction that the log does not show, or that would drive the robot, is none; a warning tells of it.
        robot["coulomb"] = [
            max(0.0, axis.estimates["coulomb"].value) if axis.is_present("coulomb") else 0.0 for axis in axes
        ]
    # The intervals of the paper's method are not valid, and neither are standard deviations from them.
    if identification.method != "paper":
        # `decide` draws from a normal distribution: with these, 95 % of its draws lie in the intervals.
        robot["mass_sd"] = [axis.half_width("mass") / NORMAL_HALF_WIDTH for axis in axes]
        robot["damping_sd"] = [axis.half_width("damping") / NORMAL_HALF_WIDTH for axis in axes]
        robot["mass_damping_correlation"] = [axis.correlation for axis in axes]
    left_out = ("axes", "each_log")
    record = {
        key: value
        for key, value in identification.to_json().items()
        if value is not None and key not in left_out
    }
    record["cross_inertias"] = [
        {key: value for key, value in cross.items() if value is not None}
        for cross in record["cross_inertias"]
    ]
    found = {doubt.values["axis"] for doubt in identification.diagnostics if doubt.code == "spring"}
    # A spring of one log that all together do not confirm would be counted on without being there.
    springs = [axis.axis in found and axis.is_present("stiffness") for axis in axes]
    if any(springs):
        record["stiffness"] = [
            axis.estimates["stiffness"].value if is_there else 0.0
            for axis, is_there in zip(axes, springs, strict=True)
        ]
    record["condition_number"] = [axis.condition_number for axis in axes]
    record["r_squared"] = [axis.r_squared for axis in axes]
    if source:
        record["log"] = source
    return tomli_w.dumps({"robot": robot, "identification": record})


def write_robot(
    identification: Identification,
    path: str | os.PathLike[str],
    name: str | None = None,
    *,
    source: str = "",
) -> Path:
    """Write a robot file, completely or not at all.

    Parameters
    ----------
    identification
        The identified robot.
    path
        The file to write.
    name
        The robot's name; by default that of the file.
    source
        Name of the log, for the record.

    Returns
    -------
    pathlib.Path
        The path written.

    Raises
    ------
    telespring.InvalidInput
        If a mass is not positive or a damping is negative.
    OSError
        If the file cannot be written.
    """
    return write_whole(path, robot_toml(identification, name or Path(path).stem, source=source))


def _refuse_impossible_robot(identification: Identification) -> None:
    for doubt in identification.diagnostics:
        if doubt.code == "negative spring":
            raise InvalidInput(
                f"stiffness ({doubt.values['axis']})",
                f"{doubt.values['stiffness']:.4g} N/m",
                "a robot that a force pushes away from the middle of its movement has no verdict",
                "Remove the cause, for example with a counterweight or by levelling the robot, and log "
                "again.",
            )
    for axis in identification.axes:
        if axis.mass.value < _SMALLEST_MASS:
            parameter = "mass"
        elif axis.damping.value < 0.0:
            parameter = "damping"
        else:
            continue
        estimate, unit = axis.estimates[parameter], UNITS[parameter]
        low, high = estimate.interval
        if high > 0.0:
            raise InvalidInput(
                f"{parameter} ({axis.axis})",
                f"{estimate.value:.4g} {unit}, 95 % interval {low:.4g} to {high:.4g}",
                "a value above 0 is required, but this log does not determine its sign",
                "Move this axis further and faster, or record longer.",
            )
        raise InvalidInput(
            f"{parameter} ({axis.axis})",
            f"{estimate.value:.4g} {unit}",
            f"a robot's {parameter} is not negative",
            "Check sign and unit of the force (--force-scale), and that position and force belong to the "
            "same axis.",
        )
