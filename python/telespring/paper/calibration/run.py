"""The whole calibration: hypotheses in closed form, the supported ones confirmed in the laboratory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray
from telespring.model import Study
from telespring.paper.calibration.closed_form import ClosedForm
from telespring.paper.calibration.comparison import Prediction, predict
from telespring.paper.calibration.explain import Explanation, explain
from telespring.paper.calibration.hypotheses import HYPOTHESES, Hypothesis
from telespring.paper.calibration.laboratory import RigSimulator, printed_laboratory, printed_setting
from telespring.paper.calibration.processes import Processes
from telespring.paper.published import TABLE_I, TRIALS, PublishedRow

__all__ = ["Calibration", "Confirmation", "calibrate"]

#: A cell counts as unexplained if every supported hypothesis misses it to the same side by more than this
#: many standard errors of its published mean, and by more than this length, m. The published spread is
#: partly as small as 0.3 mm, and no model of constant masses and dampings can be asked for tenths of a
#: millimetre.
_STANDARD_ERRORS = 3.0
_LEAST_MISS = 1e-3


@dataclass(frozen=True)
class Confirmation:
    """A hypothesis's best setting, run in the virtual laboratory.

    Attributes
    ----------
    name
        Of the hypothesis.
    prediction
        Means, deviations and arrows of its trials.
    rms_all
        m, over all cells against the published means; NaN if no trial of a condition was completed.
    largest_difference
        m, of a mean from the closed form.
    """

    name: str
    prediction: Prediction
    rms_all: float
    largest_difference: float


@dataclass(frozen=True)
class Calibration:
    """What explains the published table.

    Attributes
    ----------
    published
        Its rows.
    explanations
        The null, then every hypothesis.
    confirmations
        The supported hypotheses that the laboratory can run.
    trials
        Of each condition there.
    """

    published: tuple[PublishedRow, ...]
    explanations: tuple[Explanation, ...]
    confirmations: tuple[Confirmation, ...]
    trials: int

    def __getitem__(self, name: str) -> Explanation:
        """Return the explanation of this name."""
        return next(each for each in self.explanations if each.name == name)

    @property
    def supported(self) -> tuple[Explanation, ...]:
        """The supported hypotheses, the smallest AICc first."""
        found = [each for each in self.explanations if each.verdict == "supported"]
        return tuple(sorted(found, key=lambda each: each.aicc))

    @property
    def unexplained(self) -> tuple[tuple[int, int], ...]:
        """Cells (condition, robot) that every supported hypothesis misses to the same side."""
        if not self.supported:
            return ()
        measured = np.array([row.mean for row in self.published])
        error = np.array([row.standard_deviation for row in self.published]) / np.sqrt(TRIALS)
        miss = np.array([each.errors - measured for each in self.supported])
        least = np.maximum(_STANDARD_ERRORS * error, _LEAST_MISS)
        missed = np.all(miss > least, axis=0) | np.all(miss < -least, axis=0)
        return tuple((int(i), int(robot)) for i, robot in np.argwhere(missed))


def calibrate(
    study: Study,
    published: Sequence[PublishedRow] = TABLE_I,
    *,
    hypotheses: Sequence[Hypothesis] = HYPOTHESES,
    trials: int = TRIALS,
    progress: Callable[[str], None] | None = None,
    processes: Processes | None = None,
) -> Calibration:
    """Fit every hypothesis to the table, judge it, and run the supported ones in the laboratory.

    Parameters
    ----------
    study
        Robots, task and protocol. The agents and the laboratory are the paper's, the conditions those of
        `published`.
    published
        Means and standard deviations of the tracking errors.
    hypotheses
        What to fit besides the null.
    trials
        Trials of each condition in the laboratory; 0 leaves it out.
    progress
        Called with the name of each hypothesis as it is fitted, and before the laboratory runs.
    processes
        Where the fits are computed; by default on all processors.

    Returns
    -------
    Calibration
        The same input gives the same output.

    Raises
    ------
    telespring.InvalidInput
        If the study has not two axes, the figure of eight and the paper's kinds of agents.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.paper.calibration import HYPOTHESES, calibrate
    >>> stiffer = [each for each in HYPOTHESES if each.name == "agent stiffness"]
    >>> found = calibrate(ts.Study.paper(), hypotheses=stiffer, trials=0)["agent stiffness"]
    >>> round(found.values["agent_stiffness"]), round(1e3 * found.rms_all, 1), found.verdict
    (231, 0.8, 'supported')
    """
    report = progress if progress is not None else lambda _: None
    table = tuple(published)
    laboratory = printed_laboratory(study)
    conditions = [(row.stiffness, row.delay) for row in table]
    with processes if processes is not None else Processes() as used:
        explanations = explain(
            ClosedForm(laboratory, conditions), printed_setting(laboratory), table, hypotheses, report, used
        )
    found = Calibration(table, explanations, (), trials)
    if trials == 0:
        return found
    report("laboratory")
    rig = RigSimulator(laboratory)
    confirmations = []
    for each in found.supported:
        if each.setting is not None and rig.can_run(each.setting):
            errors = rig.errors(each.setting, conditions, trials)
            confirmations.append(_confirmation(each, errors, table))
    return Calibration(table, explanations, tuple(confirmations), trials)


def _confirmation(
    explanation: Explanation, errors: FloatArray, table: Sequence[PublishedRow]
) -> Confirmation:
    prediction = predict(errors, table)
    measured = np.array([row.mean for row in table])
    return Confirmation(
        name=explanation.name,
        prediction=prediction,
        rms_all=float(np.sqrt(np.mean((prediction.mean - measured) ** 2))),
        largest_difference=float(np.max(np.abs(prediction.mean - explanation.errors))),
    )
