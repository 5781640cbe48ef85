"""Names that earlier documentation used: they work, warn once with the new name, and are the same objects."""

from __future__ import annotations

import subprocess
import sys
import warnings
from importlib import import_module

import pytest

import telespring
from telespring._deprecated import MOVED_MODULES, RENAMED

#: What README, docs and benchmarks named before the modules moved.
DOCUMENTED = {
    "telespring.arms_boundary": ["boundary_in_arms"],
    "telespring.calibration": ["calibrate"],
    "telespring.experiment": ["Outcome", "rehearse", "run_protocol"],
    "telespring.identify": ["design_excitation", "identify", "paper_excitation", "read_log", "write_robot"],
    "telespring.study_text": ["robot_record", "with_robot"],
}


@pytest.fixture(params=sorted(MOVED_MODULES))
def old(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name a moved module that was not imported yet."""
    name = str(request.param)
    monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.delitem(vars(telespring), name.removeprefix("telespring."), raising=False)
    return name


def test_law_every_documented_module_is_served() -> None:
    assert set(DOCUMENTED) == set(MOVED_MODULES)


def test_law_an_old_module_warns_once_and_gives_the_same_objects(old: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"{old} is now {MOVED_MODULES[old]};") as caught:
        exec(f"import {old}; import {old}", {})
    assert len(caught) == 1
    module = sys.modules[old]
    new = import_module(MOVED_MODULES[old])
    for name in DOCUMENTED[old]:
        home, _, path = RENAMED.get(f"{old}.{name}", f"{new.__name__}:{name}").partition(":")
        expected = import_module(home)
        for part in path.split("."):
            expected = getattr(expected, part)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore" if f"{old}.{name}" in RENAMED else "error")
            assert getattr(module, name) is expected
        assert name in module.__all__
    with pytest.raises(ImportError):
        exec(f"from {old} import no_such_name", {})


def test_law_the_warning_points_at_the_line_that_imports(old: str) -> None:
    with pytest.warns(DeprecationWarning, match=old) as caught:
        exec(compile(f"\n\nimport {old}", "user.py", "exec"), {})
    assert (caught[0].filename, caught[0].lineno) == ("user.py", 3)


def test_law_an_old_module_is_an_attribute_of_the_package(old: str) -> None:
    name = old.removeprefix("telespring.")
    with pytest.warns(DeprecationWarning, match=old) as caught:
        module = eval(compile(f"telespring.{name}", "user.py", "eval"), {"telespring": telespring})
    assert caught[0].filename == "user.py"
    assert module is sys.modules[old]
    assert module is getattr(telespring, name)


@pytest.mark.parametrize("old", RENAMED)
def test_law_a_renamed_name_gives_the_new_object(old: str) -> None:
    module, _, name = old.rpartition(".")
    home, _, path = RENAMED[old].partition(":")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        owner = import_module(module)
    with pytest.warns(DeprecationWarning, match=f"{old} is now {home}.{path};") as caught:
        value = getattr(owner, name)
    assert caught[0].filename == __file__
    expected = import_module(home)
    for part in path.split("."):
        expected = getattr(expected, part)
    assert value == expected


@pytest.mark.parametrize(
    "name", ["telespring.identity", "telespring.identify.estimation", "telespring.calibratoin"]
)
def test_law_a_module_that_never_existed_is_not_found(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        with pytest.raises(ModuleNotFoundError):
            import_module(f"telespring.{name}")
    with pytest.raises(AttributeError, match="no attribute 'calibratoin'"):
        telespring.calibratoin  # type: ignore[attr-defined]  # noqa: B018


def test_law_importing_the_package_imports_no_moved_module() -> None:
    """Nor does it warn."""
    code = (
        "import sys, telespring; from telespring._deprecated import MOVED_MODULES;"
        "sys.exit(any(name in sys.modules for name in [*MOVED_MODULES, 'telespring.identification',"
        " 'telespring.paper', 'telespring.study.robot_file']))"
    )
    assert subprocess.run([sys.executable, "-W", "error", "-c", code], check=False).returncode == 0
