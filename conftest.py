"""What the examples in docstrings find beside the repository's files: the recording of a live session."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent / "tests"


@pytest.fixture(scope="session")
def folder_with_a_session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with `session.mcap`, both sites of a made session."""
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    import telespring as ts
    from made_session import write_session

    folder = tmp_path_factory.mktemp("session")
    ts.merge_recordings(*write_session(folder), out=folder / "session.mcap")
    return folder


@pytest.fixture(autouse=True)
def _session_for_docstrings(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run an example that reads the recording of a session where there is one."""
    node = request.node
    tests = node.dtest if isinstance(node, pytest.DoctestItem) else None
    if tests is not None and any('"session.mcap"' in example.source for example in tests.examples):
        monkeypatch.chdir(request.getfixturevalue("folder_with_a_session"))
