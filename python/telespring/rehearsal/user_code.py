"""Agents and targets that a user wrote in Python: loaded, called, and checked."""

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
from typing import Any, TypeAlias

import numpy as np

from telespring._core import Experiment, trial_seed
from telespring._errors import InvalidInput
from telespring._types import FloatArray

__all__ = ["AgentCallable", "RehearsalStopped", "UserCode", "UserCodeError", "load_user_code"]

AgentCallable: TypeAlias = Callable[[float, FloatArray, FloatArray, FloatArray], tuple[float, float]]
AgentPair: TypeAlias = tuple[AgentCallable | None, AgentCallable | None]

#: m/s; no hand follows a faster target, and a target in millimetres is faster.
_FASTEST_TARGET = 10.0
#: m; a target in millimetres that hardly moves is farther away.
_FARTHEST_TARGET = 10.0

_AGENT_CONTRACT = (
    "An agent is called as agent(time, position, velocity, target) in s, m, m/s and m, and returns its "
    "force (x, y) in N."
)
_TARGET_CONTRACT = (
    "A target is called as target(times) in s, with the study's options by name, and returns positions of "
    "shape (n, 2) in m."
)

#: Exceptions of user code. sys.exit in an agent must not end the rehearsal as if it had succeeded.
_EXCEPTIONS = (Exception, SystemExit)


class RehearsalStopped(Exception):
    """A trial was abandoned because the rehearsal stops."""


class UserCodeError(InvalidInput):
    """User code raised an exception, or returned an invalid force or target."""


@dataclass(frozen=True)
class UserObject:
    """A class or function that a study names as "module:name".

    Attributes
    ----------
    field
        Where the study names it, such as ``agent1.class``.
    reference
        As the study names it.
    function
        The class or function.
    file
        The file that defines it.
    options
        Further arguments, from the study.
    """

    field: str
    reference: str
    function: Callable[..., Any]
    file: Path | None
    options: Mapping[str, Any]

    def provenance(self) -> dict[str, str]:
        """Return name and SHA-256 of the user's file, on which the numbers depend."""
        content = self.file.read_bytes() if self.file is not None else b""
        return {"name": self.reference, "sha256": hashlib.sha256(content).hexdigest()}

    def error(self, problem: str) -> UserCodeError:
        where = self.file.name if self.file else "its module"
        contract = _TARGET_CONTRACT if self.field == "task.function" else _AGENT_CONTRACT
        return UserCodeError(self.field, self.reference, problem, f"Correct it in {where}. {contract}")


@dataclass(frozen=True)
class UserCode:
    """The parts of an experiment that are written in Python.

    Attributes
    ----------
    agents
        The classes of both agents; None for an agent of the laboratory.
    target
        The function of the target, or None.
    """

    agents: tuple[UserObject | None, UserObject | None]
    target: UserObject | None

    @property
    def has_agents(self) -> bool:
        """Whether an agent is written in Python."""
        return self.agents != (None, None)

    def provenance(self) -> dict[str, dict[str, str]]:
        """Return name and SHA-256 of each agent and target program, by its place in the study."""
        parts = {"agent1": self.agents[0], "agent2": self.agents[1], "task": self.target}
        return {place: part.provenance() for place, part in parts.items() if part is not None}

    def create_agents(self, seed: int, stop: Event) -> AgentPair | None:
        """Create the agents of one trial, each with its own seed; None if there are none."""
        if not self.has_agents:
            return None
        first, second = (
            None if agent is None else _create_user_agent(agent, trial_seed(seed, robot, 0), stop)
            for robot, agent in enumerate(self.agents)
        )
        return first, second

    def target_positions(self, ticks: int, sample_period: float) -> FloatArray | None:
        """Compute the user's target at every tick, m; None if it is not written in Python."""
        if self.target is None:
            return None
        return _checked_user_target(self.target, sample_period * np.arange(ticks + 1, dtype=np.float64))


def load_user_code(experiment: Experiment, folder: Path | None) -> UserCode:
    """Load the Python classes and functions of an experiment, from the study's folder or as installed.

    InvalidInput where a module or a name in it is missing; UserCodeError where a module raises an exception.
    """
    modules: dict[str, ModuleType] = {}
    first, second = (
        None
        if agent.class_ is None
        else _load_user_object(f"agent{robot}.class", agent.class_, agent.options or {}, folder, modules)
        for robot, agent in enumerate(experiment.agents, start=1)
    )
    task = experiment.task
    target = (
        None
        if task.function is None
        else _load_user_object("task.function", task.function, task.options or {}, folder, modules)
    )
    return UserCode((first, second), target)


def _load_user_object(
    field: str,
    reference: str,
    options: Mapping[str, Any],
    folder: Path | None,
    modules: dict[str, ModuleType],
) -> UserObject:
    """Load the object of a reference; `modules` holds the modules that are loaded already."""
    name, _, attribute = reference.partition(":")
    if name not in modules:
        modules[name] = _load_user_module(field, reference, name, folder)
    module = modules[name]
    file = None if module.__file__ is None else Path(module.__file__)
    function: Any = module
    for part in attribute.split("."):
        function = getattr(function, part, None)
    if not callable(function):
        raise InvalidInput(
            field,
            reference,
            f"{name} must have a class or function named {attribute}",
            f"It has {_callables_of_user_module(module)}.",
        )
    if field.endswith("class") and not inspect.isclass(function):
        raise InvalidInput(
            field,
            reference,
            "a class is required, from which every trial creates its own agent",
            "Write the agent as a class with __init__(self, seed, ...) and __call__.",
        )
    return UserObject(field, reference, function, file, options)


def _load_user_module(field: str, reference: str, name: str, folder: Path | None) -> ModuleType:
    file = None if folder is None else folder / f"{name}.py"
    try:
        with _user_folder_on_path(folder):
            if file is None or not file.is_file():
                return importlib.import_module(name)
            # Reloaded each time: the file may have been edited, or belong to another study.
            spec = importlib.util.spec_from_file_location(name, file)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            with _registered_user_module(name, module):
                spec.loader.exec_module(module)
            return module
    except ModuleNotFoundError as missing:
        if missing.name != name.split(".")[0]:
            raise _user_loading_error(field, reference, missing, file) from missing
        places = "on Python's module path"
        if folder is not None:
            places = f"in the folder of the study file ({folder}) or {places}"
        raise InvalidInput(
            field, reference, f"a module {name} must exist {places}", f"Put {name}.py there."
        ) from None
    except _EXCEPTIONS as error:
        raise _user_loading_error(field, reference, error, file) from error


def _user_loading_error(field: str, reference: str, error: BaseException, file: Path | None) -> UserCodeError:
    return UserCodeError(
        field,
        reference,
        f"its module must load, but it raised {_describe_user_exception(error, file)}",
        "Correct the module.",
    )


def _callables_of_user_module(module: ModuleType) -> str:
    names = [
        name
        for name, member in vars(module).items()
        if callable(member) and getattr(member, "__module__", None) == module.__name__
    ]
    return ", ".join(sorted(names)[:8]) or "none"


@contextmanager
def _user_folder_on_path(folder: Path | None) -> Iterator[None]:
    """Let modules in the folder of the study file import each other."""
    if folder is None:
        yield
        return
    entry = str(folder.resolve())
    sys.path.insert(0, entry)
    try:
        yield
    finally:
        sys.path.remove(entry)


@contextmanager
def _registered_user_module(name: str, module: ModuleType) -> Iterator[None]:
    """Register a module while it is loaded, as dataclasses need, and then restore any other of its name."""
    before = sys.modules.get(name)
    sys.modules[name] = module
    try:
        yield
    finally:
        if before is None:
            del sys.modules[name]
        else:
            sys.modules[name] = before


def _describe_user_exception(error: BaseException, file: Path | None) -> str:
    """Describe an exception with the line of the user's code where it was raised, if it was raised there."""
    if isinstance(error, SyntaxError) and error.filename is not None:
        place = f" ({Path(error.filename).name}, line {error.lineno})"
        return f"{type(error).__name__}: {error.msg}{place}"
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__) if not _is_internal(frame.filename)
    ]
    own = [frame for frame in frames if file is not None and Path(frame.filename) == file] or frames
    place = f" ({Path(own[-1].filename).name}, line {own[-1].lineno}, in {own[-1].name})" if own else ""
    return f"{type(error).__name__}: {error}{place}"


def _is_internal(file: str) -> bool:
    """Whether a frame is of this package or of the import system, in which a user has nothing to correct."""
    return (
        file == __file__
        or file.startswith("<frozen ")
        or Path(file).parent == Path(importlib.__file__).parent
    )


def _create_user_agent(user_class: UserObject, seed: int, stop: Event) -> AgentCallable:
    try:
        agent = user_class.function(seed=seed, **user_class.options)
    except _EXCEPTIONS as error:
        options = ", ".join(["seed", *user_class.options])
        raised = _describe_user_exception(error, user_class.file)
        raise user_class.error(f"the class must accept {options} by name, but it raised {raised}") from error

    def checked_force(
        time: float, position: FloatArray, velocity: FloatArray, target: FloatArray
    ) -> tuple[float, float]:
        if stop.is_set():
            raise RehearsalStopped
        try:
            force = agent(time, position, velocity, target)
        except _EXCEPTIONS as error:
            raised = _describe_user_exception(error, user_class.file)
            raise user_class.error(
                f"an agent must not raise exceptions, but it raised {raised} at t = {time:.6g} s"
            ) from error
        try:
            x, y = map(float, force)
        except (TypeError, ValueError):
            x = y = np.nan
        if not (np.isfinite(x) and np.isfinite(y)):
            raise user_class.error(
                "an agent must return its force as two finite numbers (x, y) in N, but it returned "
                f"{force!r} at t = {time:.6g} s"
            )
        return x, y

    return checked_force


def _checked_user_target(target: UserObject, times: FloatArray) -> FloatArray:
    try:
        returned = target.function(times.copy(), **target.options)
    except _EXCEPTIONS as error:
        raised = _describe_user_exception(error, target.file)
        raise target.error(f"a target must not raise exceptions, but it raised {raised}") from error
    try:
        positions = np.array(returned, dtype=np.float64)
    except (TypeError, ValueError):
        positions = np.empty(0)
    if positions.shape != (len(times), 2):
        is_array = isinstance(returned, (np.ndarray, Sequence))
        shape = np.shape(returned) if is_array else type(returned).__name__
        raise target.error(
            f"a target must return a position (x, y) for each of the {len(times)} times, shape "
            f"({len(times)}, 2), but it returned {shape}"
        )
    undefined = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if undefined.size:
        raise target.error(f"a target must be finite, but it is not at t = {times[undefined[0]]:.6g} s")
    too_far = np.flatnonzero(np.abs(positions).max(axis=1) > _FARTHEST_TARGET)
    if too_far.size:
        raise target.error(
            f"a target must stay within {_FARTHEST_TARGET:g} m, but it does not at "
            f"t = {times[too_far[0]]:.6g} s (are these millimetres?)"
        )
    speed = np.hypot(*(np.diff(positions, axis=0) / np.diff(times)[:, None]).T)
    too_fast = np.flatnonzero(speed > _FASTEST_TARGET)
    if too_fast.size:
        raise target.error(
            f"a target must not move faster than {_FASTEST_TARGET:g} m/s, but it moves at "
            f"{speed[too_fast[0]]:.4g} m/s at t = {times[too_fast[0]]:.6g} s (a jump, or millimetres?)"
        )
    return positions
