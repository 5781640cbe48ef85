"""The interactive page inside of the report."""

from __future__ import annotations

import base64
import gzip
import re
from pathlib import Path
from typing import Any

import pytest

import telespring as ts
from browser import hear, look, needs_chromium
from telespring.app import page as carried
from telespring.paper import analyse
from telespring.paper import page as report_page
from telespring.paper.sections.explore.section import SECTION

needs_page = pytest.mark.skipif(not carried.is_carried(), reason="NO PAGE HERE: 'make page' builds it")

STUDY = ts.Study.paper().replace(coupling={"stiffness": 60.0}, network={"delay": 0.05})


def report(study: ts.Study = STUDY) -> str:
    return analyse(study, parts=[SECTION]).html


@needs_page
def test_law_the_report_carries_the_page_with_its_study() -> None:
    packed = re.search(r'<script type="text/plain" id="explore-page">([A-Za-z0-9+/=]+)</script>', report())
    assert packed is not None
    page = gzip.decompress(base64.b64decode(packed[1])).decode()
    assert carried.address_part(STUDY) in page
    assert report() == report()


def test_law_without_the_page_the_report_has_no_such_section(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(carried, "_file", lambda: Path("nowhere.html"))
    page = report()
    assert 'id="explore"' not in page
    assert "explore-page" not in page


@needs_page
def test_law_a_long_report_stays_small_and_says_where_the_page_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_page, "MOST_BYTES", 100_000)
    page = report()
    assert len(page) < 100_000
    assert 'id="explore"' in page
    assert "explore-page" not in page
    assert "<code>telespring explore</code>" in page


#: Opens the page, and hears from it which study it shows.
OPEN = """<script>
addEventListener("message", event => event.data.telespring === "study" && report(event.data.study));
document.getElementById("explore-open").click();
</script>"""


@needs_page
@needs_chromium
def test_law_the_page_opens_in_the_report_with_its_study(tmp_path: Path) -> None:
    shown: Any = hear(report(), OPEN, tmp_path)
    assert ts.Study.from_toml(shown) == STUDY
    # nothing of it is there before it is asked for
    frames = "<script>report(document.querySelectorAll('iframe').length)</script>"
    assert look(report(), frames, tmp_path) == 0
