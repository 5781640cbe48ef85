"""Paragraphs on a calibration, written from its numbers, and the questions that it leaves to the authors."""

from __future__ import annotations

import numpy as np

from telespring.paper.calibration import NULL, Calibration, Explanation
from telespring.paper.published import AGENT_STIFFNESS, TRIALS
from telespring.paper.sections.calibration.numbers import equivalent_gain
from telespring.show.quantities import format_error, format_number, format_quantity, format_signed

__all__ = ["calibration_statements"]

_QUESTIONS = (
    "Which force did an arm give at the handle, per displacement, when its agent commanded 120 N/m?",
    (
        "Which force did an H-MAN give for a known distance of the handles, in steady state and after a "
        "step, and is there a filter, a ramp, a dead band or a limit between the two?"
    ),
    "Do the masses and dampings of Table III include those of the arm through which they were identified?",
    "Is a delay of 84 ms one way or the round trip, and does it act on the partner's position alone?",
    "How long does a spot live, and from when in a trial is the tracking error taken?",
    (
        "What makes TE₁ spread by 2.7 mm in the unconnected mode, where the skilled agent has no "
        "disturbance, and may the trials be published?"
    ),
)


def calibration_statements(calibration: Calibration) -> tuple[list[str], list[str]]:
    """Return paragraphs on what was found and what stays unexplained, and what to ask."""
    paragraphs = (
        _supported_sentences(calibration),
        [*_printed_sentences(calibration), *_laboratory_sentences(calibration)],
        _unexplained_sentences(calibration),
    )
    return [" ".join(sentences) for sentences in paragraphs if sentences], list(_QUESTIONS)


def _supported_sentences(calibration: Calibration) -> list[str]:
    supported = calibration.supported
    if not supported:
        return ["The rules support no hypothesis."]
    named = " and ".join(f"{each.name}, {_own_values(each)}" for each in supported)
    sentences = [f"The rules support {named} (in brackets: 95 % profile intervals)."]
    if len(supported) > 1:
        difference = format_number(supported[-1].aicc - supported[0].aicc, 2)
        arms = "; ".join(
            f"with {each.name} {_text(each, 'arm_mass')} and {_text(each, 'arm_damping')}"
            for each in supported
        )
        sentences += [
            (
                f"Their AICc differs by only {difference}, and each predicts a stiffness that it has not "
                "seen: the table alone cannot tell them apart."
            ),
            f"They disagree on what an arm adds to Table III, which includes the arm where it is 0: {arms}.",
        ]
    stiffer = next((each for each in supported if "agent_stiffness" in each.values), None)
    return sentences + ([] if stiffer is None else _stiffness_sentences(calibration, stiffer))


def _stiffness_sentences(calibration: Calibration, stiffer: Explanation) -> list[str]:
    sentences = []
    gain, split = equivalent_gain(calibration), stiffer.split_interval
    if gain is not None:
        low, high = gain["interval"]
        sentences.append(
            "Scaling all masses, dampings and stiffnesses alike changes no motion. The fitted agents are "
            f"therefore also agents of the printed {AGENT_STIFFNESS:.0f} N/m with {gain['value']:.2f} "
            f"({low:.2f} to {high:.2f}) times the printed coupling, on as much lighter and less damped "
            "robots and arms."
        )
    if split is not None:
        low, high = (format_number(end, 3) for end in split.interval)
        sentences.append(
            "The unconnected mode and the conditions at 142 N/m alone leave the agents' stiffness between "
            f"{low} and {high} N/m."
        )
    return sentences


def _printed_sentences(calibration: Calibration) -> list[str]:
    printed = next((each for each in calibration.explanations if each.name == "printed values"), None)
    if printed is None:
        return []
    null = calibration[NULL]
    sentence = (
        f"With every printed value kept, the unprinted ones fit to {format_error(printed.rms_all)}, "
        f"{'more' if printed.rms_all > null.rms_all else 'less'} than the {format_error(null.rms_all)} of "
        "saying that nothing changes from the unconnected mode"
    )
    if printed.unstable_left_out:
        labels = ", ".join(calibration.published[i].label for i in printed.unstable_left_out)
        sentence += f"; fitted to the other stiffnesses, {labels} would be unstable"
    return [sentence + "."]


def _laboratory_sentences(calibration: Calibration) -> list[str]:
    found = calibration.confirmations
    if not found:
        return []
    errors = " and ".join(f"{format_error(each.rms_all)} ({each.name})" for each in found)
    farthest = format_error(max(each.largest_difference for each in found))
    return [
        (
            f"In the virtual laboratory, with {calibration.trials} trials of every condition, the error over "
            f"all 34 cells is {errors}; no mean is farther than {farthest} from the closed form."
        )
    ]


def _unexplained_sentences(calibration: Calibration) -> list[str]:
    table, supported = calibration.published, calibration.supported
    if not supported:
        return []
    misses = [
        1e3 * (each.errors - np.array([row.mean for row in calibration.published])) for each in supported
    ]
    sentences = []
    if calibration.unexplained:
        cells = " and ".join(
            f"TE{'₁₂'[robot]} in {table[i].label} "
            f"({', '.join(format_signed(float(miss[i, robot]), 1) for miss in misses)} mm)"
            for i, robot in calibration.unexplained
        )
        sentences.append(
            f"Every supported hypothesis misses {cells}, to the same side and by more than three standard "
            "errors."
        )
    for each, miss in zip(supported, misses, strict=True):
        place = np.unravel_index(int(np.argmax(np.abs(miss))), miss.shape)
        i, robot = int(place[0]), int(place[1])
        error = 1e3 * table[i].standard_deviation[robot] / TRIALS**0.5
        sentences.append(
            f"Largest miss with {each.name}: TE{'₁₂'[robot]} in {table[i].label}, "
            f"{format_signed(float(miss[i, robot]), 1)} mm, where the published mean has a standard error "
            f"of {error:.1f} mm."
        )
    alone = next(i for i, row in enumerate(table) if row.stiffness is None)
    if calibration.confirmations:
        spread = max(
            float(each.prediction.standard_deviation[alone, 0]) for each in calibration.confirmations
        )
        sentences.append(
            "No hypothesis makes TE₁ spread in the unconnected mode: "
            f"{1e3 * table[alone].standard_deviation[0]:.1f} mm over the published trials, "
            f"{1e3 * spread:.1f} mm in the laboratory, where the skilled agent alone repeats itself exactly."
        )
    return sentences


def _own_values(explanation: Explanation) -> str:
    assert explanation.hypothesis is not None
    return ", ".join(_text(explanation, each.name) for each in explanation.hypothesis.own)


def _text(explanation: Explanation, name: str) -> str:
    """Write a parameter with its interval; what a search leaves near an end of its range is that end."""
    assert explanation.hypothesis is not None
    parameter = next(each for each in explanation.hypothesis.parameters if each.name == name)
    value, profile = explanation.values[name], explanation.profiles.get(name)
    if abs(value) < 1e-3 * (parameter.high - parameter.low):
        value = 0.0
    text = format_quantity(value, parameter.unit, 3)
    if profile is None:
        return text
    low, high = (format_quantity(end, parameter.unit, 3, bare=True) for end in profile.interval)
    return f"{text} ({low} to {high})"
