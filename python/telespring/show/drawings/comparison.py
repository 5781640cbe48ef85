"""The figures of a comparison of strategies, from its dataset as `docs/compare.md` describes it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.show.quantities import format_number
from telespring.show.strategies import name_strategy

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from telespring.comparison import Recommendation
    from telespring.model import Dyad
    from telespring.show.figures.comparison_account import AccountTrial
    from telespring.show.figures.comparison_plane import Boundary, Reference

__all__ = [
    "COMPARISON_FIGURES",
    "draw_account",
    "draw_comparison",
    "draw_delays",
    "draw_plane",
    "error_reference",
    "spring_boundary",
]

#: Files of the figures that `draw_comparison` draws, in its order.
COMPARISON_FIGURES = ("delays.png", "plane.png", "account.png")

#: Stiffnesses and delays at which the boundary of the bare spring is computed.
_COLUMNS, _ROWS = 260, 401
#: A force is limited where its energy is the whole account, but for what one tick changes.
_WHOLE_ACCOUNT = 0.97
#: Points of a curve of one trial, and how much of it `draw_comparison` shows, s.
_POINTS, _SPAN = 600, (0.0, 12.0)


def draw_comparison(
    comparison: xr.Dataset, recommendation: Recommendation, dyad: Dyad | None = None
) -> Iterator[tuple[str, Figure]]:
    """Draw all figures of a comparison, each with the name of its file.

    The plane shows the best safe choice beside the bare spring. The account is that of this choice at its
    stiffness, on the network and at the delay at which most was limited; if it keeps no account, that of
    another architecture that does. A figure for which nothing was compared is left out.
    """
    yield COMPARISON_FIGURES[0], draw_delays(comparison, unconnected=_unconnected_errors(comparison))
    labels, best = _names(comparison, "architecture"), recommendation.candidate
    guarded = "guard + shared-target" if "guard + shared-target" in labels else "guard"
    beside = guarded if best is None or best.architecture == "spring" else best.architecture
    strategies = [label for label in dict.fromkeys(("spring", beside)) if label in labels]
    if strategies:
        yield COMPARISON_FIGURES[1], draw_plane(comparison, strategies, dyad=dyad)
    found = _account_to_show(comparison, recommendation, beside)
    if found is not None:
        place, role = found
        trial = comparison.sel(place)
        bare = comparison.sel(place | {"architecture": "spring"}) if "spring" in labels else None
        where = f"{1e3 * float(trial.delay):.0f} ms"
        if comparison.sizes["network"] > 1:
            where += f" on {place['network']}"
        title = (
            f"{role}{name_strategy(place['architecture'])}, {format_number(float(trial.stiffness))} N/m, "
            f"{where}, beginning of the first trial"
        )
        yield COMPARISON_FIGURES[2], draw_account(trial, without_guard=bare, span=_SPAN, title=title)


def _account_to_show(
    comparison: xr.Dataset, recommendation: Recommendation, beside: str
) -> tuple[dict[str, str], str] | None:
    """Choose the trial whose account is drawn, and say what it is to the choice; None without an account."""
    best = recommendation.candidate
    one = comparison.sel(architecture=[beside]) if beside in comparison.architecture else comparison
    if best is None:
        place = _most_limited(one) or _most_limited(comparison)
        return None if place is None else (place, "")

    def at_its_stiffness(part: xr.Dataset) -> xr.Dataset:
        return part.isel(condition=np.flatnonzero(part.stiffness.values == best.stiffness))

    place = _most_limited(at_its_stiffness(one))
    if place is not None and beside == best.architecture:
        return place, "recommended: " if recommendation.recommended is not None else "best safe coupling: "
    place = place or _most_limited(at_its_stiffness(comparison))
    return None if place is None else (place, "not recommended: ")


def _most_limited(comparison: xr.Dataset) -> dict[str, str] | None:
    """Find where a kept account limited most, or, if it never did, where the errors were largest; or None."""
    is_kept = np.isfinite(comparison.account).any(("time", "robot"))
    limited, errors = (
        comparison[name].mean(("trial", "robot")).where(is_kept)
        for name in ("limited_share", "tracking_error")
    )
    if not np.isfinite(limited).any():
        return None
    if not (limited > 0.0).any() and np.isfinite(errors).any():
        limited = errors
    best = limited.fillna(-1.0).argmax(...)
    return {str(name): str(comparison[name].values[int(place)]) for name, place in best.items()}


def draw_delays(
    comparison: xr.Dataset,
    network: str | None = None,
    *,
    unconnected: tuple[float, float] | None = None,
    figure: Figure | None = None,
) -> Figure:
    """Draw the tracking errors of both people against the delay, with every strategy.

    A column per stiffness, and per network unless one is named. `unconnected` is the tracking error of both
    without a coupling, m.
    """
    from telespring.show.figures.comparison import DelayCurve, DelayPanel, delay_figure
    from telespring.show.figures.strategy_looks import looks_of_strategies

    networks = _names(comparison, "network") if network is None else [network]
    labels = _names(comparison, "architecture")
    panels = []
    for name in networks:
        for stiffness in sorted(set(comparison.stiffness.values.tolist())):
            here = comparison.sel(network=name)
            here = here.isel(condition=np.flatnonzero(here.stiffness.values == stiffness)).sortby("delay")
            curves = []
            for label in labels:
                one = here.sel(architecture=label)
                error = one.tracking_error.transpose("condition", "trial", "robot").values
                trials, ran_away, ended_early = count_trials(one)
                was_run = trials > 0
                if not was_run.any():
                    continue
                error = error[was_run]
                curves.append(
                    DelayCurve(
                        label=label,
                        name=name_strategy(label),
                        delay=one.delay.values[was_run],
                        mean=_over_trials(np.mean, error),
                        spread=_over_trials(np.std, error),
                        ran_away=ran_away[was_run],
                        ended_early=ended_early[was_run],
                        trials=trials[was_run],
                    )
                )
            title = f"{format_number(stiffness)} N/m"
            if len(networks) > 1:
                title = f"{name}: {title}"
            if curves:
                panels.append(DelayPanel(title, curves, undelayed_errors(here, stiffness)))
    return delay_figure(panels, looks_of_strategies(labels), unconnected, figure)


def draw_plane(
    comparison: xr.Dataset,
    strategies: Sequence[str] = ("spring", "guard + shared-target"),
    network: str | None = None,
    *,
    dyad: Dyad | None = None,
    held: Dyad | None = None,
    figure: Figure | None = None,
) -> Figure:
    """Draw what the delay costs over stiffness and delay, a panel for each of some strategies.

    The errors are relative to the bare spring's without delay at the same stiffness. If a stiffness was not
    compared without delay, they are relative to working without a partner, and the legend says so. With the
    boundary of the bare spring at a constant delay, continuous controllers: that of `dyad`, shaded,
    and that of `held`, the same robots with what holds the handles.
    """
    from telespring.show.figures.comparison_plane import PlanePanel, PlanePoint, plane_figure

    name = _names(comparison, "network")[0] if network is None else network
    one = comparison.sel(network=name)
    reference = error_reference(one)
    panels = []
    for label in strategies:
        here = one.sel(architecture=label)
        trials, ran_away, ended_early = count_trials(here)
        points = []
        for i, (k, delay) in enumerate(zip(here.stiffness.values, here.delay.values, strict=True)):
            if trials[i]:
                ratio = _error_ratio(one, label, i, reference)
                failed = int(ran_away[i] + ended_early[i])
                points.append(PlanePoint(float(k), float(delay), ratio, failed, int(trials[i])))
        title = name_strategy(label)
        if comparison.sizes.get("network", 1) > 1:
            title += f", {name}"
        panels.append(PlanePanel(title, points))
    k, delay = (float(comparison[key].max()) for key in ("stiffness", "delay"))
    extent = 1.12 * k, 1.12 * max(delay, 0.05)
    return plane_figure(
        panels,
        None if dyad is None else spring_boundary(dyad, extent, "bare spring stable, free handles"),
        None if held is None else spring_boundary(held, extent, "its boundary with the handles held"),
        figure,
        reference=reference,
    )


def draw_account(
    trial: xr.Dataset,
    *,
    without_guard: xr.Dataset | None = None,
    axis: str | None = None,
    span: tuple[float, float] | None = None,
    title: str | None = None,
    figure: Figure | None = None,
) -> Figure:
    """Draw one trial under an energy account over time.

    `trial` has one trial of one condition of a rehearsal, or of a comparison, with the coordinates
    ``stiffness`` and ``delay``: ``account`` (J) over (time, robot), and what there is of ``position`` (m) and
    ``coupling_force`` (N) over (time, robot, axis) and ``target`` (m) over (time, axis). `without_guard` is
    the same trial under the bare spring, and `span` the times drawn, s, all by default. The positions are
    those along `axis`; by default the one on which a handle is farthest from the target, without the guard if
    that is given.
    """
    from telespring.show.figures.comparison_account import account_figure

    if title is None:
        title = f"{format_number(float(trial.stiffness))} N/m, {1e3 * float(trial.delay):.0f} ms"
    return account_figure(_account_trial(trial, without_guard, axis, span), title, figure)


def count_trials(one: xr.Dataset) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_]]:
    """Count per condition the trials that were run, those that ran away, and others that ended early."""
    status = one.status.transpose("condition", "trial").values
    ran_away = one.diverged.transpose("condition", "trial").values
    ended_early = (status > 0) & ~ran_away
    return (status >= 0).sum(axis=1), ran_away.sum(axis=1), ended_early.sum(axis=1)


def undelayed_errors(comparison: xr.Dataset, stiffness: float) -> tuple[float, float] | None:
    """Return the mean tracking errors of both under the bare spring without delay, m; None without them."""
    if "spring" not in comparison.architecture or "network" in comparison.dims:
        return None
    at = np.flatnonzero((comparison.stiffness.values == stiffness) & (comparison.delay.values == 0.0))
    if not len(at):
        return None
    errors = comparison.tracking_error.sel(architecture="spring").isel(condition=at[0])
    one, two = errors.transpose("trial", "robot").mean("trial").values.tolist()
    return (one, two) if np.isfinite([one, two]).all() else None


def _unconnected_errors(comparison: xr.Dataset) -> tuple[float, float]:
    """Return the mean tracking errors of both without a partner, m; NaN without a completed trial."""
    errors = comparison.tracking_error_unconnected.transpose(..., "robot").values
    one, two = _over_trials(np.mean, errors[None])[0].tolist()
    return one, two


def error_reference(one: xr.Dataset) -> Reference:
    """Say what errors on one network can be related to, at all its stiffnesses alike."""
    rehearsed = one.isel(condition=np.flatnonzero(one.is_rehearsed)) if "is_rehearsed" in one else one
    stiffnesses = np.unique(rehearsed.stiffness.values).tolist()
    if all(undelayed_errors(one, stiffness) is not None for stiffness in stiffnesses):
        return "undelayed"
    return "unconnected" if "tracking_error_unconnected" in one else "undelayed"


def _error_ratio(one: xr.Dataset, label: str, condition: int, reference: Reference) -> float:
    """Return the larger of both people's mean errors relative to what they have without delay or partner."""
    here = one.isel(condition=condition)
    if reference == "undelayed":
        related: tuple[float, float] | None = undelayed_errors(one, float(here.stiffness))
    else:
        related = _unconnected_errors(one)
    if related is None:
        return float("nan")
    errors = here.tracking_error.sel(architecture=label).transpose("trial", "robot").values
    return float(np.max(_over_trials(np.mean, errors[None])[0] / np.array(related)))


def spring_boundary(dyad: Dyad, extent: tuple[float, float], label: str) -> Boundary:
    """Compute where the bare spring is stable on all axes, up to a stiffness (N/m) and constant delay (s)."""
    from telespring.show.figures.comparison_plane import Boundary
    from telespring.show.figures.maps import HORIZON, MapColumn, stable_depth

    stiffness = np.linspace(0.0, extent[0], _COLUMNS + 1)[1:]
    delay = np.linspace(0.0, extent[1], _ROWS)
    depth = np.min(
        [
            stable_depth(
                [MapColumn(k, axis.stable_delays(k, HORIZON * extent[1])) for k in stiffness.tolist()], delay
            )
            for axis in dyad
        ],
        axis=0,
    )
    return Boundary(stiffness, delay, depth, label)


def _account_trial(
    trial: xr.Dataset,
    without_guard: xr.Dataset | None,
    axis: str | None,
    span: tuple[float, float] | None,
) -> AccountTrial:
    from telespring.show.figures.comparison_account import AccountTrial

    if span is not None:
        trial = trial.sel(time=slice(*span))
        without_guard = None if without_guard is None else without_guard.sel(time=slice(*span))
    if axis is None:
        axis = _farthest_axis(trial if without_guard is None else without_guard)
    stiffness = float(trial.stiffness)
    parts: dict[str, FloatArray] = {}
    limited = None
    balance = trial.account.transpose("time", "robot").values
    if "coupling_force" in trial:
        force = trial.coupling_force.transpose("time", "robot", "axis").values
        delivered = np.linalg.norm(force, axis=-1)
        energy = delivered**2 / (2.0 * stiffness)
        is_limited = (energy >= _WHOLE_ACCOUNT * balance) & (energy > 0.0)
        limited = (
            _intervals(trial.time.values, is_limited[:, 0]),
            _intervals(trial.time.values, is_limited[:, 1]),
        )
        parts |= {"delivered": delivered, "spring_energy": energy}
    if "position" in trial:
        position = trial.position.transpose("time", "robot", "axis").values
        apart = np.linalg.norm(position[:, 1] - position[:, 0], axis=-1)
        parts["intended"] = stiffness * np.repeat(apart[:, None], 2, axis=1)
        parts["position"] = trial.position.sel(axis=axis).transpose("time", "robot").values
        if "target" in trial:
            parts["target"] = trial.target.sel(axis=axis).values
        if without_guard is not None:
            parts["without_guard"] = without_guard.position.sel(axis=axis).transpose("time", "robot").values
    # More points than a reader can tell apart only make the figure larger.
    every = slice(None, None, max(1, len(balance) // _POINTS))
    drawn = {name: values[every] for name, values in parts.items()}
    return AccountTrial(trial.time.values[every], balance[every], limited=limited, axis=axis, **drawn)


def _intervals(time: FloatArray, chosen: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """List from when to when samples are chosen, half a sample more on both sides."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    half = 0.5 * float(time[1] - time[0])
    return [
        (float(time[first]) - half, float(time[end - 1]) + half)
        for first, end in zip(edges[::2], edges[1::2], strict=True)
    ]


def _farthest_axis(trial: xr.Dataset) -> str:
    """Name the axis on which a handle is farthest from the target, or from 0 where there is no target."""
    if "position" not in trial:
        return ""
    away = trial.position - trial.target if "target" in trial else trial.position
    farthest = np.abs(away).max(("time", "robot")).fillna(0.0).values
    return str(trial.axis.values[int(np.argmax(farthest))])


def _over_trials(statistic: Callable[[FloatArray], np.float64], errors: FloatArray) -> FloatArray:
    """Apply a statistic over the trials that have an error; NaN without any, (condition, robot)."""
    found = np.full((errors.shape[0], errors.shape[2]), np.nan)
    for place in np.ndindex(found.shape):
        values = errors[place[0], :, place[1]]
        values = values[np.isfinite(values)]
        if values.size:
            found[place] = statistic(values)
    return found


def _names(comparison: xr.Dataset, dimension: str) -> list[str]:
    return [str(name) for name in comparison[dimension].values]
