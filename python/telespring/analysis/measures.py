"""Measures of a trial: tracking error, interaction force, lag behind the target, effort and power."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.trials import Trials

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MEASURES", "measure", "measure_trials", "tracking_errors"]

#: Longest lag that is searched for, s; no person tracks a visible target with more.
_LONGEST_LAG = 1.0

#: Unit and meaning of every measure.
MEASURES = {
    "tracking_error": ("m", "mean distance to the target (Eq. 15)"),
    "interaction_force_rms": ("N", "root mean square of the coupling force"),
    "interaction_force_peak": ("N", "largest coupling force"),
    "lag": ("s", "lag of the robot behind the target"),
    "lag_correlation": ("1", "correlation with the target at that lag"),
    "effort_rms": ("N", "root mean square of the agent's force"),
    "power": ("W", "mean mechanical power delivered by the agent"),
}


def measure(dataset: xr.Dataset, discard: float | None = None) -> xr.Dataset:
    """Measure every trial: tracking error, interaction force, lag, effort and power.

    Parameters
    ----------
    dataset : xarray.Dataset
        Trials in the layout that `telespring.analysis.Trials.from_dataset` describes.
    discard : float, optional
        Duration to leave out at the start of every trial, s. Default: as recorded in the dataset.

    Returns
    -------
    xarray.Dataset
        Over (condition, trial, robot), with the labels of the trials as the dataset has them:
        ``tracking_error`` (m, Eq. 15), ``lag`` (s) with
        ``lag_correlation``; where the forces were recorded ``interaction_force_rms`` and
        ``interaction_force_peak`` (N) and ``effort_rms`` (N); with velocities also ``power`` (W). NaN for a
        trial that was not completed; ``status`` says why.

    Raises
    ------
    telespring.InvalidInput
        If the dataset does not hold such trials.

    Notes
    -----
    A force is measured by the length of its vector. The lag is the shift of the target that maximises
    Pearson's correlation with the robot's position, both axes together, each with its mean removed. All
    shifts up to 1 s either way are tried (up to half the target's period or a quarter of the analysed time
    where these are shorter), and a parabola through the best shift and its neighbours refines the result.
    On the paper's target sampled at 100 Hz, a known lag is recovered to 10 µs over five periods and to
    30 µs over two. The lag is NaN if the best shift is the last one tried, and if target or robot does not
    move. A robot whose phase differs between the target's frequencies has no single lag; the result is then
    the best compromise.

    Examples
    --------
    A robot that stays 3 mm from a target has that tracking error.

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
    return measure_trials(Trials.from_dataset(dataset, discard))


def measure_trials(trials: Trials) -> xr.Dataset:
    """Measure trials that are already checked and laid out as arrays; see `measure`."""
    import xarray as xr

    window = trials.window[..., None]
    count = window.sum(axis=2)

    def mean(values: FloatArray) -> FloatArray:
        return _mean_over_window(values, trials)

    measures = {"tracking_error": tracking_errors(trials)}
    if trials.coupling_force is not None:
        force = _vector_length(trials.coupling_force)
        measures["interaction_force_rms"] = np.sqrt(mean(force**2))
        peak = np.where(window, force, 0.0).max(axis=2)
        measures["interaction_force_peak"] = np.where(count > 0, peak, np.nan)
    measures["lag"], measures["lag_correlation"] = _lag_behind_target(trials)
    if trials.agent_force is not None:
        measures["effort_rms"] = np.sqrt(mean(_vector_length(trials.agent_force) ** 2))
        if trials.velocity is not None:
            measures["power"] = mean((trials.agent_force * trials.velocity).sum(axis=-1))
    dimensions = ("condition", "trial", "robot")
    per_trial = ("condition", "trial")
    variables: dict[str, Any] = {
        name: (dimensions, values, {"units": MEASURES[name][0], "long_name": MEASURES[name][1]})
        for name, values in measures.items()
    }
    # Labels as the data have them, so that results can be joined with the data.
    labels: dict[str, Any] = {}
    if trials.trial is not None:
        labels["trial"] = ("trial", trials.trial)
    elif trials.has_numbers:
        labels["trial_number"] = (per_trial, trials.numbers)
    if trials.dyads is not None:
        labels["dyad"] = (per_trial, trials.dyads)
    return xr.Dataset(
        variables | {"status": (per_trial, trials.status)},
        coords={
            "condition": ("condition", list(trials.labels)),
            "stiffness": ("condition", trials.stiffness, {"units": "N/m"}),
            "delay": ("condition", trials.delay, {"units": "s"}),
            "robot": ("robot", [1, 2]),
            **labels,
        },
        attrs={"discard": trials.discard},
    )


def tracking_errors(trials: Trials) -> FloatArray:
    """Return the tracking errors (Eq. 15) over (condition, trial, robot), m; NaN if not completed."""
    return _mean_over_window(_vector_length(trials.position - trials.target[..., None, :]), trials)


def _mean_over_window(values: FloatArray, trials: Trials) -> FloatArray:
    """Average values (condition, trial, time, robot) over the analysed samples."""
    window = trials.window[..., None]
    # 0/0 if a trial was not completed: that trial has no mean.
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(window, values, 0.0).sum(axis=2) / window.sum(axis=2))


def _vector_length(values: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(values[..., 0], values[..., 1]))


def _lag_behind_target(trials: Trials) -> tuple[FloatArray, FloatArray]:
    """Estimate the lag (s) of every robot and the correlation at that lag, (condition, trial, robot)."""
    shape = (*trials.status.shape, 2)
    lag, correlation = np.full(shape, np.nan), np.full(shape, np.nan)
    longest = _longest_lag_shifts(trials)
    for shift in np.unique(longest[longest >= 1]).tolist():
        # Trials that are searched over the same shifts share one convolution.
        group = longest == shift
        lags, correlations = _lag_within_shifts(trials, group, shift)
        lag[group], correlation[group] = lags[group], correlations[group]
    return lag, correlation


def _lag_within_shifts(
    trials: Trials, chosen: NDArray[np.bool_], longest: int
) -> tuple[FloatArray, FloatArray]:
    """Estimate lags of the chosen trials (condition, trial) from shifts of up to `longest` samples."""
    shape = (*trials.status.shape, 2)
    # Samples nearer to a trial's end than the longest shift have no shifted target to compare with; at
    # the start the discarded part provides it, as far as it reaches.
    last = trials.window.shape[-1] - trials.window[..., ::-1].argmax(axis=-1)
    index = np.arange(trials.window.shape[-1])
    window = trials.window & chosen[..., None] & (index >= longest) & (index < last[..., None] - longest)
    count: NDArray[np.int_] = np.asarray(window.sum(axis=-1))
    if not count.any():
        return np.full(shape, np.nan), np.full(shape, np.nan)
    weight = window[..., None].astype(float)
    target = np.where(np.isfinite(trials.target), trials.target, 0.0)
    # Far from zero, sums of squares would lose the target's own motion.
    target = target - target.mean(axis=2, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        # Sums of the shifted target over the window, (condition, trial, shift, axis), are the same for all
        # trials that share target and window.
        windows = window[count > 0]
        shared = bool(np.all(windows == windows[0]))
        target_weight, samples = (
            (windows[0][None, None, :, None].astype(float), count.max()) if shared else (weight, count)
        )
        total = _lagged_sums(target_weight, target, longest)
        spread = (
            _lagged_sums(target_weight, target**2, longest) - total**2 / np.asarray(samples)[..., None, None]
        )
        spread = np.asarray(spread.sum(axis=-1))
        correlation = np.empty((*shape, spread.shape[-1]))
        for robot in range(2):
            position = np.where(weight > 0.0, trials.position[..., robot, :], 0.0)
            mean = position.sum(axis=2, keepdims=True) / count[..., None, None]
            centred = np.where(weight > 0.0, position - mean, 0.0)
            product = _lagged_sums(centred, target, longest).sum(axis=-1)
            own = (centred**2).sum(axis=(2, 3))[..., None]
            # Below rounding nothing moves, and there is no correlation.
            still = (own < 1e-24 * count[..., None]) | (spread < 1e-24 * count[..., None])
            correlation[:, :, robot] = np.where(still, np.nan, product / np.sqrt(own * spread))
    return _lag_at_peak(correlation, trials.sample_period, longest)


def _longest_lag_shifts(trials: Trials) -> NDArray[np.int_]:
    """Return by how many samples the target is shifted at most in the lag search, (condition, trial)."""
    counts = trials.window.sum(axis=-1)
    # The longest trial resolves the target's period best.
    condition, trial = np.unravel_index(int(counts.argmax()), counts.shape)
    window = trials.window[condition, trial]
    if not window.any():
        return np.zeros(counts.shape, dtype=int)
    target = trials.trial_target(int(condition), int(trial))[window]
    power = (np.abs(np.fft.rfft(target - target.mean(axis=0), axis=0)) ** 2).sum(axis=1)
    period = len(target) / max(1, int(power.argmax()))
    return np.asarray(
        np.minimum(min(_LONGEST_LAG / trials.sample_period, period / 2.0), counts / 4.0), dtype=int
    )


def _lagged_sums(weights: FloatArray, values: FloatArray, longest: int) -> FloatArray:
    """Sum weights(t) values(t − shift) over t for shifts −longest to longest, along axis 2."""
    from scipy.signal import fftconvolve

    size = weights.shape[2]
    sums = fftconvolve(weights, np.flip(values, axis=2), axes=2)
    return np.asarray(sums[:, :, size - 1 - longest : size + longest])


def _lag_at_peak(correlation: FloatArray, step: float, longest: int) -> tuple[FloatArray, FloatArray]:
    """Refine the best shift by a parabola through its neighbours: lag (s) and correlation."""
    undefined: NDArray[np.bool_] = np.asarray(~np.isfinite(correlation).all(axis=-1))
    filled = np.where(undefined[..., None], 0.0, correlation)
    best = filled.argmax(axis=-1)
    inside = np.clip(best, 1, 2 * longest - 1)
    left, middle, right = (
        np.take_along_axis(filled, (inside + offset)[..., None], axis=-1)[..., 0] for offset in (-1, 0, 1)
    )
    curvature = left - 2.0 * middle + right
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = 0.5 * (left - right) / curvature
        height = middle - 0.25 * (left - right) * offset
    no_peak = undefined | (best != inside) | (curvature >= 0.0)
    return np.where(no_peak, np.nan, (inside + offset - longest) * step), np.where(no_peak, np.nan, height)
