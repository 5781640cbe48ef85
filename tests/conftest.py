"""What several tests share."""

from __future__ import annotations

import os

# Before NumPy is loaded: on cores that others use too, OpenBLAS' threads wait for each other, and the
# eigenvalues of a hundred rows take seconds instead of milliseconds.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

import telespring as ts

ROOT = Path(__file__).resolve().parent.parent

# A failure found here must be found everywhere: generated cases are the same on every machine, and
# no case fails for being slow.
settings.register_profile("telespring", derandomize=True, deadline=None)
settings.load_profile("telespring")


@pytest.fixture(scope="session")
def root() -> Path:
    """Return the repository's folder."""
    return ROOT


@pytest.fixture
def hman() -> ts.Dyad:
    """Return the paper's two robots."""
    return ts.hman()


@pytest.fixture(scope="session")
def du2025() -> dict[str, Any]:
    """Return the numbers that the paper prints."""
    return tomllib.loads((ROOT / "references" / "du2025.toml").read_text(encoding="utf-8"))
