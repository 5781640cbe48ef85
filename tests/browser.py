"""A page in Chromium: loaded, asked by a script at its end, and what it says, at once or later."""

from __future__ import annotations

import html
import http.server
import json
import os
import re
import shutil
import subprocess
import threading
from pathlib import Path
from typing import Any

import pytest

__all__ = ["REPORT", "find_chromium", "hear", "look", "needs_chromium"]


def find_chromium() -> str | None:
    """Return the file that CHROMIUM names, else the first of these on the PATH, as tools/chromium.mjs."""
    on_the_path = map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))
    return os.environ.get("CHROMIUM") or next(filter(None, on_the_path), None)


CHROMIUM = find_chromium()

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


OPTIONS = ["--headless", "--no-sandbox", "--disable-background-networking", "--disable-gpu"]


def look(page: str, script: str, folder: Path, width: int = 1000) -> Any:
    """Load the page in Chromium, run the script at its end, and return what it reports."""
    assert CHROMIUM is not None
    (folder / "page.html").write_text(page.replace("</body>", f"{REPORT}{script}</body>"), encoding="utf-8")
    shown = subprocess.run(
        [
            CHROMIUM,
            *OPTIONS,
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


#: Sends a value to the test, whenever it is there.
SEND = """<script>
function report(value) {
  fetch("/", { method: "POST", body: JSON.stringify(value) });
}
</script>"""


def hear(page: str, script: str, folder: Path) -> Any:
    """Load the page in Chromium, run the script at its end, and return the first value that it reports.

    No time is skipped, as `look` does: what frames inside of the page do counts.
    """
    assert CHROMIUM is not None
    text = page.replace("</body>", f"{SEND}{script}</body>").encode()
    heard: list[Any] = []
    is_heard = threading.Event()

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(text if self.path == "/" else b"")

        def do_POST(self) -> None:
            heard.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204)
            self.end_headers()
            is_heard.set()

        def log_message(self, *_: object) -> None:
            """Keep the test's output to itself."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        serving = threading.Thread(target=server.serve_forever)
        serving.start()
        profile = f"--user-data-dir={folder / 'profile'}"
        address = f"http://127.0.0.1:{server.server_address[1]}/"
        browser = subprocess.Popen(
            [CHROMIUM, *OPTIONS, profile, "--remote-debugging-port=0", address],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            assert is_heard.wait(100), "the page said nothing"
        finally:
            browser.terminate()
            browser.wait()
            server.shutdown()
            serving.join()
    return heard[0]
