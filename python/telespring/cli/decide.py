"""The command `telespring decide`."""

from __future__ import annotations

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
    print_json,
    read_study,
    refusals,
    requested_delay,
    robot_records,
)
from telespring.model import Study

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
    jitter: Annotated[float | None, typer.Option(help="Largest delay of a packet beyond --delay, s.")] = None,
    max_gap: Annotated[float | None, typer.Option(help="Longest time without a new sample, s.")] = None,
    sample_period: Annotated[
        float | None, typer.Option(help="Sample period of both controllers, s; 0 for continuous ones.")
    ] = None,
    horizon: Annotated[
        float | None,
        typer.Option(help="List stable delays up to this one, s. Default: 1 s, or twice the delay."),
    ] = None,
    decay_rate: Annotated[
        float | None,
        typer.Option(
            help="Also list the stiffnesses at which every motion decays at this rate or faster, 1/s."
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Decide whether a dyad is stable, by what margin, and what to change.

    Options override the study file. Without a file, the robots are the paper's two H-MANs.
    """
    with refusals():
        from telespring.decision.decide import decide
        from telespring.show.decision_json import decision_json
        from telespring.show.screens.decision import decision_screen

        read = read_study(study, robot1, robot2)
        if horizon is not None and not 0.0 < horizon <= 1000.0:
            raise InvalidInput(
                "horizon",
                str(horizon),
                "a horizon must be a number above 0 and up to 1000 s",
                "Omit --horizon for the default.",
            )
        decision = decide(
            read.dyad,
            read.stiffness if stiffness is None else stiffness,
            requested_delay(read, delay, backward),
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
            decision = _decision_with_arms(decision, read, study)
    if as_json:
        print_json(decision_json(decision))
    else:
        Console(highlight=False).print(decision_screen(decision, read.name))


def _decision_with_arms(decision: Decision, study: Study, study_file: Path) -> Decision:
    """Add the stability in arms if the study file itself describes what holds the handles."""
    from telespring.decision.arm_stability import arm_stability

    if study.experiment is None or not study.names_arms_or_agents:
        return decision
    condition = (decision.stiffness, decision.constant_delay)
    return replace(decision, arms=arm_stability(study, [condition], study_file.parent))
