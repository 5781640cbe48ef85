"""The page in a notebook, with the study in Python and in the page kept the same."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from telespring._errors import InvalidInput
from telespring.app.page import carried_page, page_with, ready_study
from telespring.model import Coupling, Dyad, Network, Study

if TYPE_CHECKING:
    from telespring._types import Delay

__all__ = ["explore"]

#: The page stands in a frame of its own, and tells the study that it shows.
_MODULE = """
export default {
  render({ model, el }) {
    const frame = document.createElement("iframe");
    frame.title = "telespring: is this coupling stable?";
    frame.setAttribute("sandbox", "allow-scripts allow-downloads allow-popups");
    frame.style.cssText = "width: 100%; height: 860px; border: 0";
    frame.setAttribute("allow", "clipboard-write *");
    frame.srcdoc = model.get("_page");
    const tell = () => {
      frame.contentWindow?.postMessage({ telespring: "open", study: model.get("toml") }, "*");
    };
    let isOpen = false;
    const hear = (event) => {
      if (event.source !== frame.contentWindow || event.data?.telespring !== "study") return;
      // A page opens with the study of the start; what Python or another view has put since then counts.
      const isFirst = !isOpen;
      isOpen = true;
      if (isFirst && model.get("toml") && model.get("toml") !== event.data.study) return tell();
      model.set("toml", event.data.study);
      model.save_changes();
    };
    window.addEventListener("message", hear);
    model.on("change:toml", tell);
    el.append(frame);
    return () => {
      window.removeEventListener("message", hear);
      model.off("change:toml", tell);
    };
  },
};
"""


def explore(
    subject: Dyad | Study | None = None,
    stiffness: float | None = None,
    delay: Delay | Network | None = None,
) -> Any:
    """Show the page on which stiffness, delay and robots can be changed, in a notebook.

    The page computes in the browser with the same core. Moving a slider changes `study` of what is returned,
    and a study put there is shown. Needs the package anywidget: `pip install "telespring[jupyter]"`.

    Parameters
    ----------
    subject : Dyad or Study, optional
        The robots and what holds them; the paper's two H-MANs by default.
    stiffness : float, optional
        Stiffness of the virtual spring, N/m.
    delay : float, (float, float) or Network, optional
        One-way delay each way, s, or the pair (forward, backward); or a network.

    Returns
    -------
    anywidget.AnyWidget
        The page; `study` is the study that it shows, `toml` its text.

    Raises
    ------
    InvalidInput
        If a value is out of range, anywidget is not installed, or telespring was built without its page.

    Examples
    --------
    >>> import telespring as ts
    >>> shown = ts.explore(ts.hman(), 71.2, 0.1)  # doctest: +SKIP
    >>> shown.study = shown.study.replace(coupling={"stiffness": 90.0})  # doctest: +SKIP
    """
    study = ready_study(_study_of(subject, stiffness, delay))
    # where the page is missing or anywidget is, before anything is shown
    carried_page()
    return _widget_class()(study)


def _study_of(subject: Dyad | Study | None, stiffness: float | None, delay: Delay | Network | None) -> Study:
    changes: dict[str, object] = {}
    if stiffness is not None:
        changes["coupling"] = Coupling(stiffness)
    if delay is not None:
        changes["network"] = delay if isinstance(delay, Network) else {"delay": _both_ways(delay)}
    if isinstance(subject, Study):
        if stiffness is not None:
            changes["coupling"] = {"stiffness": Coupling(stiffness).stiffness}
        return subject.replace(**changes) if changes else subject
    if subject is None:
        paper = Study.paper()
        return Study.from_toml("", robot1=paper.dyad.robots[0], robot2=paper.dyad.robots[1]).replace(
            **changes
        )
    if not isinstance(subject, Dyad):
        raise InvalidInput(
            "subject",
            repr(subject)[:60],
            "a Dyad, a Study or None is required",
            "Pass Dyad(Robot(mass, damping), Robot(mass, damping)).",
        )
    (one, two), (first, second) = subject.robots, subject.operators
    coupling: dict[str, object] = {"damping": subject.coupling_damping}
    if stiffness is not None:
        coupling["stiffness"] = Coupling(stiffness).stiffness
    changes |= {"operator1": first, "operator2": second, "coupling": coupling}
    return Study.from_toml("", robot1=one, robot2=two).replace(**changes)


def _both_ways(delay: Delay) -> dict[str, float]:
    forward, backward = Network(delay).delay  # refuses what is no delay
    return {"forward": forward, "backward": backward}


@cache
def _widget_class() -> type:
    """Return the widget's class, whose base may not be installed."""
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise InvalidInput(
            "anywidget",
            "",
            "a notebook shows the page with the package anywidget, which is not installed",
            'Run: pip install "telespring[jupyter]". Without a notebook: telespring explore.',
        ) from None

    class Explorer(anywidget.AnyWidget):
        """The page in a notebook; `study` and the page show the same."""

        _esm = _MODULE
        toml = traitlets.Unicode().tag(sync=True)
        _page = traitlets.Unicode().tag(sync=True)

        def __init__(self, study: Study) -> None:
            super().__init__(toml=study.to_toml(), _page=page_with(study))

        @property
        def study(self) -> Study:
            """The study that the page shows."""
            return Study.from_toml(self.toml)

        @study.setter
        def study(self, study: Study) -> None:
            self.toml = ready_study(study).to_toml()

    return Explorer
