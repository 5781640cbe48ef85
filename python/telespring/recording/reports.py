"""What the coupling of each side reports of a stretch of time, as a rehearsal does of a trial."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from telespring._types import FloatArray

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SIDE_REPORTS", "SideReport"]


@dataclass(frozen=True)
class SideReport:
    """A number of each robot's side over a stretch of time.

    Attributes
    ----------
    name, units, long_name
        Of the variable in the dataset; as in a rehearsal's.
    compute
        From the session's dataset and a stretch of its samples: one number for each robot, NaN where not
        known.
    """

    name: str
    units: str
    long_name: str
    compute: Callable[[xr.Dataset, slice], FloatArray]


def _values(session: xr.Dataset, name: str, span: slice) -> FloatArray:
    return np.asarray(session[name][span], dtype=np.float64)


def _by_robot(values: FloatArray, reduce: Callable[[FloatArray], float]) -> FloatArray:
    """Reduce the known values of each robot, (time, robot)."""
    return np.array(
        [reduce(known) if (known := column[np.isfinite(column)]).size else np.nan for column in values.T]
    )


def _reduced(name: str, reduce: Callable[[FloatArray], float]) -> Callable[[xr.Dataset, slice], FloatArray]:
    return lambda session, span: _by_robot(_values(session, name, span), reduce)


def _grown(name: str) -> Callable[[xr.Dataset, slice], FloatArray]:
    """By how much a running total grew."""
    return _reduced(name, lambda known: float(known[-1] - known[0]))


def _limited_share(session: xr.Dataset, span: slice) -> FloatArray:
    has_partner = np.isfinite(_values(session, "age", span))
    return _by_robot(
        np.where(has_partner, _values(session, "is_limited", span), np.nan), lambda known: float(known.mean())
    )


def _held_share(session: xr.Dataset, span: slice) -> FloatArray:
    held = _grown("held_ticks")(session, span)
    known = np.isfinite(_values(session, "held_ticks", span))
    period = float(session.attrs["sample_period"])
    time = np.asarray(session["time"][span])
    ticks = [float(np.ptp(time[each])) / period if each.any() else 0.0 for each in known.T]
    return np.array([h / t if t > 0.0 else np.nan for h, t in zip(held, ticks, strict=True)])


SIDE_REPORTS = (
    SideReport(
        "limited_share",
        "1",
        "share of the ticks at which the strategy changed the force of the spring",
        _limited_share,
    ),
    SideReport(
        "given_out",
        "J",
        "energy that the coupling gave out to the handle, as the side measured it",
        _grown("energy_given_out"),
    ),
    SideReport(
        "energy_sent", "J", "energy that the side's strategy sent to its partner", _grown("total_energy_sent")
    ),
    SideReport("age_mean", "s", "mean age of the partner's motion in use", _reduced("age", np.mean)),
    SideReport("age_low", "s", "smallest age of a partner's sample in use", _reduced("age", np.min)),
    SideReport("age_high", "s", "largest age of a partner's sample in use", _reduced("age", np.max)),
    SideReport("held_share", "1", "share of the ticks at which an old motion was held", _held_share),
    SideReport("lost", "1", "packets that had not come although later ones had", _grown("packets_lost")),
)
