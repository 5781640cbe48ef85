"""Names and units of the columns in which trials are recorded, as docs/recorded-trials.md has them."""

from __future__ import annotations

__all__ = ["AXES", "INDEX", "INDEX_OPTIONAL", "INDEX_REQUIRED", "QUANTITIES", "TARGET", "TIME", "columns_of"]

AXES = ("x", "y")

#: Name of the file that lists the trials of a folder.
INDEX = "trials.csv"
INDEX_REQUIRED = ("file", "stiffness_N_per_m", "delay_s", "trial")
INDEX_OPTIONAL = ("status", "ended_at_s", "seed", "discard_s")
#: How a trial may have ended.
STATUSES = ("completed", "stopped", "diverged", "out of reach", "aborted", "failed")

TIME = "time_s"
TARGET = tuple(f"target_{axis}_m" for axis in AXES)

#: Quantities of both robots and the units at the end of their columns; the first is always needed.
QUANTITIES = {
    "position": "m",
    "velocity": "m_per_s",
    "coupling_force": "N",
    "agent_force": "N",
}

#: SI units as xarray's readers know them.
SI = {"m": "m", "m_per_s": "m/s", "N": "N", "s": "s"}


def columns_of(quantity: str) -> tuple[str, ...]:
    """Name a quantity's four columns, robot 1 on x and y before robot 2.

    Examples
    --------
    >>> columns_of("position")[:2]
    ('position_robot1_x_m', 'position_robot1_y_m')
    """
    unit = QUANTITIES[quantity]
    return tuple(f"{quantity}_robot{robot}_{axis}_{unit}" for robot in (1, 2) for axis in AXES)
