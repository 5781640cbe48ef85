"""A small comparison with plausible numbers, in the layout of `comparison.nc`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

LABELS = (
    "spring",
    "spring, adaptive",
    "guard",
    "guard + linear",
    "guard + kalman",
    "guard + shared-target",
    "injected-damping",
    "wave-variables",
    "time-domain-passivity",
    "two-layer",
    "set-position-modulation",
)
STIFFNESSES, DELAYS = (17.8, 35.6, 71.2, 142.5), (0.0, 0.0836, 0.1672, 0.3344)
#: How fast the error grows with stiffness and delay, per strategy; the shared target's only swings.
_COST = (1.0, 1.05, 1.0, 0.7, 0.35, 0.02, 1.1, 0.45, 1.0, 1.02, 1.2)
_PLACE = ("architecture", "network", "condition", "trial", "robot")


def made_comparison(
    labels: Sequence[str] = LABELS,
    stiffnesses: Sequence[float] = STIFFNESSES,
    delays: Sequence[float] = DELAYS,
    trials: int = 4,
    networks: Sequence[str] = ("study",),
) -> xr.Dataset:
    """Make a comparison in which the bare spring runs away at its largest product of stiffness and delay."""
    random = np.random.default_rng(7)
    conditions = [(k, delay) for k in stiffnesses for delay in delays]
    k, delay = np.array(conditions).T
    shape = (len(labels), len(networks), len(conditions), trials, 2)
    error = np.empty(shape)
    diverged, ended = np.zeros((2, *shape[:-1]), dtype=bool)
    for i, label in enumerate(labels):
        cost = _COST[LABELS.index(label)] if label in LABELS else 0.5
        growth = 1.0 + cost * 1.2 * (1.0 - np.exp(-k * delay / 12.0))
        if "shared" in label:
            growth = 1.0 - 0.15 * np.sin(12.0 * delay) + 0.25 * np.exp(-(((delay - 0.12) / 0.03) ** 2))
        if label.startswith("spring"):
            far = (k > 100.0) & (delay > 0.05) & (np.abs(delay - 0.167) > 0.02)
            growth = np.where(far, 9.0, growth)
            diverged[i] = far[None, :, None]
            ended[i, :, :, : trials // 2] = (far & (delay > 0.3))[None, :, None]
        error[i] = (0.022 * growth)[None, :, None, None] * np.array([1.0, 1.04])
    error *= 1.0 + 0.01 * random.normal(size=shape)
    error[ended] = np.nan
    limited = np.zeros(shape)
    guarded = [i for i, label in enumerate(labels) if label.startswith("guard")]
    limited[guarded] = np.clip(0.004 * (k * delay - 6.0), 0.0, 0.6)[None, None, :, None, None]
    time = np.arange(0.0, 29.1, 0.05)
    account = np.full((*shape[:3], len(time), 2), np.nan)
    for i in guarded:
        wave = 0.05 + 0.1 * np.sin(5.18 * time) ** 2
        account[i] = wave[:, None] * np.array([1.0, 0.9])
    safe = k * delay < 9.0
    return xr.Dataset(
        {
            "tracking_error": (_PLACE, error, {"units": "m"}),
            "diverged": (_PLACE[:-1], diverged),
            "ended_at": (_PLACE[:-1], np.where(ended, 14.0, np.nan), {"units": "s"}),
            "status": (_PLACE[:-1], ended.astype(np.int8)),
            "guard_overdraft": (("condition",), np.full(shape[2], 1e-4), {"units": "1"}),
            "is_rehearsed": (("network", "condition"), np.ones(shape[1:3], dtype=bool)),
            "tracking_error_unconnected": (
                ("trial", "robot"),
                np.broadcast_to([0.0219, 0.0241], (trials, 2)).copy(),
                {"units": "m"},
            ),
            "limited_share": (_PLACE, limited),
            "withheld_share": (_PLACE, 0.3 * limited),
            "force_fidelity": (_PLACE, np.where(np.isnan(error), np.nan, 0.9)),
            "coupling_energy": (_PLACE[:-1], np.where(diverged, -9.0, 2.0), {"units": "J"}),
            "coupling_energy_minimum": (_PLACE[:-1], np.where(diverged, -9.0, -0.01), {"units": "J"}),
            "account": (("architecture", "network", "condition", "time", "robot"), account, {"units": "J"}),
            "verdict": (
                _PLACE[:3],
                np.broadcast_to(np.where(safe, "stable", "unstable").astype(object), shape[:3]).copy(),
            ),
        },
        coords={
            "architecture": list(labels),
            "strategy": ("architecture", [label.split(" + ")[0].split(",")[0] for label in labels]),
            "predictor": (
                "architecture",
                [label.split(" + ")[1].split(",")[0] if " + " in label else "hold" for label in labels],
            ),
            "playout": ("architecture", ["adaptive" if "adaptive" in label else "fixed" for label in labels]),
            "network": list(networks),
            "condition": [f"CM-{one:.0f}-{1e3 * other:.0f}" for one, other in conditions],
            "stiffness": ("condition", k, {"units": "N/m"}),
            "delay": ("condition", delay, {"units": "s"}),
            "trial": np.arange(1, trials + 1),
            "time": ("time", time, {"units": "s"}),
            "robot": [1, 2],
        },
        attrs={"name": "two H-MANs"},
    )


def made_account_trial(scale: float = 1.0) -> xr.Dataset:
    """Make one guarded trial of 142.5 N/m over 84 ms, limited in a part of each period."""
    time = np.arange(0.0, 29.1, 0.01)
    target = np.stack([0.05 * np.sin(5.18 * time), 0.1 * np.sin(2.59 * time)], axis=-1)
    late = np.stack([0.05 * np.sin(5.18 * (time - 0.2)), 0.1 * np.sin(2.59 * (time - 0.22))], axis=-1)
    position = scale * np.stack([late, 0.95 * late], axis=1)
    force = 142.5 * (position[:, ::-1] - position) + 2.0
    energy = (force**2).sum(axis=-1) / (2.0 * 142.5)
    return xr.Dataset(
        {
            "position": (("time", "robot", "axis"), position, {"units": "m"}),
            "coupling_force": (("time", "robot", "axis"), force, {"units": "N"}),
            "target": (("time", "axis"), target, {"units": "m"}),
            "account": (("time", "robot"), np.maximum(energy, 0.04), {"units": "J"}),
        },
        coords={"time": time, "robot": [1, 2], "axis": ["x", "y"], "stiffness": 142.5, "delay": 0.0836},
    )


def made_conditions(comparison: xr.Dataset) -> list[dict[str, Any]]:
    """List the conditions of a comparison as `compare.json` does."""
    rows = []
    for architecture in comparison.architecture.values:
        for network in comparison.network.values:
            for condition in comparison.condition.values:
                here = comparison.sel(architecture=architecture, network=network, condition=condition)
                means, sds = (
                    1e3 * getattr(here.tracking_error, how)("trial").values for how in ("mean", "std")
                )
                rows.append(
                    {
                        "architecture": str(architecture),
                        "strategy": str(here.strategy.values),
                        "predictor": str(here.predictor.values),
                        "playout": str(here.playout.values),
                        "network": str(network),
                        "stiffness": float(here.stiffness),
                        "delay": float(here.delay),
                        "te1_mean": None if np.isnan(means[0]) else float(means[0]),
                        "te2_mean": None if np.isnan(means[1]) else float(means[1]),
                        "te1_sd": float(sds[0]),
                        "te2_sd": float(sds[1]),
                        "trials": comparison.sizes["trial"],
                        "diverged": int(here.diverged.sum()),
                        "limited_share": float(here.limited_share.mean()),
                        "withheld_share": float(here.withheld_share.mean()),
                        "force_fidelity": float(here.force_fidelity.mean()),
                        "coupling_energy_minimum": float(here.coupling_energy_minimum.min()),
                        "coupling_energy": float(here.coupling_energy.mean()),
                        "verdict": str(here.verdict.values),
                    }
                )
    return rows
