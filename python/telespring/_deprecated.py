"""Old names that keep working for one release, each with a DeprecationWarning that gives the new name.

Two tables say what moved: whole modules, and single names. Nothing new is imported until an old name is used.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

__all__ = ["MOVED_MODULES", "RENAMED", "old_names", "serve_moved_modules"]

#: Modules that the documentation of an earlier version names, and where their content is now.
MOVED_MODULES = {
    "telespring.arms_boundary": "telespring.paper.sections.arms.boundary",
    "telespring.calibration": "telespring.paper.calibration",
    "telespring.experiment": "telespring.rehearsal",
    "telespring.identify": "telespring.identification",
    "telespring.study_text": "telespring.study.robot_file",
}

#: Names that were renamed: the old full name, and the new one as "module:name".
RENAMED = {
    "telespring.experiment.Outcome": "telespring.rehearsal:RehearsalOutcome",
    "telespring.study_text.with_robot": "telespring.model:Study.with_robot",
    "telespring.analysis.target_of": "telespring.study.target:target_positions",
    "telespring.arms_boundary.draw": "telespring.paper.sections.arms.boundary:draw_arms_boundary",
    "telespring.analysis.take_trials": "telespring.analysis.trials:Trials.from_dataset",
}


def serve_moved_modules() -> None:
    """Let `import` find the modules that moved."""
    # First, because a folder left over from an earlier version would be found as an empty package.
    sys.meta_path.insert(0, _MovedModules())


def old_names(
    module: str, submodules: Sequence[str] = (), late: Mapping[str, str] | None = None
) -> Callable[[str], Any]:
    """Return a `__getattr__` for a module some of whose names or submodules have moved.

    `submodules` are imported when they are first used, and so are the modules of the names in `late`.

    Examples
    --------
    >>> old_names("telespring.analysis")("no_such_name")
    Traceback (most recent call last):
    ...
    AttributeError: module 'telespring.analysis' has no attribute 'no_such_name'
    """

    def get_old_name(name: str) -> Any:
        old = f"{module}.{name}"
        if name in submodules:
            return import_module(old)
        if late is not None and name in late:
            value = getattr(import_module(late[name]), name)
            setattr(sys.modules[module], name, value)
            return value
        if old in RENAMED:
            home, _, path = RENAMED[old].partition(":")
            _warn_of_old_path(old, f"{home}.{path}")
            return _moved_attribute(home, path)
        if old in MOVED_MODULES:
            _warn_of_old_path(old, MOVED_MODULES[old])
            moved = sys.modules[old] = ModuleType(old)
            _forward_old_module(moved)
            setattr(sys.modules[module], name, moved)
            return moved
        # Special names belong to the old module itself: with a __path__ it would be a package.
        if module in MOVED_MODULES and not name.startswith("__"):
            new = import_module(MOVED_MODULES[module])
            if hasattr(new, name):
                return getattr(new, name)
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return get_old_name


class _MovedModules(MetaPathFinder, Loader):
    """Import an old module as one that forwards to the new one."""

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname in MOVED_MODULES else None

    def create_module(self, _spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        _warn_of_old_path(module.__name__, MOVED_MODULES[module.__name__])
        _forward_old_module(module)


def _forward_old_module(module: ModuleType) -> None:
    """Let an old module forward every name to the new one."""
    old = module.__name__
    new = import_module(MOVED_MODULES[old])
    renamed = [name.removeprefix(f"{old}.") for name in RENAMED if name.startswith(f"{old}.")]
    module.__doc__ = new.__doc__
    vars(module)["__all__"] = [*getattr(new, "__all__", ()), *renamed]
    vars(module)["__getattr__"] = old_names(old)
    vars(module)["__dir__"] = lambda: [*vars(new), *renamed]


def _moved_attribute(home: str, path: str) -> Any:
    value: Any = import_module(home)
    for name in path.split("."):
        value = getattr(value, name)
    return value


def _warn_of_old_path(old: str, new: str) -> None:
    # At the caller's line; the frames of `import` itself do not count.
    warnings.warn(
        f"{old} is now {new}; the old name will be removed in the next release.",
        DeprecationWarning,
        stacklevel=3,
    )
