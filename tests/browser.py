"""A page in Chromium: loaded, asked by a script at its end, and what it says."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="NO CHROMIUM HERE: nobody has seen whether it can be read"
)

#: Writes a result into the page, where `--dump-dom` shows it.
REPORT = """<script>
function report(value) {
  const shown = document.createElement("pre");
  shown.id = "measured";
  shown.textContent = JSON.stringify(value);
  document.body.append(shown);
}
</script>"""


def look(page: str, script: str, folder: Path, width: int = 1000) -> Any:
    """Load the page in Chromium, run the script at its end, and return what it reports."""
    assert CHROMIUM is not None
    (folder / "page.html").write_text(page.replace("</body>", f"{REPORT}{script}</body>"), encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-background-networking", "--disable-gpu"]
    shown = subprocess.run(
        [
            CHROMIUM,
            *options,
            f"--user-data-dir={folder / 'profile'}",
            f"--window-size={width},1000",
            "--virtual-time-budget=60000",
            "--dump-dom",
            (folder / "page.html").as_uri(),
        ],
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    ).stdout
    measured = re.search(r'<pre id="measured">(.*?)</pre>', shown, re.S)
    assert measured is not None
    return json.loads(html.unescape(measured[1]))
