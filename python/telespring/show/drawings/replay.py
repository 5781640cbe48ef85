"""The figure of a replayed session."""

from __future__ import annotations

from typing import TYPE_CHECKING

from telespring.show.figures.replay import ReplayedCurves, ReplayPanels, replay_figure
from telespring.show.quantities import format_number
from telespring.show.strategies import name_strategy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from telespring.model import Study
    from telespring.replays import Replay

__all__ = ["draw_replay"]


def draw_replay(found: Replay) -> Figure:
    """Draw forces, ages and accounts of a replay over time, as recorded and as replayed."""
    return replay_figure(
        ReplayPanels(
            recorded=_settings(found.recorded_study),
            replayed=_settings(found.study),
            sides=[
                ReplayedCurves(
                    side=side.side,
                    time=side.time,
                    recorded_force=side.own.force,
                    force=side.replayed.force,
                    recorded_age=side.own.age,
                    age=side.replayed.age,
                    recorded_account=side.own.account,
                    account=side.replayed.account,
                )
                for side in found.sides
            ],
        )
    )


def _settings(study: Study) -> str:
    return f"{name_strategy(study.session.label)}, {format_number(study.stiffness)} N/m"
