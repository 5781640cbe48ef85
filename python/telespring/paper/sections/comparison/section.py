"""What takes the cost of the delay away: the study's bare spring beside the guard and the shared target."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from telespring._errors import InvalidInput
from telespring.model import Architecture, Study
from telespring.paper.rehearsed import rehearsed_study, short_rehearsal
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section

if TYPE_CHECKING:
    import xarray as xr

    from telespring.model import Dyad

__all__ = ["SECTION", "find_comparison"]

#: The architectures beside the bare spring, each with its place in `study.json`.
_GUARDED = {
    "guard": Architecture(strategy="guard"),
    "shared_target": Architecture(strategy="guard", predictor="shared-target"),
}
#: Trials of each condition that are run beside the study's own.
_TRIALS = 3

_Condition = tuple[float, float]


def find_comparison(scene: Scene) -> Findings:
    """Rehearse the study's conditions under the guard, and lay the results beside its bare spring's.

    The trials of the study's own protocol are those of the experiment. Between its delays more are tried, so
    that what the delay costs is seen between them, too.
    """
    from telespring.paper.sections.comparison.measured import measure_rehearsal, side_by_side
    from telespring.paper.sections.comparison.numbers import comparison_numbers

    own = _connected(scene.study)
    guarded = {
        key: architecture
        for key, architecture in _GUARDED.items()
        if own and _is_possible(scene, architecture)
    }
    if not guarded:
        return Findings()
    architectures = {"spring": Architecture(), **guarded}
    added = _between(own)
    with rehearsed_study(scene) as dataset, TemporaryDirectory(prefix="telespring-") as temporary:
        files: dict[str, list[Path]] = {}
        for key, architecture in architectures.items():
            is_known = scene.study.session == architecture
            conditions = [*([] if is_known else own), *added]
            files[key] = [dataset] if is_known else []
            if conditions:
                study = scene.study.replace(session=architecture)
                short = _with_conditions(study, conditions, like_own=not is_known)
                files[key].append(short_rehearsal(short, Path(temporary) / key, scene))
        measured = {key: [measure_rehearsal(file) for file in each] for key, each in files.items()}
        ours = next((parts[0] for key, parts in measured.items() if files[key][0] == dataset), None)
        ours = ours or measure_rehearsal(dataset)
        labels = {key: architecture.label for key, architecture in architectures.items()}
        compared = side_by_side({labels[key]: parts for key, parts in measured.items()}, ours)
        numbers, shown = comparison_numbers(scene, compared, labels, own, ours.target_speed)
        drawings = _draw(scene, compared, labels, files, shown)
    return Findings(numbers={"comparison": numbers}, drawings=drawings)


SECTION = Section(
    name="comparison",
    anchor="comparison",
    title="What takes the cost of the delay away",
    step="strategies compared",
    find=find_comparison,
    is_long=True,
)


def _is_possible(scene: Scene, architecture: Architecture) -> bool:
    """Whether the study can have this architecture in all its conditions."""
    from telespring.comparison.trying import refusal_of

    try:
        return refusal_of(scene.study.replace(session=architecture), scene.modules) is None
    except InvalidInput:
        return False


def _connected(study: Study) -> list[_Condition]:
    """List the study's conditions with a spring, N/m and s, each once."""
    if study.experiment is None:
        return []
    return list(dict.fromkeys((k, delay) for k, delay in study.experiment.conditions if k is not None))


def _between(conditions: list[_Condition]) -> list[_Condition]:
    """Add the delays in the middle between those of each stiffness."""
    added = []
    for stiffness in dict.fromkeys(k for k, _ in conditions):
        delays = sorted(delay for k, delay in conditions if k == stiffness)
        added += [(stiffness, 0.5 * (low + high)) for low, high in pairwise(delays)]
    return added


def _with_conditions(study: Study, conditions: list[_Condition], *, like_own: bool) -> Study:
    """Change the protocol of a study to some conditions, with few trials.

    If they begin `like_own` ones, the unconnected condition stays, too: then each trial has the random
    numbers of the study's own.
    """
    assert study.experiment is not None
    is_unconnected = any(k is None for k, _ in study.experiment.conditions)
    return study.replace(
        protocol={
            "stiffness": None,
            "delay": None,
            "unconnected": like_own and is_unconnected,
            "conditions": [{"stiffness": k, "delay": delay} for k, delay in conditions],
            "trials": min(_TRIALS, study.experiment.trials),
        }
    )


def _draw(
    scene: Scene,
    compared: xr.Dataset,
    labels: Mapping[str, str],
    files: Mapping[str, list[Path]],
    shown: _Condition,
) -> dict[str, str]:
    """Draw all figures; the account is that of the last architecture in the condition `shown`."""
    from telespring.decision.arm_stability import arm_stability
    from telespring.paper.sections.comparison.measured import first_trial
    from telespring.show import figures
    from telespring.show.drawings.comparison import draw_account, draw_delays, draw_plane

    held: Dyad | None = None
    arms = arm_stability(scene.study, [], scene.modules)
    if arms.operators is not None and not arms.operators.depends_on_pose:
        held = arms.operators.held
    last = list(labels)[-1]
    trial = first_trial(files[last][0], *shown)
    bare = first_trial(files["spring"][0], *shown)
    return {
        "delays": figures.to_svg(
            draw_delays(compared),
            "delays",
            "Tracking error of both people against the delay, by stiffness and strategy",
            "A column per stiffness, a row per person; the table below has all means.",
        ),
        "plane": figures.to_svg(
            draw_plane(compared, list(labels.values()), dyad=scene.dyad, held=held),
            "plane",
            "What the delay costs over stiffness and delay",
            "A panel per strategy with the boundary of the bare spring; the table below has all numbers.",
        ),
        "account": figures.to_svg(
            draw_account(trial, without_guard=bare, span=(0.0, 12.0)),
            "account",
            "One trial under the guard over time",
            "Energy of the account and force of both robots, with the time in which the force was limited "
            "shaded; below the positions of both handles with the target.",
        ),
    }
