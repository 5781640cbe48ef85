"""Every hypothesis fitted to the table, scored, and judged beside the null."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.closed_form import ClosedForm
from telespring.paper.calibration.comparison import Score, published_arrows, score
from telespring.paper.calibration.fit import Fit, Profile, Search
from telespring.paper.calibration.hypotheses import COMMON, NULL, Hypothesis
from telespring.paper.calibration.processes import Processes
from telespring.paper.calibration.setting import Setting
from telespring.paper.calibration.verdict import Criteria, Verdict, aicc, judge
from telespring.paper.published import PublishedRow

__all__ = ["Explanation", "explain", "explain_null", "rows_of_split"]

#: The stiffness, besides the unconnected mode, of the ten cells that fit the other 24 in the split.
_SPLIT_STIFFNESS = 142.0


@dataclass(frozen=True)
class Explanation:
    """A hypothesis, its best fit to the whole table, and how well it holds.

    Attributes
    ----------
    hypothesis
        None for the null.
    setting
        The best one, fitted to all cells; None for the null.
    values
        Of the free parameters, SI units.
    profiles
        Of its own parameters; of the common ones too unless it is excluded, for then they mean nothing.
    split_interval
        95 % profile interval of the own parameter, if there is one, from the ten cells of the split alone.
    errors
        In closed form at the best setting, (condition, robot), m; infinite where it is unstable.
    rms_all, rms_held_out, rms_leave_one_stiffness_out
        m: over all cells; over the 24 cells of 18, 36 and 71 N/m, fitted to the rest; over the 32 connected
        cells, each predicted from the other stiffnesses. Infinite where a condition is unstable.
    unstable_left_out
        Conditions that are unstable when their stiffness is left out, by number.
    aicc
        Of all cells.
    scores
        Over all cells of TE1, TE2 and both.
    arrows
        Arrow of every cell, as the published spread would give it.
    criteria
        What its verdict is made of; None for the null.
    """

    hypothesis: Hypothesis | None
    setting: Setting | None
    values: dict[str, float]
    profiles: dict[str, Profile]
    split_interval: Profile | None
    errors: FloatArray
    rms_all: float
    rms_held_out: float
    rms_leave_one_stiffness_out: float
    unstable_left_out: tuple[int, ...]
    aicc: float
    scores: dict[str, Score]
    arrows: tuple[tuple[str, str], ...]
    criteria: Criteria | None = None

    @property
    def name(self) -> str:
        """Name of the hypothesis."""
        return NULL if self.hypothesis is None else self.hypothesis.name

    @property
    def verdict(self) -> Verdict:
        """Supported, descriptive or excluded; the null is the reference."""
        return "reference" if self.criteria is None else self.criteria.verdict


def rows_of_split(table: Sequence[PublishedRow]) -> tuple[list[int], list[int]]:
    """Return the rows that the split fits, and those that it predicts."""
    fitted = [i for i, row in enumerate(table) if row.stiffness in (None, _SPLIT_STIFFNESS)]
    return fitted, [i for i in range(len(table)) if i not in fitted]


def explain_null(table: Sequence[PublishedRow]) -> Explanation:
    """Score the null, two numbers from the table: those of the unconnected mode, in every condition."""
    measured = np.array([row.mean for row in table])
    baseline = next(row for row in table if row.stiffness is None)
    errors = np.tile(baseline.mean, (len(table), 1))
    connected = [i for i, row in enumerate(table) if row.stiffness is not None]
    _, held_out = rows_of_split(table)
    return _scored(
        Explanation(
            hypothesis=None,
            setting=None,
            values={},
            profiles={},
            split_interval=None,
            errors=errors,
            rms_all=_rms(errors, measured),
            rms_held_out=_rms(errors[held_out], measured[held_out]),
            rms_leave_one_stiffness_out=_rms(errors[connected], measured[connected]),
            unstable_left_out=(),
            aicc=_aicc_of(errors, measured, 2),
            scores={},
            arrows=(),
        ),
        table,
    )


def explain(
    form: ClosedForm,
    printed: Setting,
    table: Sequence[PublishedRow],
    hypotheses: Sequence[Hypothesis],
    progress: Callable[[str], None],
    processes: Processes,
) -> tuple[Explanation, ...]:
    """Fit, score and judge the hypotheses; the null comes first."""
    null = explain_null(table)
    tasks = [_Task(form, printed, tuple(table), hypothesis) for hypothesis in hypotheses]
    found: dict[str, Explanation] = {}
    if tasks:
        progress(tasks[0].hypothesis.name)
        ((first, split),) = processes.map(_explain_one, tasks[:1])
        found[first.name] = first
        # The others start from the first one's common parameters, too.
        known = (first.values, dict(zip(first.values, split.values.tolist(), strict=True)))
        tasks = [tasks[0], *(replace(task, known=known) for task in tasks[1:])]
        longest_first = sorted(tasks[1:], key=_Task.work, reverse=True)
        for task, (each, _) in zip(longest_first, processes.map(_explain_one, longest_first), strict=True):
            progress(task.hypothesis.name)
            found[each.name] = each
    explained = [found[task.hypothesis.name] for task in tasks]
    best = min((each.aicc for each in explained), default=math.inf)
    judged = [replace(each, criteria=_criteria(each, null, best)) for each in explained]
    kept = [i for i, each in enumerate(judged) if each.verdict != "excluded"]
    for i, common in zip(
        kept, processes.map(_profile_common, [(tasks[i], judged[i]) for i in kept]), strict=True
    ):
        judged[i] = replace(judged[i], profiles=judged[i].profiles | common)
    return null, *judged


@dataclass(frozen=True)
class _Task:
    """One hypothesis to fit to the table, and values of common parameters to start from besides."""

    form: ClosedForm
    printed: Setting
    table: tuple[PublishedRow, ...]
    hypothesis: Hypothesis
    known: tuple[Mapping[str, float], ...] = ()

    def work(self) -> tuple[bool, int]:
        """Return what orders the tasks by their work: equivalent gains are sought by iteration."""
        hypothesis = self.hypothesis
        return not hypothesis.setting(self.printed, hypothesis.high).is_linear, len(hypothesis.parameters)

    def search(self) -> Search:
        def model(values: FloatArray) -> FloatArray:
            return self.form.errors(*(self.hypothesis.setting(self.printed, point) for point in values))

        def model_near(values: FloatArray, moved: FloatArray) -> FloatArray:
            settings = [self.hypothesis.setting(self.printed, point) for point in moved]
            return self.form.errors_near(self.hypothesis.setting(self.printed, values), settings)

        return Search(self.hypothesis, model, np.array([row.mean for row in self.table]), model_near)


def _profile_common(given: tuple[_Task, Explanation]) -> dict[str, Profile]:
    task, explanation = given
    fit = Fit(np.array(list(explanation.values.values())), explanation.errors)
    return task.search().profiles(fit, range(len(task.table)), [parameter.name for parameter in COMMON])


def _explain_one(task: _Task) -> tuple[Explanation, Fit]:
    """Explain one hypothesis, and return its fit to the split."""
    search, printed, table, hypothesis = task.search(), task.printed, task.table, task.hypothesis
    starts = [hypothesis.values_at(printed, values) for values in task.known]
    measured = np.array([row.mean for row in table])
    everything = range(len(table))
    best = search.fit(everything, starts)
    fitted, held_out = rows_of_split(table)
    split = search.fit(fitted, [best.values, *starts])
    left_out, predicted = _leave_each_stiffness_out(search, table, best)
    names = [parameter.name for parameter in hypothesis.parameters]
    own = [parameter.name for parameter in hypothesis.own]
    stable = bool(np.isfinite(best.errors).all())
    explanation = _scored(
        Explanation(
            hypothesis=hypothesis,
            setting=hypothesis.setting(printed, best.values),
            values=dict(zip(names, best.values.tolist(), strict=True)),
            profiles=search.profiles(best, everything, own) if stable else {},
            split_interval=(
                search.profiles(split, fitted, own)[own[0]] if len(own) == 1 and stable else None
            ),
            errors=best.errors,
            rms_all=_rms(best.errors, measured),
            rms_held_out=_rms(split.errors[held_out], measured[held_out]),
            rms_leave_one_stiffness_out=_rms(predicted, measured[left_out]),
            unstable_left_out=tuple(
                row for row, errors in zip(left_out, predicted, strict=True) if not np.isfinite(errors).all()
            ),
            aicc=_aicc_of(best.errors, measured, len(names)),
            scores={},
            arrows=(),
        ),
        table,
    )
    return explanation, split


def _leave_each_stiffness_out(
    search: Search, table: Sequence[PublishedRow], best: Fit
) -> tuple[list[int], FloatArray]:
    """Predict the rows of each stiffness from a fit to all other rows."""
    rows: list[int] = []
    predicted = []
    for stiffness in dict.fromkeys(row.stiffness for row in table if row.stiffness is not None):
        out = [i for i, row in enumerate(table) if row.stiffness == stiffness]
        fit = search.fit([i for i in range(len(table)) if i not in out], [best.values], starts=1)
        rows += out
        predicted.append(fit.errors[out])
    return rows, np.concatenate(predicted)


def _scored(explanation: Explanation, table: Sequence[PublishedRow]) -> Explanation:
    measured = np.array([row.mean for row in table])
    errors = explanation.errors
    return replace(
        explanation,
        scores={
            "te1": score(errors[:, 0], measured[:, 0]),
            "te2": score(errors[:, 1], measured[:, 1]),
            "both": score(errors, measured),
        },
        arrows=published_arrows(errors, table),
    )


def _criteria(explanation: Explanation, null: Explanation, best_aicc: float) -> Criteria:
    assert explanation.hypothesis is not None
    own = [explanation.profiles.get(parameter.name) for parameter in explanation.hypothesis.own]
    return judge(
        aicc=explanation.aicc,
        null_aicc=null.aicc,
        best_aicc=best_aicc,
        left_out_error=explanation.rms_leave_one_stiffness_out,
        null_left_out_error=null.rms_leave_one_stiffness_out,
        determined=all(
            profile is not None and not profile.open_below and not profile.open_above for profile in own
        ),
    )


def _rms(errors: FloatArray, measured: FloatArray) -> float:
    return float(np.sqrt(np.mean((errors - measured) ** 2)))


def _aicc_of(errors: FloatArray, measured: FloatArray, parameters: int) -> float:
    return aicc(1e6 * float(np.sum((errors - measured) ** 2)), measured.size, parameters)
