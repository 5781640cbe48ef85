"""The public surface: what is listed is there, documented, typed, and as the stub says."""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import get_overloads

import pytest

import telespring as ts

PUBLIC = [name for name in ts.__all__ if name != "__version__"]
FUNCTIONS = [name for name in PUBLIC if not inspect.isclass(getattr(ts, name))]

# Other tools are written against these; a change here is a breaking change.
PROMISED = {
    "critical_stiffness": "m1, b1, m2, b2, method, *, kh1, kh2, c",
    "maximum_delay": "m1, b1, m2, b2, k, method, *, kh1, kh2, c, predictor",
    "maximum_stiffness": "m1, b1, m2, b2, delay, *, kh1, kh2, c, predictor",
    "stable_delays": "m1, b1, m2, b2, k, horizon, *, kh1, kh2, c",
    "crossings": "m1, b1, m2, b2, k, *, kh1, kh2, c",
    "characteristic_roots": "dyad, stiffness, delay, count, axis",
    "spectral_abscissa": "dyad, stiffness, delay, axis",
    "unstable_root_count": "m1, b1, m2, b2, k, delay, *, kh1, kh2, c, predictor",
    "stability_map": "m1, b1, m2, b2, k, delay, *, kh1, kh2, c, predictor",
    "verdicts": "dyad, stiffness, delay, jitter, max_gap, sample_period, computing_time, operator_range, "
    "attack_seed",
    "transfer_matrix": "dyad, stiffness, delay, s, axis, convention",
    "mobility_matrix": "dyad, stiffness, delay, s, axis",
    "frequency_response": "dyad, stiffness, delay, frequency, axis, convention",
    "open_loop": "dyad, stiffness, delay, frequency, axis",
    "partner_response": "dyad, stiffness, delay, frequency, axis, robot",
    "frequency_grid": "dyad, stiffness, delay, low, high, axis, resolution, limit",
    "nyquist": "dyad, stiffness, delay, axis",
    "rehearse": "study, folder, progress, workers, *, fresh, executor, shard",
    "simulate": "dyad, stiffness, delay, forces, duration, rate, history",
    "solve_dde": "rhs, delays, history, t_span, rtol, atol, *, initial, breakpoints, max_steps, "
    "initial_step, max_step",
    "Robot": "mass, damping, axes",
    "Operator": "mass, damping, stiffness",
    "Dyad": "robot1, robot2, operators, coupling_damping",
    "hman": "",
    "Coupling": "stiffness, damping",
    "Network": "delay, jitter, max_gap, sample_period, computing_time",
    "OperatorRange": "low, high",
    "DelaySystem": "a0, delayed",
}


def parameters(name: str) -> list[str]:
    signature = inspect.signature(getattr(ts, name))
    found: list[str] = []
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in found:
            found.append("*")
        found.append(parameter.name)
    return found


@pytest.mark.parametrize("name", ["compare", "rehearse", "sweep"])
def test_law_overloads_have_the_arguments_and_defaults_of_their_function(name: str) -> None:
    """They differ in `shard` and in what is returned; mypy compares the types, but no defaults."""
    function = getattr(ts, name)

    def arguments(signature: inspect.Signature) -> list[tuple[object, ...]]:
        found = signature.parameters.values()
        return [(each.name, each.kind, each.default) for each in found if each.name != "shard"]

    overloads = get_overloads(function)
    assert len(overloads) == 2
    for each in overloads:
        assert arguments(inspect.signature(each)) == arguments(inspect.signature(function))


@pytest.mark.parametrize("name", PROMISED)
def test_ref_promised_signatures_hold(name: str) -> None:
    assert ", ".join(parameters(name)) == PROMISED[name]


def test_law_the_list_is_sorted_and_complete() -> None:
    assert sorted(ts.__all__) == ts.__all__
    assert all(hasattr(ts, name) for name in ts.__all__)


@pytest.mark.parametrize("name", PUBLIC)
def test_law_everything_public_is_documented(name: str) -> None:
    thing = getattr(ts, name)
    text = inspect.getdoc(thing)
    assert text, f"{name} has no docstring"
    if name not in FUNCTIONS:
        return
    assert "Returns\n---" in text
    assert ">>> " in text, f"{name} shows no example"
    for parameter in parameters(name):
        if parameter != "*":
            described = re.search(rf"^[\w, ]*\b{parameter}\b[\w, ]* :", text, re.MULTILINE)
            assert described, f"{name} does not describe {parameter}"


def test_law_the_stub_is_what_was_compiled(root: Path) -> None:
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "mypy.stubtest",
            "telespring._core",
            "--mypy-config-file",
            root / "pyproject.toml",
        ],
        cwd=root,
        env={**os.environ, "MYPYPATH": "python"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    "heavy",
    ["xarray", "pandas", "matplotlib", "h5netcdf", "scipy", "telespring.rehearsal", "telespring.traces"],
)
def test_law_importing_the_package_loads_nothing_heavy(heavy: str) -> None:
    code = f"import sys, telespring; sys.exit({heavy!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_law_no_copyleft_program_is_imported_by_the_package() -> None:
    for path in Path(ts.__file__).parent.rglob("*.py"):
        found = re.search(
            r"^\s*(?:import|from)\s+(tdcpy|qpmr|yaltapy)\b", path.read_text(encoding="utf-8"), re.M
        )
        assert found is None, path.name
