"""Column names and units of recorded trials, as docs/recorded-trials.md lists them."""

from __future__ import annotations

AXES = ("x", "y")

#: Name of the file that lists the trials of a folder.
INDEX = "trials.csv"
INDEX_REQUIRED = ("file", "stiffness_N_per_m", "delay_s", "trial")
INDEX_OPTIONAL = ("status", "ended_at_s", "seed", "discard_s", "dyad", "participant")
#: Columns that say whose trials are dependent; a list has one of them at most.
DYAD_COLUMNS = ("dyad", "participant")
#: How a trial may end.
STATUSES = ("completed", "stopped", "diverged", "out of reach", "too stiff", "aborted", "failed")
#: Name of an optional study file in the folder of the list.
STUDY = "study.toml"

TIME = "time_s"
TARGET = tuple(f"target_{axis}_m" for axis in AXES)

#: Quantities of both robots with the unit suffix of their columns; the first is required.
QUANTITIES = {"position": "m", "velocity": "m_per_s", "coupling_force": "N", "agent_force": "N"}

#: SI units in the notation of xarray attributes, by unit suffix.
SI = {"m": "m", "m_per_s": "m/s", "N": "N", "s": "s"}


def recorded_columns(quantity: str) -> tuple[str, ...]:
    """Name the four columns of a quantity in a recorded trial: robot 1 on x and y, then robot 2.

    Examples
    --------
    >>> recorded_columns("position")[:2]
    ('position_robot1_x_m', 'position_robot1_y_m')
    """
    unit = QUANTITIES[quantity]
    return tuple(f"{quantity}_robot{robot}_{axis}_{unit}" for robot in (1, 2) for axis in AXES)
