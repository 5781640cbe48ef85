"""Agents and targets that a user wrote in Python."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from telespring import _core
from telespring._errors import InvalidInput
from telespring._types import FloatArray

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = ["Force", "ProgramFailed", "Programs", "Stopped", "programs_of"]

Force: TypeAlias = Callable[[float, FloatArray, FloatArray, FloatArray], tuple[float, float]]

#: m/s; nobody's hand follows faster, and a target in millimetres is beyond it.
_FASTEST_TARGET = 10.0
#: m; a target in millimetres that hardly moves is beyond it.
_FARTHEST_TARGET = 10.0

_AGENT = (
    "An agent is called as agent(time, position, velocity, target) in s, m, m/s and m, and returns its "
    "force (x, y) in N."
)
_TARGET = "A target is called as target(times) in s, and returns positions of shape (n, 2) in m."


#: What a program may raise: one that leaves by sys.exit must not end the rehearsal as if all were well.
_RAISED = (Exception, SystemExit)


class Stopped(Exception):
    """A trial that was given up because the rehearsal is stopped."""


class ProgramFailed(InvalidInput):
    """A user's program that raised, or returned what is no force or no target."""


@dataclass(frozen=True)
class Program:
    """Something named by a study as "module:name", found.

    Attributes
    ----------
    field
        Where the study names it, such as ``agent1.class``.
    reference
        As the study names it.
    thing
        The class or function.
    file
        Where it was defined.
    options
        What it is called with besides, from the study.
    """

    field: str
    reference: str
    thing: Callable[..., Any]
    file: Path | None
    options: Mapping[str, Any]

    def provenance(self) -> dict[str, str]:
        """Return its name and a hash of its file, which its numbers depend on."""
        text = self.file.read_bytes() if self.file is not None else b""
        return {"name": self.reference, "sha256": hashlib.sha256(text).hexdigest()}

    def failed(self, what: str) -> ProgramFailed:
        """Return the refusal that tells what went wrong."""
        where = self.file.name if self.file else "its module"
        called = _TARGET if self.field == "task.function" else _AGENT
        return ProgramFailed(self.field, self.reference, what, f"Mend it in {where}. {called}")


@dataclass(frozen=True)
class Programs:
    """What of a study is written in Python.

    Attributes
    ----------
    agents
        Of both robots; None where an agent is the laboratory's own.
    target
        The target's function, or None.
    """

    agents: tuple[Program | None, Program | None]
    target: Program | None

    def provenance(self) -> dict[str, dict[str, str]]:
        """Return name and hash of all that there are, by their place in the study."""
        named = {"agent1": self.agents[0], "agent2": self.agents[1], "task": self.target}
        return {place: program.provenance() for place, program in named.items() if program is not None}

    def forces(self, seed: int, stop: Event) -> tuple[Force | None, Force | None] | None:
        """Make the agents of one trial, each with a seed of its own, or None where there are none."""
        if self.agents == (None, None):
            return None
        first, second = (
            None if program is None else _force(program, _core.trial_seed(seed, robot, 0), stop)
            for robot, program in enumerate(self.agents)
        )
        return first, second

    def positions(self, ticks: int, sample_period: float) -> FloatArray | None:
        """Ask the target's function where the target is at every tick of the controllers, or return None.

        Raises
        ------
        ProgramFailed
            Where it raises or returns what is no target.
        """
        if self.target is None:
            return None
        return _positions(self.target, sample_period * np.arange(ticks + 1, dtype=np.float64))


def programs_of(experiment: Experiment, folder: Path | None) -> Programs:
    """Find what a study names in Python: beside the study file first, then where Python looks.

    Parameters
    ----------
    experiment
        The study's protocol.
    folder
        Of the study file, if there is one.

    Raises
    ------
    InvalidInput
        Where a module or a name in it is not found.
    ProgramFailed
        Where a module raises as it is read.
    """
    found: list[Program | None] = []
    loaded: dict[str, ModuleType] = {}
    for robot, agent in enumerate(experiment.agents, start=1):
        if agent.class_ is not None:
            found.append(_find(f"agent{robot}.class", agent.class_, agent.options or {}, folder, loaded))
        else:
            found.append(None)
    target = None
    task = experiment.task
    if task.function is not None:
        target = _find("task.function", task.function, task.options or {}, folder, loaded)
    return Programs((found[0], found[1]), target)


def _find(
    field: str,
    reference: str,
    options: Mapping[str, Any],
    folder: Path | None,
    loaded: dict[str, ModuleType],
) -> Program:
    name, _, attribute = reference.partition(":")
    if name not in loaded:
        loaded[name] = _module(field, reference, name, folder)
    module = loaded[name]
    file = None if module.__file__ is None else Path(module.__file__)
    thing: Any = module
    for part in attribute.split("."):
        thing = getattr(thing, part, None)
    if not callable(thing):
        raise InvalidInput(
            field,
            reference,
            f"{name} must have a class or function of the name {attribute}",
            f"It has {_names(module)}.",
        )
    if field.endswith("class") and not inspect.isclass(thing):
        raise InvalidInput(
            field,
            reference,
            "a class is needed, of which every trial makes its own agent",
            "Write the agent as a class with __init__(self, seed, ...) and __call__.",
        )
    return Program(field, reference, thing, file, options)


def _module(field: str, reference: str, name: str, folder: Path | None) -> ModuleType:
    file = None if folder is None else folder / f"{name}.py"
    try:
        with _beside(folder):
            if file is None or not file.is_file():
                return importlib.import_module(name)
            # read anew each time: the file may have been edited since, or be another study's
            spec = importlib.util.spec_from_file_location(name, file)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            with _known_as(name, module):
                spec.loader.exec_module(module)
            return module
    except ModuleNotFoundError as missing:
        if missing.name != name.split(".")[0]:
            raise _raised(field, reference, missing, file) from missing
        places = "where Python looks for modules"
        if folder is not None:
            places = f"beside the study file ({folder}) or {places}"
        raise InvalidInput(
            field, reference, f"a module {name} must be found {places}", f"Put {name}.py there."
        ) from None
    except _RAISED as trouble:
        raise _raised(field, reference, trouble, file) from trouble


def _raised(field: str, reference: str, trouble: BaseException, file: Path | None) -> ProgramFailed:
    return ProgramFailed(
        field,
        reference,
        f"its module must load, and it raised {_told(trouble, file)}",
        "Mend the module.",
    )


def _names(module: ModuleType) -> str:
    own = [
        name
        for name, thing in vars(module).items()
        if callable(thing) and getattr(thing, "__module__", None) == module.__name__
    ]
    return ", ".join(sorted(own)[:8]) or "none"


@contextmanager
def _beside(folder: Path | None) -> Iterator[None]:
    """Let modules that stand beside the study file import each other."""
    if folder is None:
        yield
        return
    place = str(folder.resolve())
    sys.path.insert(0, place)
    try:
        yield
    finally:
        sys.path.remove(place)


@contextmanager
def _known_as(name: str, module: ModuleType) -> Iterator[None]:
    """Let a module find itself while it is read, as dataclasses do, and leave others' names alone."""
    before = sys.modules.get(name)
    sys.modules[name] = module
    try:
        yield
    finally:
        if before is None:
            del sys.modules[name]
        else:
            sys.modules[name] = before


def _told(trouble: BaseException, file: Path | None) -> str:
    """Tell an exception with the place in the user's file where it was raised."""
    frames = traceback.extract_tb(trouble.__traceback__)
    own = [frame for frame in frames if file is not None and Path(frame.filename) == file] or frames
    place = f" ({Path(own[-1].filename).name}, line {own[-1].lineno}, in {own[-1].name})" if own else ""
    return f"{type(trouble).__name__}: {trouble}{place}"


def _force(program: Program, seed: int, stop: Event) -> Force:
    try:
        agent = program.thing(seed=seed, **program.options)
    except _RAISED as trouble:
        options = ", ".join(["seed", *program.options])
        raise program.failed(
            f"the class must accept {options} by name, and it raised {_told(trouble, program.file)}"
        ) from trouble

    def force(
        time: float, position: FloatArray, velocity: FloatArray, target: FloatArray
    ) -> tuple[float, float]:
        if stop.is_set():
            raise Stopped
        try:
            given = agent(time, position, velocity, target)
        except _RAISED as trouble:
            raised = _told(trouble, program.file)
            raise program.failed(
                f"an agent must not raise, and it raised {raised} at t = {time:.6g} s"
            ) from trouble
        try:
            x, y = map(float, given)
        except (TypeError, ValueError):
            x = y = np.nan
        if not (np.isfinite(x) and np.isfinite(y)):
            raise program.failed(
                "an agent must return its force as two finite numbers (x, y) in N, and it returned "
                f"{given!r} at t = {time:.6g} s"
            )
        return x, y

    return force


def _positions(program: Program, times: FloatArray) -> FloatArray:
    try:
        given = program.thing(times.copy(), **program.options)
    except _RAISED as trouble:
        raise program.failed(
            f"a target must not raise, and it raised {_told(trouble, program.file)}"
        ) from trouble
    try:
        found = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (len(times), 2):
        shape = np.shape(given) if isinstance(given, (np.ndarray, Sequence)) else type(given).__name__
        raise program.failed(
            f"a target must return a position (x, y) for each of the {len(times)} times, shape "
            f"({len(times)}, 2), and it returned {shape}"
        )
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if bad.size:
        raise program.failed(f"a target must be finite, and it is not at t = {times[bad[0]]:.6g} s")
    far = np.flatnonzero(np.abs(found).max(axis=1) > _FARTHEST_TARGET)
    if far.size:
        raise program.failed(
            f"a target must stay within {_FARTHEST_TARGET:g} m, and it does not at t = {times[far[0]]:.6g} s "
            f"(are these millimetres?)"
        )
    speed = np.hypot(*(np.diff(found, axis=0) / np.diff(times)[:, None]).T)
    fast = np.flatnonzero(speed > _FASTEST_TARGET)
    if fast.size:
        raise program.failed(
            f"a target must not move faster than {_FASTEST_TARGET:g} m/s, and it moves at "
            f"{speed[fast[0]]:.4g} m/s at t = {times[fast[0]]:.6g} s (a jump, or millimetres?)"
        )
    return found
