"""The study of the recommended choice, ready to be rehearsed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from telespring._core import Study
from telespring.comparison.choices import Candidate
from telespring.comparison.schedule import ComparisonSchedule

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["recommended_study"]


def recommended_study(schedule: ComparisonSchedule, comparison: xr.Dataset, candidate: Candidate) -> Study:
    """Return the study of a choice: its architecture and stiffness, on the network that was worst for it.

    The protocol is that of the comparison, with this stiffness only.
    """
    architecture = schedule.labels.index(candidate.architecture)
    one = comparison.isel(architecture=architecture)
    one = one.isel(condition=one["stiffness"].values == candidate.stiffness)
    network = int(one["tracking_error"].mean(("condition", "trial", "robot")).argmax("network"))
    cell = next(
        each for each in schedule.cells if (each.architecture, each.network) == (architecture, network)
    )
    delays = [delay for k, delay in cell.experiment.conditions if k == candidate.stiffness]
    conditions = [{"stiffness": candidate.stiffness, "delay": delay} for delay in delays]
    study = cell.study.replace(
        coupling={"stiffness": candidate.stiffness},
        protocol={"unconnected": None, "stiffness": None, "delay": None, "conditions": conditions},
    )
    # With one delay only, `telespring decide` need not be told it.
    return study if len(delays) > 1 else study.replace(network={"delay": delays[0]})
