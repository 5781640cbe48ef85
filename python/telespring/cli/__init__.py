"""The commands `telespring decide`, `simulate`, `identify`, `rehearse`, `analyse` and `study`.

Exit status: 0 where the question was answered, whatever the answer; 2 for input that was refused or a
file that could not be read or written; 130 after Ctrl-C.
"""

from __future__ import annotations

import csv
import io
import json
import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.cli.identify import identify_command
from telespring.cli.rehearse import rehearse
from telespring.model import Dyad, Study
from telespring.show.screens.decision import decision_screen, digits_down, refusal_screen
from telespring.theory import simulation
from telespring.theory.spectrum import spectral_abscissa

if TYPE_CHECKING:
    import xarray

    from telespring.decision.decide import Decision
    from telespring.study.editing import RobotRecord

__all__ = ["app", "main"]

app = typer.Typer(
    name="telespring",
    help="Two people, two robots, one virtual spring over a network: is it stable, and by how much?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)

StudyFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="[STUDY.toml]", help="Robots, coupling and network; the paper's two H-MANs unless given."
    ),
]
Stiffness = Annotated[float | None, typer.Option("--stiffness", help="Stiffness of the spring, N/m.")]
Delay = Annotated[
    float | None, typer.Option("--delay", help="One-way delay in s, each way unless --backward is given.")
]
Backward = Annotated[
    float | None,
    typer.Option("--backward", help="One-way delay in s from robot 2 to robot 1, where it differs."),
]
Robot1 = Annotated[
    Path | None,
    typer.Option("--robot1", metavar="FILE", help="A robot file, as `identify` writes it, for robot 1."),
]
Robot2 = Annotated[
    Path | None,
    typer.Option("--robot2", metavar="FILE", help="A robot file, as `identify` writes it, for robot 2."),
]


class Format(StrEnum):
    """How `simulate` writes its result."""

    netcdf = "nc"
    csv = "csv"


@app.command()
def decide(
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
    with _refusals():
        from telespring.decision.decide import decide as answer

        read = _read(study, robot1, robot2)
        asked = _asked(read, stiffness, delay, backward)
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
            records=_records(robot1, robot2),
        )
        if study is not None:
            decision = _with_arms(decision, read, study)
    if as_json:
        # Where the output cannot write every letter, JSON can escape them.
        escape_letters = not sys.stdout.encoding.lower().startswith("utf")
        typer.echo(json.dumps(decision.to_json(), indent=1, ensure_ascii=escape_letters, allow_nan=False))
    else:
        Console(highlight=False).print(decision_screen(decision, asked.name))


@app.command()
def simulate(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    force: Annotated[
        list[float] | None,
        typer.Option(
            "--force",
            help="A step of force at t = 0, N; once per axis for robot 1, then for robot 2. "
            "1 and -1 unless given.",
        ),
    ] = None,
    duration: Annotated[float, typer.Option(help="Time to simulate, s.")] = 10.0,
    rate: Annotated[float, typer.Option(help="Outputs per second, Hz.")] = 1000.0,
    out: Annotated[Path, typer.Option(help="File to write, .nc (netCDF) or .csv.", show_default=True)] = Path(
        "out/simulation.nc"
    ),
) -> None:
    """Simulate the ideal dyad with constant delay and write positions and velocities."""
    console = Console(highlight=False)
    with _refusals():
        if out.suffix not in {f".{each}" for each in Format}:
            raise InvalidInput(
                "out", str(out), "the file's name must end in .nc or .csv", "Choose one of them."
            )
        asked = _asked(_read(study, robot1, robot2), stiffness, delay, backward)
        axes = list(asked.dyad.axes)
        forces = _forces(force, len(axes))
        found = simulation.simulate(asked.dyad, asked.stiffness, asked.delay, forces, duration, rate=rate)
        if out.suffix == ".csv":
            write_whole(out, _csv(found, axes))
        else:
            with replacing(out) as beside:
                found.to_netcdf(beside, engine="h5netcdf")
        for line in _simulation_summary(found, asked, axes, forces):
            console.print(line)
        for line in _robot_warnings(robot1, robot2):
            console.print(line, markup=False)
        console.print(f"Written: {out}", markup=False)


@app.command("analyse")
def analyse_command(
    path: Annotated[
        Path | None,
        typer.Argument(metavar="PATH", help="A rehearsal (.nc or its folder) or recorded trials (CSV)."),
    ] = None,
    study: Annotated[
        Path | None, typer.Option(help="Study whose task is the target of trials recorded without one.")
    ] = None,
    discard: Annotated[
        float | None,
        typer.Option(help="First part of every trial to leave out, s; as recorded unless given."),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Condition whose TE2 all is compared with; unconnected unless given.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for analysis.json, table1.csv and the figures.")] = Path(
        "out/analysis"
    ),
    export: Annotated[
        Path | None, typer.Option(help="Write the trials as CSV into this folder, too.")
    ] = None,
    figures: Annotated[bool, typer.Option(help="Draw Figs. 7 and 8.")] = True,
    template: Annotated[
        Path | None, typer.Option(help="Write an example of recorded trials into this folder, and stop.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print analysis.json instead of the table.")
    ] = False,
) -> None:
    """Measure the trials of an experiment, rehearsed or recorded, and compare its conditions."""
    console = Console(highlight=False)
    with _refusals():
        from telespring import analysis
        from telespring.analysis.sources import open_trials, write_analysis
        from telespring.show.screens.analysis import analysis_screen

        if template is not None:
            console.print(f"Written: {analysis.write_template(template)}", markup=False)
            return
        if path is None:
            raise InvalidInput(
                "PATH", "missing", "a rehearsal or recorded trials are needed", "Name a file or a folder."
            )
        # Any: a study without an experiment has None there.
        asked: Any = None if study is None else getattr(Study.read(study), "experiment", None)
        if study is not None and asked is None:
            raise InvalidInput(
                "study",
                str(study),
                "a study whose robots have the axes x and y is needed",
                "Only those have a task.",
            )
        dataset = open_trials(path, None if asked is None else asked.task)
        if discard is None and asked is not None and "discard" not in dataset.attrs:
            discard = float(asked.discard)
        trials = analysis.take_trials(dataset, discard)
        numbers = analysis.analyse_taken(trials, analysis.measure_trials(trials), baseline)
        written = write_analysis(trials, numbers, out, figures=figures)
        if export is not None:
            written = (*written, analysis.write_recorded(dataset, export))
    if as_json:
        escape_letters = not sys.stdout.encoding.lower().startswith("utf")
        typer.echo(json.dumps(numbers, indent=1, ensure_ascii=escape_letters, allow_nan=False))
        return
    console.print(analysis_screen(numbers, str(path)))
    if "resampled_to" in dataset.attrs:
        period = 1e3 * dataset.attrs["resampled_to"]
        console.print(f"The trials' samples lay at different times: put on a grid of {period:.4g} ms.")
    console.print(f"Written: {', '.join(str(each) for each in written)}", markup=False)


@app.command("study")
def study_command(
    study: StudyFile = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    out: Annotated[Path, typer.Option(help="Folder for report.html, study.json and rehearsal.nc.")] = Path(
        "out/study"
    ),
) -> None:
    """Run the whole paper on a study's robots, stability and experiment, and write a report.

    Stopped at any moment, the same command goes on with the trials that are not yet run.
    """
    console = Console(highlight=False)
    with _refusals():
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        from telespring.paper import STEPS, analyse, write

        asked, beware = _read(study, robot1, robot2), _robot_warnings(robot1, robot2)
        with Progress(
            TextColumn("{task.description:<28}"),
            BarColumn(),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        ) as bar:
            task = bar.add_task("starting", total=len(STEPS))

            def progress(step: str) -> None:
                bar.update(task, description=step, completed=STEPS.index(step))

            modules = None if study is None else study.parent
            analysis = analyse(asked, progress, rehearsal=out, modules=modules)
        report, numbers = write(analysis, out)
    summary = analysis.numbers["summary"]
    row = summary["rows"][summary["highlight"]]
    console.print(f"[bold]{escape(asked.name)}[/bold]")
    console.print(f"Over {1e3 * row['delay']:.0f} ms each way the spring may have up to")
    for tier in summary["tiers"]:
        entry = row[tier["key"]]
        if entry["unbounded"]:
            limit = "no limit"
        elif entry["stiffness"] is None:
            limit = "not available"
        else:
            limit = f"{digits_down(entry['stiffness'])} N/m (axis {entry['axis']})"
        console.print(f"  {limit:<24} {tier['name']}", markup=False)
    for line in beware:
        console.print(line, markup=False)
    console.print(f"Report:  {report}\nNumbers: {numbers}", markup=False)
    if "experiment" in analysis.numbers:
        console.print(f"Trials:  {out / 'rehearsal.nc'}", markup=False)


def main() -> None:
    """Run the command line; the entry point of the installed program."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A letter that the terminal cannot write must not cost the answer.
            stream.reconfigure(errors="replace")
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(130)


@contextmanager
def _refusals() -> Iterator[None]:
    """Tell refused input and unusable files in a few lines, and leave with status 2."""
    try:
        yield
    except InvalidInput as refused:
        refusal_screen(
            Console(stderr=True, highlight=False),
            refused.field,
            refused.value,
            refused.allowed,
            refused.remedy,
        )
        raise typer.Exit(2) from None
    except OSError as trouble:
        where = trouble.filename or "file"
        refusal_screen(
            Console(stderr=True, highlight=False),
            "file",
            str(where),
            f"a file that can be read or written is needed ({trouble.strerror or trouble})",
            "Check the name, the folder and its permissions.",
        )
        raise typer.Exit(2) from None
    except KeyboardInterrupt:
        print("Stopped; nothing half-written was left behind.", file=sys.stderr)
        raise typer.Exit(130) from None


app.command("identify")(_refusals()(identify_command))
app.command()(_refusals()(rehearse))


def _with_arms(decision: Decision, study: Study, study_file: Path) -> Decision:
    """Add what arms and agents change, where the file says which hold the handles."""
    from telespring.decision.arms import names_arms_or_agents, stability_in_arms

    if study.experiment is None or not names_arms_or_agents(study_file):
        return decision
    asked = [(decision.stiffness, decision.constant_delay)]
    return replace(decision, in_arms=stability_in_arms(study, asked, study_file.parent))


def _read(study: Path | None, robot1: Path | None = None, robot2: Path | None = None) -> Study:
    """Read a study file, or take the paper's study where none is named; put robots of their own in."""
    read = Study.paper() if study is None else Study.read(study)
    for side, robot in ((1, robot1), (2, robot2)):
        if robot is not None:
            from telespring.study.editing import with_robot

            read = with_robot(read, side, robot)
    return read


def _records(robot1: Path | None, robot2: Path | None) -> tuple[RobotRecord | None, RobotRecord | None]:
    """Read what identification found besides the robots' parameters."""
    from telespring.study.editing import robot_record

    return (
        None if robot1 is None else robot_record(robot1),
        None if robot2 is None else robot_record(robot2),
    )


def _robot_warnings(robot1: Path | None, robot2: Path | None) -> list[str]:
    """Tell what identification warned of; coupled axes are among it."""
    return [
        f"Beware: robot {i}, when it was identified: {warning}"
        for i, record in enumerate(_records(robot1, robot2), start=1)
        if record is not None
        for warning in record.warnings
    ]


@dataclass(frozen=True)
class _Asked:
    """A dyad, its name, the stiffness (N/m) and the delays there and back (s) asked about."""

    dyad: Dyad
    name: str
    stiffness: float
    delay: tuple[float, float]


def _asked(study: Study, stiffness: float | None, delay: float | None, backward: float | None) -> _Asked:
    """Take the study, with what the command line says in the place of what the file says."""
    forward, back = study.delay if delay is None else (delay, delay)
    return _Asked(
        dyad=study.dyad,
        name=study.name,
        stiffness=study.stiffness if stiffness is None else stiffness,
        delay=(forward, back if backward is None else backward),
    )


def _forces(force: list[float] | None, axes: int) -> list[list[float]]:
    if not force:
        return [[1.0] * axes, [-1.0] * axes]
    if len(force) != 2 * axes or not all(math.isfinite(value) for value in force):
        raise InvalidInput(
            "force",
            " ".join(str(value) for value in force),
            f"one finite number per robot and axis is needed, that is {2 * axes}",
            "Write --force once for each: robot 1 on every axis, then robot 2.",
        )
    return [force[:axes], force[axes:]]


def _csv(found: xarray.Dataset, axes: list[str]) -> str:
    import numpy as np

    names, columns = ["time_s"], [np.asarray(found["time"])]
    for quantity, unit in (("position", "m"), ("velocity", "m_per_s")):
        values = np.asarray(found[quantity])
        for robot in range(2):
            for i, axis in enumerate(axes):
                names.append(f"{quantity}_robot{robot + 1}_{axis}_{unit}")
                columns.append(values[:, robot, i])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([float(value) for value in row] for row in zip(*columns, strict=True))
    return text.getvalue()


#: A distance, mm, that no two robots in a dyad ever have: 1 km.
_RUNAWAY = 1e6


def _simulation_summary(
    found: xarray.Dataset, asked: _Asked, axes: list[str], forces: list[list[float]]
) -> Iterator[str]:
    import numpy as np

    time, position = np.asarray(found["time"]), np.asarray(found["position"])
    yield f"[bold]{escape(asked.name)}[/bold]"
    yield f"{asked.stiffness:.4g} N/m, {len(time)} samples over {time[-1]:.4g} s"
    diverged = found.attrs.get("diverged_at")
    if diverged is not None and math.isfinite(float(diverged)):
        yield (
            f"[bold red]Diverged at {float(diverged):.4g} s[/bold red]: a position was over 1e12 m, the "
            "file ends before it."
        )
    for i, axis in enumerate(axes):
        apart = position[:, 0, i] - position[:, 1, i]
        apart = apart[np.isfinite(apart)]
        abscissa = float(spectral_abscissa(asked.dyad, asked.stiffness, asked.delay, axis=i))
        largest = 1e3 * float(np.max(np.abs(apart)))
        if largest > _RUNAWAY:
            yield f"  axis {escape(axis)}: unstable, the robots run away from each other"
            continue
        text = f"  axis {escape(axis)}: apart {1e3 * apart[-1]:.4g} mm at the end, at most {largest:.4g} mm"
        rest = _rest_distance(asked, forces, i)
        if abscissa >= 0.0:
            text += ", unstable: it does not come to rest"
        elif rest is not None:
            overshoot = 100.0 * (largest / abs(1e3 * rest) - 1.0)
            text += f"; at rest {1e3 * rest:.4g} mm, overshoot {max(0.0, overshoot):.3g} %"
        yield text


def _rest_distance(asked: _Asked, forces: list[list[float]], axis: int) -> float | None:
    """How far apart (m) free robots come to rest under opposite steps; None in other cases."""
    from telespring.theory.axis import axes_of

    one, other = forces[0][axis], forces[1][axis]
    if one == 0.0 or one != -other or axes_of(asked.dyad)[axis].ground_stiffness != (0.0, 0.0):
        return None
    return one / asked.stiffness


if __name__ == "__main__":
    main()
