"""A live session as one or both sites recorded it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from telespring._arrays import quoted_value
from telespring._core import Study
from telespring._errors import InvalidInput
from telespring._quantities import format_count, format_time
from telespring.recording.common_time import CommonTime, common_time
from telespring.recording.dataset import session_dataset, session_grid
from telespring.recording.events import MarkedTrial, SessionEvent, marked_trials
from telespring.recording.series import SiteSeries
from telespring.recording.side import SideRecording
from telespring.recording.trials import coupled_span, trials_dataset

if TYPE_CHECKING:
    import xarray as xr

    from telespring.recording.xdf_clock import XdfStream

__all__ = ["SessionRecording"]

#: The event of a marker, whose cause is its kind and its text.
_MARK = "mark"
_MOST_EVENTS = 100_000


class SessionRecording:
    """The recording of a live session.

    Attributes
    ----------
    sides : dict of int to SideRecording
        What each site recorded, by its robot: one, or both.
    status : str
        "complete", or "truncated" if the end of a file is missing or a part of it cannot be read.
    whole_until : float
        Time of the last tick that every site has, s since the beginning of the recording.
    missed : int
        Items that the recorders counted as missed, and ticks that are not in the files.
    clock : CommonTime or None
        How the clocks of both sites compare; None with one site, and where no site knew the other's clock.
    streams : dict of int to XdfStream
        Of an XDF file, by robot: its streams and their clock offsets, as they were measured. Empty otherwise.
    """

    def __init__(
        self,
        sides: Mapping[int, SideRecording],
        *,
        clock: CommonTime | None = None,
        streams: Mapping[int, XdfStream] | None = None,
    ) -> None:
        given: object = sides
        known = [*given.values()] if isinstance(given, Mapping) and given and {*given} <= {1, 2} else [None]
        if not all(isinstance(side, SideRecording) for side in known):
            raise InvalidInput(
                "sides",
                quoted_value(sides),
                "what each site recorded, by the number of its robot",
                "Read a file with telespring.read_recording.",
            )
        self.sides = dict(sorted(sides.items()))
        self.streams = dict(streams or {})
        self._given_clock = clock

    def __repr__(self) -> str:
        sites = " and ".join(str(side) for side in self.sides)
        noun = "site" if len(self.sides) == 1 else "sites"
        return f"<SessionRecording of {noun} {sites}: {self.status}, {format_time(self.duration, 3)}>"

    @property
    def first(self) -> SideRecording:
        """The site whose clock is the common one: that of robot 1 if it was recorded."""
        return next(iter(self.sides.values()))

    @property
    def status(self) -> Literal["complete", "truncated"]:
        """See the class."""
        is_complete = all(side.status == "complete" for side in self.sides.values())
        return "complete" if is_complete else "truncated"

    @property
    def missed(self) -> int:
        """See the class."""
        return sum(side.missed + side.missing_ticks for side in self.sides.values())

    @cached_property
    def clock(self) -> CommonTime | None:
        """See the class."""
        if len(self.sides) < 2:
            return None
        if self._given_clock is not None:
            return self._given_clock
        return common_time(*(side.clock_estimates() for side in self.sides.values()))

    @property
    def sample_period(self) -> float:
        """The time between two ticks, s."""
        return self.first.sample_period

    @cached_property
    def study(self) -> Study | None:
        """The study of the session; None if it is not in the recording, or this version cannot read it."""
        text = next((side.study for side in self.sides.values() if side.study), "")
        try:
            return Study.from_toml(text) if text else None
        except InvalidInput:
            return None

    def common_times(self, side: int, time: NDArray[Any]) -> NDArray[np.int64]:
        """Convert times of a site's clock (ns) to the common clock (ns): that of the first site."""
        whole = np.asarray(time).astype(np.int64)
        if self.sides[side] is self.first:
            return whole
        if self.clock is None:
            raise InvalidInput(
                "clock_offset",
                "unknown at both sites",
                "to put two sites on one time base, one of them must have heard an answer of the other",
                "Look at each recording alone: the sites never were in contact.",
            )
        return self.clock.to_first(whole)

    @cached_property
    def _site_series(self) -> list[SiteSeries]:
        return [side.series(self.common_times(number, side.time)) for number, side in self.sides.items()]

    @cached_property
    def begin(self) -> int:
        """The beginning of the recording: its first tick, ns on the common clock."""
        return min(int(site.time[0]) for site in self._site_series)

    @property
    def duration(self) -> float:
        """From the first tick to the last one of any site, s."""
        return (max(int(site.time[-1]) for site in self._site_series) - self.begin) * 1e-9

    @property
    def whole_until(self) -> float:
        """See the class."""
        return (min(int(site.time[-1]) for site in self._site_series) - self.begin) * 1e-9

    def seconds(self, side: int, time: NDArray[Any]) -> NDArray[np.float64]:
        """Convert times of a site's clock (ns) to s since the beginning of the recording."""
        return np.asarray((self.common_times(side, time) - self.begin) * 1e-9)

    @cached_property
    def events(self) -> tuple[SessionEvent, ...]:
        """What happened at the sites, in the order of time."""
        found: list[SessionEvent] = []
        for number, side in self.sides.items():
            columns = side.events.columns
            time = self.seconds(number, columns["time"])[:_MOST_EVENTS]
            causes = columns.get("cause", np.full(len(time), "", dtype=object))
            found += [
                SessionEvent(float(when), number, str(event), str(cause))
                for when, event, cause in zip(time, columns["event"], causes, strict=False)
            ]
        return tuple(sorted(found, key=lambda event: event.time))

    def dataset(self, rate: float | None = None) -> xr.Dataset:
        """Return the session as a dataset over time, robot and axis.

        Quantities that a rehearsal has, too, have its names, units and dimensions, without `condition` and
        `trial`. What no site recorded is NaN. Of the robot of a site whose file is missing, position and
        velocity are those that the partner's packets told; `source` says so.

        Parameters
        ----------
        rate : float, optional
            Samples per second. Default: one per sample period. Positions and velocities are interpolated
            between ticks, forces and all else are held.

        Returns
        -------
        xarray.Dataset
            The signals, and what happened over `event`. Attributes: `status`, `whole_until` (s), `missed`,
            and with both sites `clock_uncertainty` (s), the largest error of their common time
            (of an XDF file how much its clock offsets scatter, which is no bound).
        """
        period = self.sample_period
        if rate is not None:
            if not 0.0 < rate <= 1.0 / period * (1.0 + 1e-9):
                raise InvalidInput(
                    "rate",
                    f"{rate:g}",
                    f"up to {1.0 / period:g} samples per second are required: so many were recorded",
                    "Leave it out to have all of them.",
                )
            grid = session_grid(self._site_series, 1.0 / rate)
        else:
            grid = session_grid(self._site_series, period)
        return self._dataset(grid, period)

    def _dataset(self, grid: NDArray[np.int64], period: float) -> xr.Dataset:
        sites = list(self._site_series)
        source = ["unknown", "unknown"]
        for site in sites:
            source[site.side - 1] = "recorded"
        if len(sites) == 1:
            partner = self.first.partner_series(lambda time: time)
            if partner is not None and len(partner.time):
                sites.append(partner)
                source[partner.side - 1] = "received"
        attributes: dict[str, Any] = {
            "schema": "telespring session 1",
            "status": self.status,
            "whole_until": self.whole_until,
            "missed": self.missed,
            "sample_period": period,
        }
        if self.clock is not None:
            attributes |= {
                "clock_uncertainty": self.clock.uncertainty,
                "clock_drift": self.clock.drift,
                "clock_disagreement": self.clock.disagreement * 1e-9,
            }
        dataset = session_dataset(sites, grid, period, self.events, attributes)
        dataset["source"] = (
            "robot",
            np.array(source, dtype=object),
            {"long_name": "whether a robot's own site recorded it, or its motion was received from it"},
        )
        return dataset

    def marks(self) -> list[tuple[float, int, str, str]]:
        """Return the markers: time (s), side, kind (trial, condition, participant, note) and text."""
        found = []
        for event in self.events:
            if event.event == _MARK:
                kind, _, text = event.cause.partition(" ")
                found.append((event.time, event.side, kind, text.strip()))
        return found

    def marked_trials(self, dataset: xr.Dataset | None = None) -> list[MarkedTrial]:
        """Return the trials that the markers name; without any, all the time in which the spring acted."""
        span = coupled_span(self.dataset() if dataset is None else dataset)
        return [] if span is None else marked_trials(self.marks(), *span)

    def trials(self, rate: float | None = None) -> xr.Dataset:
        """Return the trials of the session in the layout of a rehearsal's, to be measured like them.

        Over condition, trial, time, robot and axis. Markers of trials, conditions and participants split the
        session; without them it is one trial. A trial in which the spring ceased to act has the status
        "stopped".

        Parameters
        ----------
        rate : float, optional
            Samples per second, as of `dataset`.

        Returns
        -------
        xarray.Dataset
            The trials. InvalidInput if the spring never acted.
        """
        session = self.dataset(rate)
        trials = self.marked_trials(session)
        if not trials:
            raise InvalidInput(
                "phase",
                f"never running in {format_count(len(session['time']), 'sample')}",
                "a session whose spring acted is required",
                "Look at its events: they say why the sides did not come together.",
            )
        return trials_dataset(session, trials)
