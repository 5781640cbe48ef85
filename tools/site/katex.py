"""Formulas as KaTeX draws them, rendered while the site is built: a page needs no script for them."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

__all__ = ["Renderer", "setup"]

#: Answers each line, a formula, with its markup; MathML is in it for screen readers.
_PROGRAM = """
const katex = require("katex");
require("readline").createInterface({input: process.stdin}).on("line", line => {
  const {text, display} = JSON.parse(line);
  let answer;
  try { answer = {html: katex.renderToString(text, {displayMode: display, strict: "error"})}; }
  catch (error) { answer = {error: error.message}; }
  console.log(JSON.stringify(answer));
});
"""


class Renderer:
    """One run of KaTeX in Node, started with the first formula.

    Parameters
    ----------
    folder : Path
        The folder whose node_modules has KaTeX.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: subprocess.Popen[str] | None = None

    def render(self, text: str, *, is_display: bool) -> str:
        """Return the markup of a formula."""
        process = self._process or self._start()
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(json.dumps({"text": text, "display": is_display}) + "\n")
        process.stdin.flush()
        answer = json.loads(process.stdout.readline() or '{"error": "Node ended"}')
        if "error" in answer:
            raise ExtensionError(f"KaTeX refuses the formula {text!r}: {answer['error']}")
        return str(answer["html"])

    def _start(self) -> subprocess.Popen[str]:
        node = shutil.which("node") or shutil.which("nodejs")
        if node is None or not (self._folder / "node_modules" / "katex").is_dir():
            raise ExtensionError("the site needs Node.js, and KaTeX in docs/node_modules: run `make docs`")
        self._process = subprocess.Popen(
            [node, "-e", _PROGRAM],
            cwd=self._folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        return self._process

    def close(self) -> None:
        """End the run."""
        if self._process is not None:
            self._process.communicate()
            self._process = None


def setup(app: Sphinx) -> dict[str, Any]:
    """Render the site's formulas with KaTeX, and ship its style and fonts."""
    renderer = Renderer(Path(app.srcdir))

    def inline(self: Any, node: Any) -> None:
        from docutils import nodes

        self.body.append(renderer.render(node.astext(), is_display=False))
        raise nodes.SkipNode

    def block(self: Any, node: Any) -> None:
        from docutils import nodes

        formula = renderer.render(node.astext(), is_display=True)
        # what is wider than the screen scrolls by keyboard, too
        self.body.append(
            f'<div class="formula" tabindex="0" role="group" aria-label="Formula">{formula}</div>'
        )
        raise nodes.SkipNode

    def ship(app: Sphinx, failed: Exception | None) -> None:
        renderer.close()
        if failed is None and app.builder.format == "html":
            source = Path(app.srcdir) / "node_modules" / "katex" / "dist"
            target = Path(app.outdir) / "_static" / "katex"
            shutil.copytree(
                source / "fonts",
                target / "fonts",
                ignore=shutil.ignore_patterns("*.ttf", "*.woff"),
                dirs_exist_ok=True,
            )
            shutil.copy(source / "katex.min.css", target)
            shutil.copy(source.parent / "LICENSE", target)

    app.add_html_math_renderer("katex", (inline, None), (block, None))
    app.config.html_math_renderer = "katex"
    app.add_css_file("katex/katex.min.css")
    app.connect("build-finished", ship)
    return {"parallel_read_safe": True, "parallel_write_safe": False}
