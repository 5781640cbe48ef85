"""The documentation site: `make docs` builds it into out/docs, and any warning is an error."""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path

from pygments.lexers import TextLexer
from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path[:0] = [str(ROOT / "python"), str(ROOT)]
# Before NumPy is loaded: on cores that others use too, OpenBLAS' threads wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tools.site import command_reference, gallery, misprints, page, python_reference  # noqa: E402

project = "telespring"
author = "telespring developers"
project_copyright = "telespring developers, MIT licence"
release = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
version = release

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "tools.site.katex",
    "tools.site.repository_links",
    "tools.site.tables",
    "tools.site.toggles",
]
# written anew by each build, never committed
GENERATED = DOCS / "_generated"
command_reference.write(GENERATED / "commands.md")
python_reference.write(GENERATED / "python.rst")
misprints.write(GENERATED / "misprints.md")
gallery.forget_stale_pictures(GENERATED / "gallery", ROOT / "python" / "telespring")
page.write(GENERATED / "try-it.md", ROOT / "out" / "page" / "telespring.html")

exclude_patterns = [
    "_build",
    "node_modules",
    "_templates",
    "gallery",
    "_generated/misprints.md",  # a part of another page
    "**/sg_execution_times.rst",
    "sg_execution_times.rst",
]
suppress_warnings = ["config.cache"]  # the gallery's order is a function, which no cache keeps
smartquotes = False  # `--check` is no dash
default_role = "literal"  # docstrings quote names with single backticks

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 4  # as on a page host: networks.md#files
myst_dmath_double_inline = True

templates_path = ["_templates"]  # the lists beside a page show names without the package's
autosummary_generate = True
autodoc_typehints = "none"  # numpydoc has the types in words
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

sphinx_gallery_conf = gallery.configuration(DOCS)

html_theme = "pydata_sphinx_theme"
html_title = f"telespring {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = page.files(ROOT / "out" / "page" / "telespring.html")
html_show_sourcelink = False
html_copy_source = False
html_sidebars = {"index": [], "_generated/try-it": []}  # they have no pages below them
html_theme_options = {
    "logo": {"text": "telespring"},
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "navbar_persistent": ["search-button"],
    "show_prev_next": True,
    "collapse_navigation": True,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}


def setup(app: Sphinx) -> None:
    """Show tables in text as they are: no highlighter knows them."""
    app.add_lexer("csv", TextLexer)
