"""The command `telespring decide`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from telespring._errors import InvalidInput
from telespring.cli.common import (
    AllowUnusual,
    Backward,
    Delay,
    Ping,
    Robot1,
    Robot2,
    Robots,
    Stiffness,
    StudyFile,
    print_json,
    refusals,
)
from telespring.cli.figure_file import check_figure_name, check_not_an_input, save_figure
from telespring.cli.grip import read_grip
from telespring.cli.question import StudyOptions
from telespring.cli.terminal import screen_console, show
from telespring.cli.units import DAMPING, RATE, TIME, number
from telespring.model import Study

if TYPE_CHECKING:
    from telespring.answer import Answer
    from telespring.decision.question import Texts

__all__ = ["decide_command"]

_TIME = number(TIME)
#: The starts of an attack, so that the command answers the same each time.
_ATTACK_SEED = 1


def decide_command(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    ping: Ping = None,
    ping_jitter: Annotated[
        float | None,
        typer.Option(
            parser=_TIME,
            metavar="TIME",
            help="The largest ping minus the smallest; all of it counts for each way.",
        ),
    ] = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    grip: Annotated[
        str | None,
        typer.Option(
            metavar="LOW:HIGH",
            help="How stiffly hands hold the handles: 50:300 is any hand from 50 to 300 N/m, beside free "
            "handles (damping in N·s/m and mass in kg may follow: 50:300,0:5,0:0.5).",
        ),
    ] = None,
    grip1: Annotated[str | None, typer.Option(metavar="LOW:HIGH", help="The same for robot 1 only.")] = None,
    grip2: Annotated[str | None, typer.Option(metavar="LOW:HIGH", help="The same for robot 2 only.")] = None,
    jitter: Annotated[
        float | None,
        typer.Option(parser=_TIME, metavar="TIME", help="Longest time that a packet takes beyond --delay."),
    ] = None,
    max_gap: Annotated[
        float | None, typer.Option(parser=_TIME, metavar="TIME", help="Longest time without a new sample.")
    ] = None,
    playout_buffer: Annotated[
        bool | None,
        typer.Option(
            "--playout-buffer/--no-playout-buffer",
            help="Both sides hold every sample until it is as old as the latest one can be, which makes the "
            "delay constant; without it the answer is for a delay that varies.",
            show_default="as the study says, or none",
        ),
    ] = None,
    sample_period: Annotated[
        float | None,
        typer.Option(
            parser=_TIME,
            metavar="TIME",
            help="Sample period of both controllers; 0 for continuous ones.",
            show_default="as the study says, or 1 ms",
        ),
    ] = None,
    continuous: Annotated[
        bool, typer.Option("--continuous", help="Continuous controllers: --sample-period 0.")
    ] = False,
    computing_time: Annotated[
        float | None,
        typer.Option(
            parser=_TIME,
            metavar="TIME",
            help="Time from reading the samples to applying the force, at most the sample period.",
            show_default="as the study says, or none",
        ),
    ] = None,
    coupling_damping: Annotated[
        float | None,
        typer.Option(
            parser=number(DAMPING),
            metavar="N·s/m",
            help="A virtual damper beside the spring, over the same network.",
            show_default="as the study says, or none",
        ),
    ] = None,
    horizon: Annotated[
        float | None,
        typer.Option(
            parser=_TIME,
            metavar="TIME",
            help="List stable delays up to this one. Default: 1 s, or twice the delay.",
        ),
    ] = None,
    decay_rate: Annotated[
        float | None,
        typer.Option(
            parser=number(RATE),
            metavar="1/s",
            help="Also list the stiffnesses at which every motion decays at this rate or faster.",
        ),
    ] = None,
    attack: Annotated[
        bool,
        typer.Option(
            "--attack",
            help="Also search the lowest stiffness at which a delay that varies by jitter and gaps can "
            "make the motion grow: about a second, several where they are long.",
        ),
    ] = False,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Exit with status 1 unless the answer is STABLE: with 5 % of stiffness and delay in "
            "reserve, with probability 0.95 if the robots have errors, with free handles beside held ones, "
            "in the arms that the study names, and without a playout buffer unless one is stated.",
        ),
    ] = False,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write the map of what is stable over stiffness and delay, judged as here, with this "
            "condition marked: .svg, .png or .pdf.",
        ),
    ] = None,
    allow_unusual: AllowUnusual = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Decide whether a dyad is stable, by what margin, and what to change; or what you may use.

    Without a stiffness the answer is the stiffness that you may use; without a delay, what each delay allows.

    Options replace what the study file says. Without a file and robots, they are the paper's two H-MANs.

    Exit status: 0 for any answer; 1 with --check unless the answer is STABLE; 2 for refused input.

    Example: telespring decide --robot 1.2,6 --robot 2,9 --ping 80ms
    """
    asked = StudyOptions(study)
    with refusals(asked.options, asked.written):
        from telespring.rehearsal.traces import read_traces

        if figure is not None:
            check_figure_name(figure)
        asked.take_robots(robot, robot1, robot2)
        if figure is not None:
            check_not_an_input("--figure", figure, asked.inputs)
        asked.allow_unusual(is_allowed=allow_unusual)
        asked.take("coupling", "stiffness", stiffness, "--stiffness")
        asked.take_ping(
            ping, delay, backward, jitter=jitter, ping_jitter=ping_jitter, check_unusual=not allow_unusual
        )
        asked.take("coupling", "damping", coupling_damping, "--coupling-damping")
        asked.take("network", "max_gap", max_gap, "--max-gap")
        asked.take("network", "playout_buffer", playout_buffer, "--playout-buffer")
        if continuous and sample_period:
            raise InvalidInput(
                "--continuous",
                f"beside --sample-period {sample_period}",
                "a controller either samples or not",
                "Leave out one of them.",
            )
        asked.take("controller", "sample_period", 0.0 if continuous else sample_period, "--sample-period")
        if continuous and computing_time:
            raise InvalidInput(
                "--continuous",
                f"beside --computing-time {computing_time}",
                "a continuous controller computes in no time",
                "Leave out one of them.",
            )
        asked.take("controller", "computing_time", computing_time, "--computing-time")
        if continuous:
            asked.take("controller", "computing_time", 0.0, "--continuous")
        _take_grips(asked, grip, grip1, grip2, allow_unusual=allow_unusual)
        read = asked.read()
        traces = read_traces(read, None if asked.file is None else asked.file.parent).texts
        answer = _answer(asked, read, horizon, decay_rate, traces, is_attacked=attack, check=check)
        if as_json:
            print_json(answer.to_dict())
        else:
            show(answer.screen())
        if figure is not None:
            _write_map(read, figure, answer, traces)
            if not as_json:
                screen_console().print(f"Figure: {figure}", markup=False)
    if check and not answer.is_stable:
        raise typer.Exit(1)


def _write_map(study: Study, path: Path, answer: Answer, traces: Texts) -> None:
    """Draw where the answer would be "stable", with the question and its answer marked."""
    from matplotlib.figure import Figure

    from telespring.decision.question import Question
    from telespring.plot import stability_map
    from telespring.show.figures.style import figure_style

    question = Question.of_study(study, delay=None if study.has_delay else 0.0, traces=traces)
    mark = (
        study.stiffness if study.has_stiffness else None,
        0.5 * sum(question.network.delay) if study.has_delay else None,
    )
    titles = [*answer.heading, *([answer.holders] if answer.holders else [])]
    found = answer.decision or answer.limits
    if found is not None and found.axes_independent is False:
        titles.append("The axes of a robot are not independent: nothing on this map is proven.")
    with figure_style():
        drawing = Figure(figsize=(5.6, 4.8), layout="constrained")
        axes = drawing.subplots()
    # whether values are usual was asked before
    stability_map(
        study.dyad,
        mark=mark,
        operator_range=study.operator_ranges,
        network=question.network,
        playout_buffer=question.has_playout_buffer,
        free=question.released().dyad if question.is_held else None,
        verdict=None if answer.decision is None else answer.decision.worst_status,
        title="\n".join(titles),
        allow_unusual=True,
        ax=axes,
    )
    save_figure(drawing, path)


def _take_grips(
    asked: StudyOptions, both: str | None, one: str | None, other: str | None, *, allow_unusual: bool
) -> None:
    """Take how hands hold the handles."""
    if both is not None and (one is not None or other is not None):
        raise InvalidInput("--grip", both, "it holds for both robots", "Leave out --grip1 and --grip2.")
    for number_, own, option in ((1, one, "--grip1"), (2, other, "--grip2")):
        written, option = (both, "--grip") if both is not None else (own, option)
        if written is None:
            continue
        for key, value in read_grip(written, option, allow_unusual=allow_unusual).items():
            asked.take(f"operator{number_}", key, value, option)


def _answer(
    asked: StudyOptions,
    read: Study,
    horizon: float | None,
    decay_rate: float | None,
    traces: Texts,
    *,
    is_attacked: bool,
    check: bool,
) -> Answer:
    """Answer the question, which --check needs whole."""
    from telespring.answer import answer_study

    if check and not (read.has_stiffness and read.has_delay):
        raise InvalidInput(
            "--check",
            "without a stiffness and a delay",
            "it concerns one stiffness and one delay",
            "Give --stiffness and --delay (or --ping), or leave it out.",
        )
    asked.options |= {"horizon": "--horizon", "decay_rate": "--decay-rate", "attack_seed": "--attack"}
    asked.note_robots(read)
    return answer_study(
        read,
        name=asked.heading(read),
        robot_names=asked.robot_names(read),
        records=asked.records(),
        notes=tuple(asked.notes),
        horizon=horizon,
        decay_rate=decay_rate,
        modules=None if asked.file is None else asked.file.parent,
        attack_seed=_ATTACK_SEED if is_attacked else None,
        traces=traces,
    )
