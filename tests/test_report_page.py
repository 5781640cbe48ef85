"""The report as a browser lays it out: no table is wider than the page, on a screen and on paper."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from telespring.paper import Analysis

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

#: Writes the names of the tables that stick out into the page's title, where the shell can read them.
MEASURE = """<script>
document.title = JSON.stringify([...document.querySelectorAll("table")].map(
  table => [table.id || table.innerText.slice(0, 40), table.getBoundingClientRect().right
            - table.parentElement.getBoundingClientRect().right]));
</script>"""


@pytest.mark.skipif(CHROMIUM is None, reason="NO CHROMIUM HERE: nobody has seen whether the tables fit")
# 718 px: A4 without the browser's margins of 1 cm, laid out by the rules for print
@pytest.mark.parametrize(("width", "medium"), [(1000, "screen"), (718, "print")])
def test_law_no_table_is_wider_than_the_page(
    analysis: Analysis, width: int, medium: str, tmp_path: Path
) -> None:
    page = analysis.html.replace("<details>", "<details open>").replace("</body>", f"{MEASURE}</body>")
    if medium == "print":
        assert "@media print" in page
        page = page.replace("@media print", "@media all")
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-background-networking", "--disable-gpu"]
    shown = subprocess.run(
        [
            str(CHROMIUM),
            *options,
            f"--user-data-dir={tmp_path / 'profile'}",
            f"--window-size={width},1000",
            "--dump-dom",
            (tmp_path / "page.html").as_uri(),
        ],
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    ).stdout
    title = re.search(r"<title>(.*?)</title>", shown, re.S)
    assert title is not None
    measured = json.loads(html.unescape(title[1]))
    assert len(measured) > 10
    # half a pixel: widths are rounded
    assert [name for name, beyond in measured if beyond > 0.5] == []
