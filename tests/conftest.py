"""What several tests share."""

from __future__ import annotations

import os

# Before NumPy is loaded: on cores that others use too, OpenBLAS' threads wait for each other, and the
# eigenvalues of a hundred rows take seconds instead of milliseconds.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from typer.testing import CliRunner

import telespring as ts
from paper_study import HELD, PaperStudy
from telespring.cli import app
from telespring.connection.program import find_program
from telespring.paper import Analysis, analyse
from telespring.references import read_reference

ROOT = Path(__file__).resolve().parent.parent

# A failure found here must be found everywhere: generated cases are the same on every machine, and
# no case fails for being slow. `make verify` draws new ones from the seed that it puts into
# TELESPRING_VERIFY, and more of them.
DRAWN_SEED = os.environ.get("TELESPRING_VERIFY")
settings.register_profile("telespring", derandomize=True, deadline=None)
settings.register_profile("verify", derandomize=False, deadline=None, max_examples=2000, print_blob=True)
settings.load_profile("telespring" if DRAWN_SEED is None else "verify")


def pytest_report_header() -> str:
    """Say which generated cases these are, so that a failure can be repeated."""
    if DRAWN_SEED is None:
        return "generated cases: the same on every machine"
    return f"generated cases: drawn from {DRAWN_SEED}; repeat them by `make verify SEED={DRAWN_SEED}`"


@pytest.fixture(scope="session")
def root() -> Path:
    """Return the repository's folder."""
    return ROOT


@pytest.fixture(scope="session")
def live_program() -> Path:
    """Return the live program, which `make test-link` builds; skip where there is none."""
    try:
        return find_program()
    except ts.InvalidInput as refused:
        pytest.skip(f"NO LIVE PROGRAM HERE: {refused}")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give the tests that may have to run the whole study first more time: a core may be shared."""
    for item in items:
        if isinstance(item, pytest.Function) and "paper_study" in item.fixturenames:
            item.add_marker(pytest.mark.timeout(600))


@pytest.fixture(scope="session")
def paper_study(tmp_path_factory: pytest.TempPathFactory) -> PaperStudy:
    """Run the whole of the paper's study, by the command, once for all tests: it takes its time."""
    folder = tmp_path_factory.mktemp("paper") / "deep" / "study"
    runner = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"})
    return PaperStudy(runner.invoke(app, ["reproduce", "--out", str(folder)]), folder)


@pytest.fixture(scope="session")
def analysis(paper_study: PaperStudy) -> Analysis:
    """Return what the paper's study found."""
    assert paper_study.result.exit_code == 0, paper_study.result.output
    return Analysis(
        numbers=json.loads((paper_study.folder / "study.json").read_text(encoding="utf-8")),
        html=(paper_study.folder / "report.html").read_text(encoding="utf-8"),
    )


@pytest.fixture(scope="session")
def held() -> Analysis:
    """Return what a study finds in which every part of the network counts."""
    return analyse(ts.Study.from_toml(HELD))


@pytest.fixture
def hman() -> ts.Dyad:
    """Return the paper's two robots."""
    return ts.hman()


@pytest.fixture(scope="session")
def du2025() -> dict[str, Any]:
    """Return the numbers that the paper prints."""
    return read_reference("du2025")
