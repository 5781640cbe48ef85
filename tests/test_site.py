"""What the documentation site is built from: references of commands and names, links, the gallery."""

from __future__ import annotations

import re
import runpy
import warnings
from pathlib import Path

import matplotlib as mpl
import pytest
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app
from telespring.references import read_reference
from tools.site import command_reference, misprints, python_reference
from tools.site.repository_links import PAGES, site_link

ROOT = Path(__file__).resolve().parent.parent
GALLERY = sorted((ROOT / "docs" / "gallery").glob("plot_*.py"))


@pytest.mark.parametrize("name", sorted(command_reference.commands()))
def test_law_the_reference_has_every_option_that_the_help_lists(name: str) -> None:
    """At 79 columns the help is plain text, which cuts no name."""
    help_text = CliRunner(env={"COLUMNS": "79"}).invoke(app, [name, "--help"]).output
    listed = set(re.findall(r"^  (?:-\w, )?(--[a-z0-9-]+)", help_text, re.MULTILINE)) - {"--help"}
    section = re.search(rf"^## telespring {name}\n(.*?)(?=^## |\Z)", command_reference.text(), re.M | re.S)
    assert section is not None
    written = set(re.findall(r"^`(--[a-z0-9-]+)`", section[1], re.MULTILINE))
    assert written == listed
    assert len(written) > 0 or name == "merge"


def test_law_the_reference_has_every_command_that_the_help_lists() -> None:
    help_text = CliRunner(env={"COLUMNS": "79"}).invoke(app, ["--help"]).output
    listed = re.findall(r"^  ([a-z]+)  ", help_text.partition("Commands:")[2], re.MULTILINE)
    assert re.findall(r"^## telespring (.*)$", command_reference.text(), re.MULTILINE) == listed


def test_law_the_reference_of_python_has_every_public_name() -> None:
    classes, functions = python_reference.names("telespring")
    assert {*classes, *functions} == {name for name in ts.__all__ if not name.startswith("_")}
    assert "critical_stiffness" in functions
    assert "Dyad" in classes


def test_law_every_misprint_of_the_reference_file_is_in_the_table() -> None:
    assert misprints.table().count("\n") == 2 + len(read_reference("du2025")["misprint"])


@pytest.mark.parametrize(
    ("target", "document", "page", "link"),
    [
        ("guard.md", "docs/limits.md", "limits.md", "guard.md"),
        ("../NOTATION.md", "docs/limits.md", "limits.md", "reference/notation.md"),
        ("docs/guard.md", "CHANGELOG.md", "project/changelog.md", "../guard.md"),
        ("../../docs/guard.md", "drivers/lsl/README.md", "how-to/driver-lsl.md", "../guard.md"),
        ("../examples/tremor.toml", "docs/rehearse.md", "rehearse.md", "../examples/tremor.toml"),
    ],
)
def test_law_links_of_documents_lead_to_their_pages(target: str, document: str, page: str, link: str) -> None:
    assert site_link(target, document, page) == link


def test_law_every_document_of_the_repository_has_a_page() -> None:
    for document, page in PAGES.items():
        assert (ROOT / document).exists()
        assert (ROOT / "docs" / page).exists()


def test_law_every_page_is_in_a_table_of_contents() -> None:
    pages = {
        path for path in (ROOT / "docs").rglob("*.md") if not {"node_modules", "_generated"} & set(path.parts)
    }
    listed = {ROOT / "docs" / "index.md"}
    for page in pages:
        for contents in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            entries = [line for line in contents.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{entry}.md").resolve() for entry in entries}
    assert pages - listed == set()


def test_law_the_gallery_has_at_least_twelve_examples_that_assert() -> None:
    assert len(GALLERY) >= 12
    for script in GALLERY:
        assert re.search(r"^assert |^    assert ", script.read_text(encoding="utf-8"), re.MULTILINE), (
            script.name
        )


@pytest.mark.parametrize("script", GALLERY, ids=lambda script: script.stem)
def test_law_every_example_of_the_gallery_holds_what_it_says(script: Path) -> None:
    with mpl.rc_context({"backend": "agg", "figure.max_open_warning": 0}), warnings.catch_warnings():
        warnings.simplefilter("error")
        import matplotlib.pyplot as plt

        before = plt.get_fignums()
        try:
            runpy.run_path(str(script))
            assert len(plt.get_fignums()) > len(before)
        finally:
            plt.close("all")
