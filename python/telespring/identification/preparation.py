"""A recording made ready for its fits: checked, cut at gaps, evenly sampled, without glitches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from telespring._errors import InvalidInput
from telespring._quantities import format_number
from telespring._types import FloatArray
from telespring.identification import diagnostics
from telespring.identification.assembly import identification_of
from telespring.identification.cutoff import CUTOFF_RULE, choose_cutoff, noise_deviation
from telespring.identification.glitches import without_glitches
from telespring.identification.log_checks import check_log
from telespring.identification.log_fit import FitOptions, LogFit, fit_log
from telespring.identification.origin import Origin, refusals_in
from telespring.identification.recordings import Recording
from telespring.identification.resampling import even_stretches
from telespring.identification.results import Identification
from telespring.identification.stretches import Stretch
from telespring.identification.terms import AxisTerms
from telespring.identification.unmodelled import estimate_inertias
from telespring.identification.warning_messages import Diagnostic

__all__ = ["PreparedLog"]

#: An axis must travel at least so far, m, and so many times the standard deviation of its noise.
_MINIMUM_TRAVEL, _TRAVEL_PER_NOISE = 1e-3, 50.0


class PreparedLog:
    """One recording, ready to be fitted with any terms.

    InvalidInput, with the name of its file, where it cannot be used.
    """

    def __init__(self, recording: Recording, cutoff: float | None) -> None:
        self.origin = recording.origin
        self.names = list(recording.origin.axes)
        self.name = recording.name
        with refusals_in(self.origin):
            pieces, found = check_log(recording.time, recording.position, recording.force, self.origin)
            stretches, jitter = even_stretches(pieces)
            self.stretches, glitches = without_glitches(stretches, self.origin)
            self.warnings: list[Diagnostic] = [*recording.warnings, *found, *jitter, *glitches]
            self.samples = sum(stretch.time.size for stretch in self.stretches)
            longest = self.longest
            for i, row in enumerate(longest.position):
                _refuse_short_travel(self.origin, i, row, longest.rate)
        self.cutoff = choose_cutoff(longest.position, longest.rate) if cutoff is None else float(cutoff)
        self.cutoff_rule = CUTOFF_RULE if cutoff is None else "as given"

    @property
    def longest(self) -> Stretch:
        """The stretch from which the cut-off is chosen."""
        return max(self.stretches, key=lambda stretch: stretch.time.size)

    def fit(self, options: FitOptions, terms: Sequence[AxisTerms] | None = None) -> LogFit:
        """Fit the terms that are given, or those that the log needs."""
        with refusals_in(self.origin):
            return fit_log(self.stretches, self.cutoff, self.names, options, terms)

    def identify(self, options: FitOptions, terms: Sequence[AxisTerms] | None = None) -> Identification:
        """Estimate the robot, and check the result."""
        fit = self.fit(options, terms)
        inertias = estimate_inertias(fit)
        coupled = [
            tuple(other for other, inertia in each.items() if inertia.matters and not inertia.may_be_lag)
            for each in inertias
        ]
        if any(coupled) and options.method != "paper":
            # What the axes do to each other is neither mass nor lag of their own.
            together = [replace(axis, coupled=rows) for axis, rows in zip(fit.terms, coupled, strict=True)]
            fit = self.fit(options, together)
            # And once more with the lag that the coupled axes have.
            inertias = estimate_inertias(fit)
        found = identification_of(
            fit,
            self.names,
            inertias,
            cutoff_rule=self.cutoff_rule,
            rate=self.longest.rate,
            samples=self.samples,
        )
        with refusals_in(self.origin):
            doubts = diagnostics.check_fit(found, fit, self.stretches, self.names)
        return replace(found, diagnostics=(*self.warnings, *doubts))


def _refuse_short_travel(origin: Origin, axis: int, position: FloatArray, rate: float) -> None:
    travel = float(np.ptp(position))
    levels = np.unique(position).size
    if travel == 0.0 or levels < 50:
        raise InvalidInput(
            origin.column("position", axis),
            f"{levels} different values over {format_number(travel, 3, shift=3)} mm",
            "a position that moves through at least 50 steps of its sensor is required",
            "Move the robot further, or check that this is the right column and the sensor is connected.",
        )
    noise = noise_deviation(position, rate)
    if travel < max(_MINIMUM_TRAVEL, _TRAVEL_PER_NOISE * noise):
        raise InvalidInput(
            origin.column("position", axis),
            f"{format_number(travel, 3, shift=3)} mm of travel, "
            f"{format_number(noise, 2, shift=3)} mm of noise",
            f"this axis moves too little: at least {1e3 * _MINIMUM_TRAVEL:g} mm and {_TRAVEL_PER_NOISE:g} "
            "times the noise are required",
            "Move it further, name only the axes that move, or check the unit (--position-scale).",
        )
