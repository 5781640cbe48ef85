"""The benchmarks still run; nothing here asserts a time."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

# peers that `make bench` installs and `make test` does not
PEERS = {
    "numba": "numba RK4",
    "jitcdde": "jitcdde",
    "scipy": "scipy DOP853 by steps",
    "ddeint": "ddeint",
    "tdcpy": "tdcpy",
    "qpmr": "qpmr, region given",
    "control": "python-control stability_margins",
    "yaltapy": "yaltapy stability windows",
}
PROGRAM = Path("benches/rust/target/release/telespring-bench")


@pytest.fixture(scope="module")
def content(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return what a quick run wrote, with the Rust program only where it is built."""
    output = tmp_path_factory.mktemp("bench") / "bench.json"
    command = [sys.executable, "benches/run.py", "--quick", "--no-build", "--output", str(output)]
    ended = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr[-4000:]
    assert not output.with_name(output.name + ".partial").exists()
    found: dict[str, Any] = json.loads(output.read_text(encoding="utf-8"))
    return found


def test_cross_our_own_lines_are_there_and_accurate(content: dict[str, Any]) -> None:
    """A simulation is within the accuracy that `simulate` promises of an unrelated method."""
    ours = {row["name"]: row for row in content["rows"] if row["ours"]}
    for name in ("ours: Python simulate_array, positions", "ours: Python spectral_abscissa"):
        assert ours[name]["error"] <= 1e-11


@pytest.mark.parametrize("peer", PEERS)
def test_law_a_peer_is_measured(content: dict[str, Any], peer: str) -> None:
    """Each peer that is installed answers; one that is not has a line that says so."""
    lines = [row for row in content["rows"] if row["name"].startswith(PEERS[peer])]
    assert lines
    notes = " ".join(row["note"] for row in lines)
    if "not installed" in notes:
        pytest.skip(f"{peer} is not installed; `make .venv/.stamps/oracles` installs it")
    assert "failed" not in notes
    assert all(row["timing"]["median"] > 0 for row in lines)


def test_cross_the_rust_program_is_measured(content: dict[str, Any], root: Path) -> None:
    """Its lines meet their accuracy; their times are not looked at."""
    if not (root / PROGRAM).exists():
        pytest.skip(f"{PROGRAM} is not built; `make bench` builds it")
    lines = [row for row in content["rows"] if row["target_error"] is not None]
    assert lines
    assert all(row["error"] <= row["target_error"] for row in lines)


@pytest.mark.parametrize("workspace", ["benches/rust", "fuzz"])
def test_law_locks_outside_the_workspace_know_every_crate_of_the_core(root: Path, workspace: str) -> None:
    """Both build with --locked, and nothing else here builds them."""
    declared = tomllib.loads((root / "crates" / "telespring" / "Cargo.toml").read_text(encoding="utf-8"))
    needed = {name for name, entry in declared["dependencies"].items() if not entry.get("optional", False)}
    lock = tomllib.loads((root / workspace / "Cargo.lock").read_text(encoding="utf-8"))
    core = next(package for package in lock["package"] if package["name"] == "telespring")
    locked = {str(each).split()[0] for each in core["dependencies"]}
    assert needed <= locked, f"{workspace}/Cargo.lock is stale: run cargo update --workspace there"
