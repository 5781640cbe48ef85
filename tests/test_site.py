"""What the documentation site is built from: references of commands and names, links, the gallery."""

from __future__ import annotations

import re
import runpy
import warnings
from importlib import import_module
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.testing.compare import compare_images
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app
from telespring.references import read_reference
from tools.site import command_reference, gallery, misprints, python_reference
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


def listed_by_module() -> dict[str, set[str]]:
    """Return the names that the page of Python lists, by their module."""
    found: dict[str, set[str]] = {}
    for line in python_reference.text().splitlines():
        if line.startswith(".. currentmodule:: "):
            module = found.setdefault(line.split()[-1], set())
        elif re.fullmatch(r" {3}\w+", line):
            module.add(line.strip())
    return found


def test_law_the_reference_of_python_has_every_room() -> None:
    """Every folder and file of the package is a room, and each of its names stands on the page once."""
    package = Path(ts.__file__).parent
    there = {
        path.stem for path in package.glob("*") if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert set(python_reference.rooms()) == {name for name in there if not name.startswith("_")}
    assert set(python_reference.ELSEWHERE) < there
    listed = listed_by_module()
    assert {"telespring", "telespring.analysis", "telespring.plot"} < set(listed)
    for room in set(python_reference.rooms()) - set(python_reference.ELSEWHERE):
        module = import_module(f"telespring.{room}")
        for name in (each for kind in python_reference.names(module.__name__) for each in kind):
            is_shown = name in listed.get(module.__name__, set())
            assert is_shown or getattr(ts, name, None) is getattr(module, name), f"{room}.{name}"


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


def test_pin_the_picture_of_the_first_tutorial_is_what_its_command_draws(tmp_path: Path) -> None:
    tutorial = (ROOT / "docs" / "tutorials" / "decide.md").read_text(encoding="utf-8")
    [command] = re.findall(r"^\$ telespring (decide .*) --figure map\.png$", tutorial, re.MULTILINE)
    [shown] = re.findall(r"^!\[.*\]\((.*)\)$", tutorial, re.MULTILINE)
    drawn = tmp_path / "map.png"
    assert CliRunner().invoke(app, [*command.split(), "--figure", str(drawn)]).exit_code == 0
    kept = (ROOT / "docs" / "tutorials" / shown).resolve()
    assert compare_images(str(kept), str(drawn), tol=2.0) is None


def test_law_the_loop_of_the_matlab_guide_is_the_one_of_nyquist() -> None:
    """MATLAB's `allmargin(L)` counts round −1, as `nyquist` does: it has to be given the same loop."""
    guide = (ROOT / "docs" / "how-to" / "from-matlab.md").read_text(encoding="utf-8")
    assert "L = -k^2 / ((m(1)*s^2 + b(1)*s + k) * (m(2)*s^2 + b(2)*s + k));" in guide
    assert "L.InputDelay = 2*0.1;" in guide
    [given] = re.findall(r"allmargin\((-?L)\) ", guide)
    k, (m1, m2), (b1, b2) = 71.2, (0.8334, 0.7776), (7.7257, 7.4208)
    s = 1j * np.array([1.0, 9.4, 30.0])
    loop = -(k**2) / ((m1 * s**2 + b1 * s + k) * (m2 * s**2 + b2 * s + k)) * np.exp(-2 * 0.1 * s)
    ours = ts.open_loop(ts.hman(), k, 0.1, s.imag, axis="x")
    np.testing.assert_allclose(loop if given == "L" else -loop, np.asarray(ours.value), rtol=1e-12)


def test_law_the_gallery_has_at_least_twelve_examples_that_assert() -> None:
    assert len(GALLERY) >= 12
    for script in GALLERY:
        assert re.search(r"^assert |^    assert ", script.read_text(encoding="utf-8"), re.MULTILINE), (
            script.name
        )


def test_law_a_picture_is_drawn_anew_when_the_package_has_changed(tmp_path: Path) -> None:
    package, pictures = tmp_path / "package", tmp_path / "gallery"
    package.mkdir()
    (package / "room.py").write_text("limit = 1\n")
    gallery.forget_stale_pictures(pictures, package)
    drawn = pictures / "plot_01.py.md5"
    drawn.write_text("drawn")
    gallery.forget_stale_pictures(pictures, package)
    assert drawn.exists()
    (package / "room.py").write_text("limit = 2\n")
    gallery.forget_stale_pictures(pictures, package)
    assert not drawn.exists()


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
