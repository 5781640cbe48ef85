"""What a trial is measured by: tracking error, interaction force, lag and effort."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.trials import Trials, take_trials

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LONGEST_LAG", "measure", "measure_trials"]

#: Longest lag searched for, s: longer than any visual tracking lag of a person.
LONGEST_LAG = 1.0

_UNITS = {
    "tracking_error": ("m", "mean distance to the target (Eq. 15)"),
    "interaction_force_rms": ("N", "root mean square of the coupling force"),
    "interaction_force_peak": ("N", "largest coupling force"),
    "lag": ("s", "by how much the robot is later than the target"),
    "lag_correlation": ("1", "correlation with the target at that lag"),
    "effort_rms": ("N", "root mean square of the agent's force"),
    "power": ("W", "mean mechanical power that the agent puts in"),
}


def measure(dataset: xr.Dataset, discard: float | None = None) -> xr.Dataset:
    """Measure every trial.

    Parameters
    ----------
    dataset : xarray.Dataset
        Trials, as `telespring.analysis.take_trials` describes them.
    discard : float, optional
        First part of every trial to leave out, s; the dataset's own unless given.

    Returns
    -------
    xarray.Dataset
        Over (condition, trial, robot): ``tracking_error`` (m, Eq. 15), ``lag`` (s) with
        ``lag_correlation``, and where the forces were recorded ``interaction_force_rms`` and
        ``interaction_force_peak`` (N), ``effort_rms`` (N) and, with velocities, ``power`` (W). NaN for a
        trial that was not completed; ``status`` says why.

    Raises
    ------
    telespring.InvalidInput
        Where the dataset holds no such trials.

    Notes
    -----
    A force is the length of its vector. The lag is the shift of the target at which it correlates best
    with the robot's position: Pearson's correlation, both axes together, each with its own mean taken
    off, over all shifts up to 1 s (half the target's period or a quarter of the analysed time where these
    are shorter) either way, refined by a parabola through the best shift and its neighbours. On the
    paper's target sampled at 100 Hz that finds a known lag to 10 µs over five periods and to 30 µs over
    two. It is NaN where the best shift is the last one tried, and where target or robot rests. A robot
    that rounds off or overshoots the target at one frequency more than at another has no single lag; what
    is given then is the best one.

    Examples
    --------
    A robot that stays 3 mm beside a target has that tracking error.

    >>> import numpy as np, xarray as xr
    >>> time = np.arange(0.0, 10.0, 0.01)
    >>> target = np.stack([np.sin(5.0 * time), np.cos(2.5 * time)], axis=-1)
    >>> beside = target[None, None, :, None, :] + np.array([[0.003, 0.0], [0.0, -0.003]])
    >>> trials = xr.Dataset(
    ...     {"position": (("condition", "trial", "time", "robot", "axis"), beside),
    ...      "target": (("time", "axis"), target)},
    ...     coords={"stiffness": ("condition", [np.nan]), "delay": ("condition", [0.0]), "time": time},
    ... )
    >>> measure(trials)["tracking_error"].values.round(6).tolist()
    [[[0.003, 0.003]]]
    """
    return measure_trials(take_trials(dataset, discard))


def measure_trials(trials: Trials) -> xr.Dataset:
    """Measure trials that were checked already; see `measure`.

    Parameters
    ----------
    trials
        As `take_trials` gives them.

    Returns
    -------
    xarray.Dataset
        As `measure`.
    """
    import xarray as xr

    window = trials.window[..., None]
    count = window.sum(axis=2)
    found: dict[str, FloatArray] = {}

    def mean(values: FloatArray) -> FloatArray:
        # 0/0 where a trial was not completed: that trial has no mean.
        with np.errstate(invalid="ignore"):
            return np.asarray(np.where(window, values, 0.0).sum(axis=2) / count)

    def length(values: FloatArray) -> FloatArray:
        return np.asarray(np.hypot(values[..., 0], values[..., 1]))

    found["tracking_error"] = mean(length(trials.position - trials.target[..., None, :]))
    if trials.coupling_force is not None:
        force = length(trials.coupling_force)
        found["interaction_force_rms"] = np.sqrt(mean(force**2))
        peak = np.where(window, force, 0.0).max(axis=2)
        found["interaction_force_peak"] = np.where(count > 0, peak, np.nan)
    found["lag"], found["lag_correlation"] = _lag(trials)
    if trials.agent_force is not None:
        found["effort_rms"] = np.sqrt(mean(length(trials.agent_force) ** 2))
        if trials.velocity is not None:
            found["power"] = mean((trials.agent_force * trials.velocity).sum(axis=-1))
    dimensions = ("condition", "trial", "robot")
    variables: dict[str, Any] = {
        name: (dimensions, values, {"units": _UNITS[name][0], "long_name": _UNITS[name][1]})
        for name, values in found.items()
    }
    return xr.Dataset(
        variables | {"status": (("condition", "trial"), trials.status)},
        coords={
            "condition": ("condition", list(trials.labels)),
            "stiffness": ("condition", trials.stiffness, {"units": "N/m"}),
            "delay": ("condition", trials.delay, {"units": "s"}),
            "robot": ("robot", [1, 2]),
        },
        attrs={"discard": trials.discard},
    )


def _lag(trials: Trials) -> tuple[FloatArray, FloatArray]:
    """Find lag (s) and correlation there, (condition, trial, robot)."""
    shape = (*trials.status.shape, 2)
    lag, height = np.full(shape, np.nan), np.full(shape, np.nan)
    step = float(np.median(np.diff(trials.time)))
    longest = _longest_shifts(trials, step)
    for shift in np.unique(longest[longest >= 1]).tolist():
        same = longest == shift
        lag[same], height[same] = (each[same] for each in _lag_within(trials, same, shift, step))
    return lag, height


def _lag_within(
    trials: Trials, chosen: NDArray[np.bool_], longest: int, step: float
) -> tuple[FloatArray, FloatArray]:
    """Find lags of up to so many samples of the chosen trials (condition, trial)."""
    shape = (*trials.status.shape, 2)
    nothing = np.full(shape, np.nan), np.full(shape, np.nan)
    # Samples nearer to a trial's end than the longest shift have no shifted target to compare with; at
    # the start the discarded part holds it, as far as that goes.
    last = trials.window.shape[-1] - trials.window[..., ::-1].argmax(axis=-1)
    index = np.arange(trials.window.shape[-1])
    window = trials.window & chosen[..., None] & (index >= longest) & (index < last[..., None] - longest)
    count: NDArray[np.int_] = np.asarray(window.sum(axis=-1))
    if not count.any():
        return nothing
    weight = window[..., None].astype(float)
    known = np.where(np.isfinite(trials.target), trials.target, 0.0)
    # Far from zero, sums of squares would lose the target's own motion.
    known = known - known.mean(axis=2, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        # (condition, trial, shift, axis): sums over the window of the target shifted, which are the
        # same for all trials that share target and window.
        alike = window[count > 0]
        shared = bool(np.all(alike == alike[0]))
        once, samples = (
            (alike[0][None, None, :, None].astype(float), count.max()) if shared else (weight, count)
        )
        total = _shifted_sums(once, known, longest)
        spread = _shifted_sums(once, known**2, longest) - total**2 / np.asarray(samples)[..., None, None]
        spread = np.asarray(spread.sum(axis=-1))
        correlation = np.empty((*shape, spread.shape[-1]))
        for robot in range(2):
            position = np.where(weight > 0.0, trials.position[..., robot, :], 0.0)
            middle = position.sum(axis=2, keepdims=True) / count[..., None, None]
            centred = np.where(weight > 0.0, position - middle, 0.0)
            product = _shifted_sums(centred, known, longest).sum(axis=-1)
            own = (centred**2).sum(axis=(2, 3))[..., None]
            # Below rounding nothing moves, and nothing correlates.
            rests = (own < 1e-24 * count[..., None]) | (spread < 1e-24 * count[..., None])
            correlation[:, :, robot] = np.where(rests, np.nan, product / np.sqrt(own * spread))
    return _peak(correlation, step, longest)


def _longest_shifts(trials: Trials, step: float) -> NDArray[np.int_]:
    """Give the samples by which the target is shifted at most, (condition, trial)."""
    counts = trials.window.sum(axis=-1)
    # The target's period is seen best over the longest trial.
    condition, trial = np.unravel_index(int(counts.argmax()), counts.shape)
    window = trials.window[condition, trial]
    if not window.any():
        return np.zeros(counts.shape, dtype=int)
    goal = trials.target[condition % trials.target.shape[0], trial % trials.target.shape[1]][window]
    power = (np.abs(np.fft.rfft(goal - goal.mean(axis=0), axis=0)) ** 2).sum(axis=1)
    period = len(goal) / max(1, int(power.argmax()))
    return np.asarray(np.minimum(min(LONGEST_LAG / step, period / 2.0), counts / 4.0), dtype=int)


def _shifted_sums(weights: FloatArray, values: FloatArray, longest: int) -> FloatArray:
    """Sum weights(t) values(t − shift) over t for shifts −longest to longest, along axis 2."""
    from scipy.signal import fftconvolve

    size = weights.shape[2]
    whole = fftconvolve(weights, np.flip(values, axis=2), axes=2)
    return np.asarray(whole[:, :, size - 1 - longest : size + longest])


def _peak(correlation: FloatArray, step: float, longest: int) -> tuple[FloatArray, FloatArray]:
    undefined: NDArray[np.bool_] = np.asarray(~np.isfinite(correlation).all(axis=-1))
    filled = np.where(undefined[..., None], 0.0, correlation)
    best = filled.argmax(axis=-1)
    inside = np.clip(best, 1, 2 * longest - 1)
    left, middle, right = (
        np.take_along_axis(filled, (inside + offset)[..., None], axis=-1)[..., 0] for offset in (-1, 0, 1)
    )
    bend = left - 2.0 * middle + right
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = 0.5 * (left - right) / bend
        height = middle - 0.25 * (left - right) * offset
    lost = undefined | (best != inside) | (bend >= 0.0)
    return np.where(lost, np.nan, (inside + offset - longest) * step), np.where(lost, np.nan, height)
