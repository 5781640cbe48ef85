"""The command `telespring decide`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from telespring._core import check_usual
from telespring._errors import InvalidInput
from telespring.cli.common import (
    AllowUnusual,
    Backward,
    Delay,
    Robot1,
    Robot2,
    Stiffness,
    StudyFile,
    print_json,
    refusals,
)
from telespring.cli.figure_file import check_figure_name, save_figure
from telespring.cli.grip import describe_grips, read_grip
from telespring.cli.question import StudyOptions
from telespring.cli.terminal import screen_console, show
from telespring.cli.units import RATE, TIME, number
from telespring.model import Study
from telespring.show.quantities import format_time

if TYPE_CHECKING:
    from telespring.decision.decide import Decision

__all__ = ["decide_command"]

_TIME = number(TIME)


def decide_command(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    ping: Annotated[
        float | None,
        typer.Option(parser=_TIME, metavar="TIME", help="Round trip instead of --delay: half each way."),
    ] = None,
    ping_jitter: Annotated[
        float | None,
        typer.Option(parser=_TIME, metavar="TIME", help="Largest ping less the smallest: all each way."),
    ] = None,
    robot: Annotated[
        list[str] | None,
        typer.Option(
            "--robot",
            metavar="ROBOT",
            help="Write it twice, for robots 1 and 2: mass,damping (kg, N·s/m), such as 1.2,6, axes apart by "
            "'/'; or a file written by `identify`; or hman1, hman2, the paper's.",
        ),
    ] = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    grip: Annotated[
        str | None,
        typer.Option(
            metavar="LOW:HIGH",
            help="Stiffness of the hands that hold the handles, N/m, such as 50:300; with damping and mass "
            "50:300,0:5,0:0.5. Free handles are shown beside.",
        ),
    ] = None,
    grip1: Annotated[str | None, typer.Option(metavar="LOW:HIGH", help="The same for robot 1 only.")] = None,
    grip2: Annotated[str | None, typer.Option(metavar="LOW:HIGH", help="The same for robot 2 only.")] = None,
    jitter: Annotated[
        float | None,
        typer.Option(parser=_TIME, metavar="TIME", help="Largest delay of a packet beyond --delay."),
    ] = None,
    max_gap: Annotated[
        float | None, typer.Option(parser=_TIME, metavar="TIME", help="Longest time without a new sample.")
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
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Exit with status 1 unless the dyad is stable with 5 % of stiffness and delay in reserve "
            "(and with probability 0.95 if the robots have errors); with --grip also with free handles.",
        ),
    ] = False,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write the map of stable stiffnesses and delays, with this condition marked: .svg, .png or "
            ".pdf.",
        ),
    ] = None,
    allow_unusual: AllowUnusual = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Decide whether a dyad is stable, by what margin, and what to change; or what stiffness you may use.

    Without a stiffness, the answer is the stiffness that you may use; without a delay, the delay. Options
    override the study file. Without a file and without robots, the robots are the paper's two H-MANs.

    Exit status: 0 for any answer; 1 with --check unless the answer is "stable"; 2 for refused input.

    Examples: telespring decide --robot 1.2,6 --robot 2,9 --ping 80ms
    """
    asked = StudyOptions(study)
    with refusals(asked.options):
        if figure is not None:
            check_figure_name(figure)
        asked.take_robots(robot, robot1, robot2)
        asked.allow_unusual(is_allowed=allow_unusual)
        asked.take("coupling", "stiffness", stiffness, "--stiffness")
        if ping is not None or ping_jitter is not None:
            if not allow_unusual:
                _refuse_unusual_ping(ping, ping_jitter)
            delay, jitter = _take_ping(asked, ping, ping_jitter, delay, backward, jitter)
        asked.take_delay(delay, backward)
        if ping is not None:
            asked.options["network.delay"] = "--ping"
        asked.take("network", "jitter", jitter, "--jitter" if ping_jitter is None else "--ping-jitter")
        asked.take("network", "max_gap", max_gap, "--max-gap")
        if continuous and sample_period:
            raise InvalidInput(
                "--continuous",
                f"beside --sample-period {sample_period}",
                "a controller either samples or not",
                "Leave out one of them.",
            )
        asked.take("controller", "sample_period", 0.0 if continuous else sample_period, "--sample-period")
        if continuous:
            asked.take("controller", "computing_time", 0.0, "--continuous")
        held = _take_grips(asked, grip, grip1, grip2)
        read = asked.read()
        is_stable = _answer(asked, read, held, horizon, decay_rate, check=check, as_json=as_json)
        if figure is not None:
            _write_map(read, figure)
            if not as_json:
                screen_console().print(f"Figure: {figure}", markup=False)
    if check and not is_stable:
        raise typer.Exit(1)


def _write_map(study: Study, path: Path) -> None:
    from matplotlib.figure import Figure

    from telespring.plot import stability_map
    from telespring.show.figures.style import figure_style

    mark = None
    if study.has_stiffness and study.has_delay:
        delay = 0.5 * sum(study.delay)
        mark = (study.stiffness, delay, delay + study.network.jitter + study.network.max_gap)
    with figure_style():
        drawing = Figure(figsize=(5.6, 4.2), layout="constrained")
        axes = drawing.subplots()
    stability_map(study.dyad, mark=mark, operator_range=study.operator_ranges, ax=axes)
    save_figure(drawing, path)


def _refuse_unusual_ping(ping: float | None, ping_jitter: float | None) -> None:
    """Refuse a ping that no laboratory has as it was written, not the half of it that goes one way."""
    if ping is not None:
        try:
            check_usual("delay", "--ping", 0.5 * ping)
        except InvalidInput:
            check_usual("delay", "--ping", ping)
    if ping_jitter is not None:
        check_usual("time span", "--ping-jitter", ping_jitter)


def _take_ping(
    asked: StudyOptions,
    ping: float | None,
    ping_jitter: float | None,
    delay: float | None,
    backward: float | None,
    jitter: float | None,
) -> tuple[float | None, float | None]:
    """Turn a round trip into one-way delays, and say how."""
    if ping is not None and (delay is not None or backward is not None):
        raise InvalidInput(
            "--ping",
            format_time(ping, 6),
            "it gives the delay both ways",
            "Leave out --delay and --backward, or --ping.",
        )
    if ping_jitter is not None and jitter is not None:
        raise InvalidInput(
            "--ping-jitter",
            format_time(ping_jitter, 6),
            "it gives the jitter of both ways",
            "Leave out --jitter or --ping-jitter.",
        )
    if ping is not None:
        delay = 0.5 * ping
        asked.notes.append(
            f"A ping of {format_time(ping, 6)} is {format_time(delay, 6)} each way. Continuous controllers "
            "see only the sum of both delays. Sampled ones round each way up to a whole sample period: if "
            "the ping is shared otherwise, the sum may be one period longer."
        )
    if ping_jitter is not None:
        jitter = ping_jitter
        asked.notes.append(
            f"A jitter of {format_time(jitter, 6)} of the ping may all fall on one way: both have it."
        )
    return delay, jitter


def _take_grips(asked: StudyOptions, both: str | None, one: str | None, other: str | None) -> str | None:
    """Take the grips, and describe them; None without one."""
    if both is not None and (one is not None or other is not None):
        raise InvalidInput("--grip", both, "it holds for both robots", "Leave out --grip1 and --grip2.")
    grips = []
    for number_, own, option in ((1, one, "--grip1"), (2, other, "--grip2")):
        written, option = (both, "--grip") if both is not None else (own, option)
        keys = None if written is None else read_grip(written, option)
        for key, value in (keys or {}).items():
            asked.take(f"operator{number_}", key, value, option)
        grips.append(keys)
    return None if grips == [None, None] else describe_grips(grips[0], grips[1])


def _answer(
    asked: StudyOptions,
    read: Study,
    held: str | None,
    horizon: float | None,
    decay_rate: float | None,
    *,
    check: bool,
    as_json: bool,
) -> bool:
    """Print the answer; return whether it is stable with the reserve, and with free handles beside a grip."""
    # The delay is 0 where none is given, and not used.
    timed = read if read.has_delay else read.replace(network={"delay": 0.0})
    network = timed.network
    common: dict[str, Any] = {
        "jitter": network.jitter,
        "max_gap": network.max_gap,
        "sample_period": network.sample_period,
        "computing_time": network.computing_time,
        "operator_ranges": read.operator_ranges,
        "compare_free": True,
        # The study has refused unusual values, or allowed them.
        "allow_unusual": True,
    }
    title, label = asked.title(read), held or "held"
    if not (read.has_stiffness and read.has_delay):
        from telespring.decision.limits import limits
        from telespring.show.limits_json import limits_json
        from telespring.show.screens.limits import limits_screen

        unanswerable = [
            ("--check", check),
            ("--decay-rate", decay_rate is not None),
            ("--horizon", horizon is not None),
        ]
        for option, is_given in unanswerable:
            if is_given:
                raise InvalidInput(
                    option,
                    "without a stiffness and a delay",
                    "it concerns one stiffness and one delay",
                    "Give --stiffness and --delay, or leave it out.",
                )
        found = limits(
            read.dyad,
            read.delay if read.has_delay else None,
            read.stiffness if read.has_stiffness else None,
            **common,
        )
        if as_json:
            print_json(limits_json(found))
        else:
            show(limits_screen(found, title, label, asked.notes))
        return True

    from telespring.decision.decide import decide
    from telespring.show.decision_json import decision_json
    from telespring.show.screens.decision import decision_screen

    if horizon is not None and not 0.0 < horizon <= 1000.0:
        raise InvalidInput(
            "--horizon",
            str(horizon),
            "a horizon must be a number above 0 and up to 1000 s",
            "Omit --horizon for the default.",
        )
    if decay_rate is not None:
        asked.options["decay_rate"] = "--decay-rate"
    decision = decide(
        read.dyad,
        read.stiffness,
        read.delay,
        horizon=horizon,
        decay_rate=decay_rate,
        uncertainty=read.uncertainty,
        records=asked.records(),
        **common,
    )
    if asked.file is not None:
        decision = _decision_with_arms(decision, read, asked.file)
    if as_json:
        print_json(decision_json(decision))
    else:
        show(decision_screen(decision, title, label, asked.notes))
    free = decision.free if held is not None else None
    return decision.status == "stable" and (free is None or free.status == "stable")


def _decision_with_arms(decision: Decision, study: Study, study_file: Path) -> Decision:
    """Add the stability in arms if the study file itself describes what holds the handles."""
    from telespring.decision.arm_stability import arm_stability

    if study.experiment is None or not study.names_arms_or_agents:
        return decision
    condition = (decision.stiffness, decision.constant_delay)
    return replace(decision, arms=arm_stability(study, [condition], study_file.parent))
