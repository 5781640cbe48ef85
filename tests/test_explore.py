"""The page that the package carries: opened by the command, and in a notebook."""

from __future__ import annotations

import base64
import re
import webbrowser
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import telespring as ts
from telespring.app.page import address_part, is_carried, page_with, ready_study
from telespring.cli import app

needs_page = pytest.mark.skipif(not is_carried(), reason="NO PAGE HERE: 'make page' builds it")
needs_anywidget = pytest.mark.skipif(
    find_spec("anywidget") is None, reason="NO ANYWIDGET HERE: the page in a notebook is untested"
)

ROBOTS = ["--robot", "1.2,6", "--robot", "2,9"]


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["explore", *arguments])


def study_in(page: str) -> ts.Study:
    """Return the study that a page opens with."""
    written = re.search(r'<script type="text/plain" id="study">study=([A-Za-z0-9_-]+)</script>', page)
    assert written is not None
    text = written[1] + "=" * (-len(written[1]) % 4)
    return ts.Study.from_toml(base64.urlsafe_b64decode(text).decode())


@needs_page
def test_law_the_page_opens_with_the_study_of_the_command(tmp_path: Path) -> None:
    done = run(*ROBOTS, "--ping", "80ms", "--stiffness", "150", "--save", str(tmp_path / "page.html"))
    assert done.exit_code == 0, done.output
    study = study_in((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert (study.stiffness, study.delay) == (150.0, (0.04, 0.04))
    assert study.dyad == ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))


@needs_page
def test_law_the_browser_gets_a_file_and_no_server(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []

    def open_address(address: str) -> bool:
        opened.append(address)
        return True

    monkeypatch.setattr(webbrowser, "open", open_address)
    done = run()
    assert done.exit_code == 0, done.output
    [address] = opened
    assert address.startswith("file://")
    study = study_in(Path(address.removeprefix("file://")).read_text(encoding="utf-8"))
    assert study.dyad == ts.hman()
    # what a study leaves open the page fills in, and says so
    assert not study.has_stiffness
    assert not study.has_delay


def test_law_a_name_cannot_leave_its_place_in_the_page() -> None:
    study = ts.Study.paper().replace(name="</script><script>alert(1)</script><!--")
    page = page_with(study, page="<body><!-- STUDY --></body>")
    assert page.count("<script") == page.count("</script>") == 1
    assert study_in(page) == study


def test_law_a_refused_file_is_named() -> None:
    done = run("nowhere.toml")
    assert done.exit_code == 2
    assert "nowhere.toml" in done.output


def test_law_a_study_keeps_its_own_values() -> None:
    study = ts.Study.paper()
    assert ready_study(study) is study
    assert address_part(study).startswith("study=")


@needs_page
@needs_anywidget
def test_law_the_page_in_a_notebook_and_python_show_the_same_study() -> None:
    shown = ts.explore(ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0)), 150.0, 0.04)
    assert (shown.study.stiffness, shown.study.delay) == (150.0, (0.04, 0.04))
    assert study_in(shown._page) == shown.study  # what the frame opens with is sent once
    # the page tells
    shown.toml = shown.study.replace(coupling={"stiffness": 90.0}).to_toml()
    assert shown.study.stiffness == 90.0
    # Python tells, and the trait that the page follows changes
    heard: list[str] = []
    shown.observe(lambda change: heard.append(change["new"]), "toml")
    shown.study = shown.study.replace(coupling={"stiffness": 80.0})
    assert len(heard) == 1
    assert ts.Study.from_toml(heard[0]).stiffness == 80.0


@needs_page
def test_law_without_anywidget_the_remedy_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    from telespring.app import widget

    monkeypatch.setitem(sys.modules, "anywidget", None)
    widget._widget_class.cache_clear()  # private: another test may have found it
    with pytest.raises(ts.InvalidInput, match=r"telespring\[jupyter\]"):
        ts.explore()


@pytest.mark.parametrize("subject", [3, "hman", [1.0]])
def test_law_what_is_no_dyad_and_no_study_is_refused(subject: Any) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        ts.explore(subject)
    assert refused.value.field == "subject"
