"""What was identified as a robot file: read by studies and by `telespring decide --robot1 FILE`."""

from __future__ import annotations

import os
from pathlib import Path

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.identification.estimation import Identification

__all__ = ["robot_toml", "write_robot"]


def robot_toml(found: Identification, name: str, *, source: str = "") -> str:
    """Give the text of a robot file.

    Its section `[robot]` has the keys of `[robot1]` in a study, standard deviations included; the section
    `[identification]` is a record of how they were found.

    Parameters
    ----------
    found
        What was identified.
    name
        The robot's name.
    source
        The log's name, for the record.

    Returns
    -------
    str
        TOML text.

    Raises
    ------
    telespring.InvalidInput
        Where a mass or a damping is not that of a robot: not above 0 (the damping: below 0).
    """
    import tomli_w

    for axis in found.axes:
        if axis.mass.value < 1e-4 or axis.damping.value < 0.0:
            wrong, value, unit = (
                ("mass", axis.mass.value, "kg")
                if axis.mass.value < 1e-4
                else ("damping", axis.damping.value, "N·s/m")
            )
            if axis.estimates[wrong].interval[1] > 0.0:
                low, high = axis.estimates[wrong].interval
                raise InvalidInput(
                    f"{wrong} ({axis.axis})",
                    f"{value:.4g} {unit}, 95 % interval {low:.4g} to {high:.4g}",
                    "a value above 0 is needed, and this log leaves its sign open",
                    "Move this axis further and faster, or record longer.",
                )
            raise InvalidInput(
                f"{wrong} ({axis.axis})",
                f"{value:.4g} {unit}",
                f"a robot's {wrong} is not negative",
                "Check sign and unit of the force (--force-scale), and that position and force are of the "
                "same axis.",
            )
    # The paper's intervals mean nothing, so neither does a standard deviation taken from them.
    certain = found.method == "paper"
    robot: dict[str, object] = {
        "name": name,
        "axes": [axis.axis for axis in found.axes],
        "mass": [axis.mass.value for axis in found.axes],
        "damping": [axis.damping.value for axis in found.axes],
    }
    if found.axes[0].coulomb is not None:
        robot["coulomb"] = [max(0.0, axis.coulomb.value) for axis in found.axes if axis.coulomb is not None]
    if not certain:
        robot["mass_sd"] = [axis.mass.standard_error for axis in found.axes]
        robot["damping_sd"] = [axis.damping.standard_error for axis in found.axes]
        robot["mass_damping_correlation"] = [axis.correlation for axis in found.axes]
    record = {key: value for key, value in found.to_json().items() if value is not None and key != "axes"}
    record["cross_inertias"] = [
        {key: value for key, value in cross.items() if value is not None}
        for cross in record["cross_inertias"]
    ]
    record["condition_number"] = [axis.condition_number for axis in found.axes]
    record["r_squared"] = [axis.r_squared for axis in found.axes]
    if source:
        record["log"] = source
    return tomli_w.dumps({"robot": robot, "identification": record})


def write_robot(
    found: Identification, path: str | os.PathLike[str], name: str | None = None, *, source: str = ""
) -> Path:
    """Write a robot file, whole or not at all.

    Parameters
    ----------
    found
        What was identified.
    path
        Where the file shall stand.
    name
        The robot's name; the file's unless given.
    source
        The log's name, for the record.

    Returns
    -------
    pathlib.Path
        The path written.

    Raises
    ------
    telespring.InvalidInput
        Where what was identified is no robot.
    OSError
        Where the file cannot be written.
    """
    return write_whole(path, robot_toml(found, name or Path(path).stem, source=source))
