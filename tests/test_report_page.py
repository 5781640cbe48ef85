"""The report as a browser lays it out on a screen, a telephone and paper, and as axe-core judges it."""

from __future__ import annotations

import html
import re
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import pytest

from browser import REPORT, look, needs_chromium
from telespring.paper import Analysis

#: The names of the tables that stick out of their page, and how far.
TABLES = """<script>
report([...document.querySelectorAll("table")].map(
  table => [table.id || table.innerText.slice(0, 40), table.getBoundingClientRect().right
            - table.parentElement.getBoundingClientRect().right]));
</script>"""


@needs_chromium
# 718 px: A4 without the browser's margins of 1 cm, laid out by the rules for print
@pytest.mark.parametrize(("width", "medium"), [(1000, "screen"), (718, "print")])
def test_law_no_table_is_wider_than_the_page(
    analysis: Analysis, width: int, medium: str, tmp_path: Path
) -> None:
    page = analysis.html.replace("<details>", "<details open>")
    if medium == "print":
        assert "@media print" in page
        page = page.replace("@media print", "@media all")
    measured = look(page, TABLES, tmp_path, width)
    assert len(measured) > 10
    # half a pixel: widths are rounded
    assert [name for name, beyond in measured if beyond > 0.5] == []


@needs_chromium
def test_law_on_a_telephone_the_page_does_not_scroll_sideways(analysis: Analysis, tmp_path: Path) -> None:
    script = "<script>report([document.documentElement.scrollWidth, innerWidth])</script>"
    frame = f'<iframe srcdoc="{html.escape(analysis.html.replace("</body>", REPORT + script + "</body>"))}"'
    # Chromium's own windows are at least 500 px wide.
    page = f'<body>{frame} width="400" height="800"></iframe></body>'
    read = """<script>addEventListener("load", () => report(JSON.parse(
      document.querySelector("iframe").contentDocument.querySelector("#measured").textContent)))</script>"""
    width, window = look(page, read, tmp_path)
    assert window == 400
    assert width <= window


@needs_chromium
def test_law_what_is_folded_on_the_screen_is_printed(analysis: Analysis, tmp_path: Path) -> None:
    count = 'document.querySelectorAll("details:not([open])").length'
    script = (
        f"<script>const a = {count}; dispatchEvent(new Event('beforeprint')); report([a, {count}])</script>"
    )
    folded, then = look(analysis.html, script, tmp_path)
    assert folded > 3
    assert then == 0


@needs_chromium
@pytest.mark.skipif(find_spec("axe_core_python") is None, reason="NO AXE-CORE HERE: accessibility unchecked")
def test_cross_axe_core_finds_no_fault(analysis: Analysis, tmp_path: Path) -> None:
    axe = (files("axe_core_python") / "axe.min.js").read_text(encoding="utf-8")
    run = """<script>axe.run().then(found => report(found.violations.map(
      each => [each.impact, each.id, each.nodes.map(node => node.target.join(" "))])))</script>"""
    page = analysis.html.replace("<details>", "<details open>")
    assert look(page, f"<script>{axe}</script>{run}", tmp_path) == []


def test_law_the_page_is_small_and_its_figures_hold_text(analysis: Analysis) -> None:
    assert len(analysis.html.encode()) <= 3_000_000
    assert analysis.html.count("<text ") > 500
    # outlines of letters, which matplotlib names after the font
    assert "DejaVuSans-" not in analysis.html


def test_ref_text_in_figures_has_a_contrast_of_four_and_a_half(analysis: Analysis) -> None:
    """WCAG 2.2, success criterion 1.4.3, for text on white or on the lightest fill of a schematic."""

    def luminance(colour: str) -> float:
        channels = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    assert luminance("#ffffff") == pytest.approx(1.0)
    fills = {
        colour.lower()
        for text in re.findall(r"<(?:text|tspan) [^>]*>", analysis.html)
        for colour in re.findall(r"fill: (#[0-9a-fA-F]{6})", text)
    }
    assert len(fills) > 4
    for colour in fills:
        assert (luminance("#f3f6f5") + 0.05) / (luminance(colour) + 0.05) >= 4.5, colour
