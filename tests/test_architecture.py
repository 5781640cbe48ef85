"""The walls between the rooms of the package: each contract of `make lint` fails where it should."""

from __future__ import annotations

import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

#: A line that must not stand in a file of the package, and the contract that forbids it.
VIOLATIONS = {
    "up": ("theory/criteria.py", "from telespring.decision import decide", "Imports go down"),
    "sideways": ("study/target.py", "from telespring.theory import criteria", "Imports go down"),
    "for types only": (
        "_types.py",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from telespring.show import figures",
        "Imports go down",
    ),
    "a room without a floor": ("cellar.py", "", "Imports go down"),
    "a circle": (
        "analysis/statistics.py",
        "def f():\n    from telespring.analysis import results",
        "No import cycles",
    ),
    "theory in an analysis": (
        "analysis/measures.py",
        "from telespring.theory import spectrum",
        "Rehearsal and analysis take their dyad from the study",
    ),
    "a rehearsal in a decision": (
        "decision/decide.py",
        "from telespring.rehearsal import run",
        "A decision uses nothing of a rehearsal",
    ),
    "a drawing job": ("analysis/table.py", "import matplotlib.pyplot", "Jobs draw nothing"),
    "a figure that asks": (
        "show/figures/maps.py",
        "from telespring.theory import verdicts",
        "Figures take plain numbers",
    ),
    "a parser": ("analysis/sources.py", "import tomllib", "A study is queried through its getters"),
}


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Check the package in a folder against the contracts in the same folder."""
    return subprocess.run(
        [Path(sys.executable).parent / "lint-imports", "--no-cache", "--no-logo"],
        cwd=folder,
        env={"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def package(root: Path, tmp_path: Path) -> Path:
    """Copy the package's Python files, to be spoilt."""
    shutil.copytree(
        root / "python" / "telespring",
        tmp_path / "telespring",
        ignore=shutil.ignore_patterns("*.so", "__pycache__"),
    )
    shutil.copy(root / "pyproject.toml", tmp_path)
    return tmp_path


def test_law_the_package_keeps_its_contracts(package: Path) -> None:
    checked = lint_imports(package)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("what", VIOLATIONS)
def test_law_a_violation_breaks_its_contract(what: str, package: Path) -> None:
    file, line, contract = VIOLATIONS[what]
    with (package / "telespring" / file).open("a", encoding="utf-8") as module:
        module.write(f"\n{line}\n")
    checked = lint_imports(package)
    assert checked.returncode == 1, checked.stdout
    [broken] = [row for row in checked.stdout.splitlines() if row.startswith(contract) and "BROKEN" in row]
    assert broken


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ("import telespring as ts", [1]),
        ("def f():\n    import telespring", [2]),
        ("from telespring import Dyad", [1]),
        ("from telespring import _core, Dyad", [1]),
        ("from . import model", [1]),
        ('"""\n>>> import telespring as ts\n"""', []),
        ("from telespring import _core, analysis\nfrom telespring.model import Dyad", []),
        ("import telespring.model", []),
    ],
)
def test_law_no_module_imports_the_whole_package(source: str, lines: list[int], root: Path) -> None:
    check = runpy.run_path(str(root / "tools" / "check_imports.py"))
    assert list(check["imports_of_the_package"](source)) == lines
    assert check["main"]() == 0
