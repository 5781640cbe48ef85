"""The page that the package carries, with a study in it."""

from __future__ import annotations

import base64
from importlib.resources import files
from importlib.resources.abc import Traversable

from telespring._errors import InvalidInput
from telespring.model import Study

__all__ = ["address_part", "carried_page", "is_carried", "page_with", "ready_study"]

#: What a study that leaves it open is shown with, as on the page: N/m, and s each way.
_STIFFNESS_AT_START, _DELAY_AT_START = 71.2, 0.1
_MARK = "<!-- STUDY -->"


def is_carried() -> bool:
    """Return whether the package was built with its page."""
    return _file().is_file()


def carried_page() -> str:
    """Return the page that the package carries.

    Raises
    ------
    telespring.InvalidInput
        If the package was built without it.
    """
    if not is_carried():
        raise InvalidInput(
            "page",
            "",
            "this telespring was built without its page",
            "Run 'make page' in its sources, or install a released wheel.",
        )
    return _file().read_text(encoding="utf-8")


def page_with(study: Study, *, page: str | None = None) -> str:
    """Return the page, one file that needs nothing else, which opens with a study.

    `page` takes the place of the page that the package carries.

    Examples
    --------
    >>> import telespring as ts
    >>> study = ts.Study.paper()
    >>> address_part(study) in page_with(study, page=_MARK)
    True
    """
    text = carried_page() if page is None else page
    return text.replace(_MARK, f'<script type="text/plain" id="study">{address_part(study)}</script>', 1)


def address_part(study: Study) -> str:
    """Return what the page's address has behind its # for a study.

    Examples
    --------
    >>> import telespring as ts
    >>> address_part(ts.Study.paper())[:14]
    'study=bmFtZSA9'
    """
    text = base64.urlsafe_b64encode(study.to_toml().encode()).decode("ascii")
    return f"study={text.rstrip('=')}"


def ready_study(study: Study) -> Study:
    """Return the study with a stiffness and a delay, which the page needs: its own or those of the start.

    Examples
    --------
    >>> import telespring as ts
    >>> ready_study(ts.Study.paper().replace(network=None)).delay
    (0.1, 0.1)
    """
    changes: dict[str, object] = {}
    if not study.has_stiffness:
        changes["coupling"] = {"stiffness": _STIFFNESS_AT_START}
    if not study.has_delay:
        changes["network"] = {"delay": _DELAY_AT_START}
    return study.replace(**changes) if changes else study


def _file() -> Traversable:
    return files("telespring") / "assets" / "telespring.html"
