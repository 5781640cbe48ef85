"""Notes on robots that were identified: what to know before relying on the verdicts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.text import Text

if TYPE_CHECKING:
    from telespring.decision.decide import Decision
    from telespring.decision.limits import Limits
    from telespring.study.robot_file import RobotRecord

__all__ = ["identification_notes", "outside_probability", "robot_notes", "warning_lines"]


def identification_notes(records: tuple[RobotRecord | None, RobotRecord | None]) -> list[str]:
    """Repeat the warnings that identification recorded about either robot."""
    return [
        f"Robot {number}, from its identification: {warning}"
        for number, record in enumerate(records, start=1)
        if record is not None
        for warning in record.warnings
    ]


def robot_notes(answer: Decision | Limits) -> list[str]:
    """Report coupled axes, identification warnings, and a robot without uncertainty if only one has it."""
    records, exact = answer.robot_records, answer.robots_without_errors
    coupled = [i for i, record in enumerate(records, start=1) if record and record.independent is False]
    notes = []
    if coupled:
        whose = "both robots" if len(coupled) == 2 else f"robot {coupled[0]}"
        notes.append(
            f"The axes of {whose} are NOT independent. All verdicts and margins here treat the axes "
            "separately and do not hold for such a robot; no probability of stability is given."
        )
    notes += identification_notes(records)
    if len(exact) == 1 and not coupled:
        notes.append(
            f"Robot {exact[0]} has no standard deviations and is treated as exactly known; intervals and "
            f"probability include the uncertainty of robot {3 - exact[0]} only."
        )
    return notes


def warning_lines(answer: Decision | Limits) -> list[Text]:
    """Write the notes on the robots as lines of a screen."""
    return [Text.assemble(("Warning: ", "bold yellow"), note) for note in robot_notes(answer)]


def outside_probability(decision: Decision) -> str:
    """State what the probability of stability does not cover."""
    outside = ["what the model of the robots leaves out", "an error of the force sensor's gain"]
    single = [
        str(number)
        for number, record in enumerate(decision.robot_records, start=1)
        if number not in decision.robots_without_errors and (record is None or record.logs in (None, 1))
    ]
    if single:
        robots = f"robot {single[0]}" if len(single) == 1 else "both robots"
        outside.append(f"how much logs of {robots} differ from one another")
    return f"It does not cover {', '.join(outside[:-1])} and {outside[-1]}."
