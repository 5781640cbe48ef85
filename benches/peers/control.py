"""python-control: the delay margin from the crossings of the undelayed loop k²/(P1 P2)."""

from __future__ import annotations

import control as peer
import numpy as np


def maximum_delay(m1: float, b1: float, m2: float, b2: float, k: float) -> float:
    loop = peer.tf([k * k], np.polymul([m1, b1, k], [m2, b2, k]))
    # negative feedback of -L: 1 - L(s) e^(-T s)
    _, margins, _, _, frequencies, _ = peer.stability_margins(-loop, returnall=True)
    delays = [
        np.deg2rad(margin % 360) / w / 2 for margin, w in zip(margins, frequencies, strict=True) if w > 0
    ]
    return float(min(delays, default=np.inf))
