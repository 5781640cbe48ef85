"""The command `telespring decide`."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring.cli.common import (
    Backward,
    Delay,
    Robot1,
    Robot2,
    Stiffness,
    StudyFile,
    read_study,
    refusals,
    requested_case,
    robot_records,
)
from telespring.model import Study
from telespring.show.screens.decision import decision_screen

if TYPE_CHECKING:
    from telespring.decision.decide import Decision

__all__ = ["decide_command"]


def decide_command(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    jitter: Annotated[float | None, typer.Option(help="How much longer than that a delay may be, s.")] = None,
    max_gap: Annotated[float | None, typer.Option(help="Longest time without a new sample, s.")] = None,
    sample_period: Annotated[float | None, typer.Option(help="Period of the controllers, s.")] = None,
    horizon: Annotated[float | None, typer.Option(help="List stable delays up to this one, s.")] = None,
    decay_rate: Annotated[
        float | None,
        typer.Option(help="Also give the stiffnesses at which every motion decays this fast or faster, 1/s."),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Tell whether a dyad is stable, by what margin, and what it may use instead."""
    with refusals():
        from telespring.decision.decide import decide as answer

        read = read_study(study, robot1, robot2)
        asked = requested_case(read, stiffness, delay, backward)
        if horizon is not None and not 0.0 < horizon <= 1000.0:
            raise InvalidInput(
                "horizon",
                str(horizon),
                "a horizon must be a number above 0 and up to 1000 s",
                "Leave it away for 1 s.",
            )
        decision = answer(
            asked.dyad,
            asked.stiffness,
            asked.delay,
            jitter=read.network.jitter if jitter is None else jitter,
            max_gap=read.network.max_gap if max_gap is None else max_gap,
            sample_period=read.network.sample_period if sample_period is None else sample_period,
            computing_time=read.network.computing_time,
            operator_ranges=read.operator_ranges,
            horizon=horizon,
            decay_rate=decay_rate,
            uncertainty=read.uncertainty,
            records=robot_records(robot1, robot2),
        )
        if study is not None:
            decision = _with_arms(decision, read, study)
    if as_json:
        # Where the output cannot write every letter, JSON can escape them.
        escape_letters = not sys.stdout.encoding.lower().startswith("utf")
        typer.echo(json.dumps(decision.to_json(), indent=1, ensure_ascii=escape_letters, allow_nan=False))
    else:
        Console(highlight=False).print(decision_screen(decision, asked.name))


def _with_arms(decision: Decision, study: Study, study_file: Path) -> Decision:
    """Add what arms and agents change, where the file says which hold the handles."""
    from telespring.decision.arms import names_arms_or_agents, stability_in_arms

    if study.experiment is None or not names_arms_or_agents(study_file):
        return decision
    asked = [(decision.stiffness, decision.constant_delay)]
    return replace(decision, in_arms=stability_in_arms(study, asked, study_file.parent))
