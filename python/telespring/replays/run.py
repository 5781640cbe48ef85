"""A replay from beginning to end: the session's own settings, and the ones that were asked for."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from telespring._core import Architecture, ReplayedSite, Study, replay_pair, replay_site
from telespring._errors import InvalidInput
from telespring.replays.results import Replay, SideReplay, first_difference
from telespring.replays.sites import SiteRecording, check_one_session

__all__ = ["Part", "changed_study", "replay"]

#: A part of an architecture: its word, or a mapping with the kind and its settings.
Part: TypeAlias = str | Mapping[str, Any]
Source: TypeAlias = str | os.PathLike[str] | SiteRecording

#: Strategies that use nothing of the partner's packets but the motion.
_ALONE = frozenset({"spring", "injected-damping"})


def replay(
    session: Source,
    other: Source | None = None,
    *,
    strategy: Part | None = None,
    predictor: Part | None = None,
    playout: Part | None = None,
    stiffness: float | None = None,
) -> Replay:
    """Replay a recorded session under another strategy, predictor, play-out or stiffness.

    The endpoints of the session are given once more what they were given then: the measured motions, the
    target and every datagram that arrived, at its time and in its order. With the recordings of both sides
    each packet has the content that its replayed sender gives it. Without changes the recorded forces come
    out, bit for bit. The people do not react to the force of a replay: it tells forces, ages, limits and
    energies on this motion and network.

    Parameters
    ----------
    session : path or SiteRecording
        The recording of one side, or the merged one of both.
    other : path or SiteRecording, optional
        The recording of the other side.
    strategy, predictor, playout : str or mapping, optional
        As in the section ``[session]`` of a study file, such as "guard" or ``{"kind": "fixed", "delay":
        0.08}``. Default: as in the session.
    stiffness : float, optional
        Stiffness of the spring, N/m. Default: as in the session.

    Returns
    -------
    Replay
        Each side, recorded and replayed.

    Raises
    ------
    InvalidInput
        If a file is no recording, the recordings are not of one session, a live session refuses the settings,
        or they need the recording of the partner, too.
    OSError
        If a file cannot be read.

    Examples
    --------
    >>> import telespring as ts
    >>> own = ts.replay("session.mcap")
    >>> own.is_reproduced, own.partner
    (True, 'replayed')
    >>> later = ts.replay("session.mcap", playout={"kind": "fixed", "delay": 0.02}, stiffness=50.0)
    >>> later.study.session.playout_delay, later.acted_force, own.acted_force
    (0.02, 'as commanded', 'as recorded')
    """
    sites = _sites(session, other)
    recorded_study = sites[0].study
    study = changed_study(recorded_study, strategy, predictor, playout, stiffness)
    is_own = study == recorded_study
    if len(sites) == 1 and not is_own:
        _check_partner(recorded_study, study)
    own = _run(recorded_study, sites, is_own=True)
    replayed = own if is_own else _run(study, sites, is_own=False)
    sides = tuple(
        SideReplay(site, before, after, first_difference(site, before))
        for site, before, after in zip(sites, own, replayed, strict=True)
    )
    return Replay(recorded_study, study, sides, "replayed" if len(sites) == 2 else "as recorded")


def _sites(session: Source, other: Source | None) -> Sequence[SiteRecording]:
    """Return the recordings of one or both sides, that of side 1 first."""
    sites = list(_read(session))
    if other is not None:
        sites += _read(other)
    if len(sites) > 2:
        raise InvalidInput(
            "session",
            f"{len(sites)} recordings of a side",
            "the recordings of one or both sides are required",
            "Leave out the second file: the first has both sides.",
        )
    if len(sites) == 2:
        check_one_session(*sites)
    return sorted(sites, key=lambda site: site.side)


def _read(source: Source) -> Sequence[SiteRecording]:
    if isinstance(source, SiteRecording):
        return [source]
    from telespring.replays.reading import read_sites

    return read_sites(source)


def changed_study(
    study: Study,
    strategy: Part | None = None,
    predictor: Part | None = None,
    playout: Part | None = None,
    stiffness: float | None = None,
) -> Study:
    """Return the study of a session with other settings; InvalidInput for one that it cannot have.

    Examples
    --------
    >>> import telespring as ts
    >>> changed_study(ts.Study.paper(), strategy="guard").session.label
    'guard'
    """
    parts = {"strategy": strategy, "predictor": predictor, "playout": playout}
    chosen = {name: part for name, part in parts.items() if part is not None}
    if chosen:
        study = study.replace(session=Architecture(**{**study.session.settings(), **chosen}))
    if stiffness is not None:
        study = study.replace(coupling={"stiffness": stiffness})
    return study


def _check_partner(recorded: Study, study: Study) -> None:
    """Refuse settings under which the partner's packets would have carried something else."""
    before, after = recorded.session, study.session
    is_kept = (
        before.settings()["strategy"] == after.settings()["strategy"]
        and recorded.stiffness == study.stiffness
    )
    if is_kept or after.strategy in _ALONE:
        return
    raise InvalidInput(
        "session",
        "the recording of one side",
        f"with the strategy {after.strategy}, the partner's packets carry energy or waves, and those of a "
        f"session with {before.strategy} at {recorded.stiffness:g} N/m are others",
        "Give the recording of the other side, too.",
    )


def _run(study: Study, sites: Sequence[SiteRecording], *, is_own: bool) -> Sequence[ReplayedSite]:
    if len(sites) == 1:
        (site,) = sites
        return [
            replay_site(
                study,
                site.core(),
                site.side,
                site.session,
                is_own,
                site.largest_force,
                site.steepest_rise,
                site.silence,
                site.stall,
            )
        ]
    one, two = sites
    return replay_pair(
        study,
        (one.core(), two.core()),
        (one.session, two.session),
        is_own,
        (one.largest_force, two.largest_force),
        (one.steepest_rise, two.steepest_rise),
        (one.silence, two.silence),
        (one.stall, two.stall),
    )
