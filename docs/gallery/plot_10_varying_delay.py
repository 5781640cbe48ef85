"""
A delay that varies
===================

"k ≤ k_m is robust against unpredictable delays" holds for constant delays only. Here a network always
delivers the most harmful sample of the past to two equal robots. At k_m the motion grows; below half of k_m
no network can make it grow.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import expm

import telespring as ts

mass, damping, period = 1.0, 4.0, 0.001
critical = ts.critical_stiffness(mass, damping, mass, damping)


def attacked(stiffness: float, duration: float) -> np.ndarray:
    """Return the position of robot 1, m, when the partner's sample is the worst of all so far."""
    dynamics = np.array([[0, 1, 0], [-stiffness / mass, -damping / mass, stiffness / mass], [0, 0, 0]])
    step = expm(dynamics * period)
    swing = 4 * stiffness / mass - (damping / mass) ** 2
    half = (
        round(2 * np.pi / np.sqrt(swing) / period) if swing > 0 else round(duration / period)
    )  # ticks per half swing
    state, widest = np.array([0.01, 0.0]), 0.01
    course = []
    for tick in range(round(duration / period)):
        if tick % half == 0:  # the partner is the mirror image: its samples are these with the other sign
            widest = max([widest, *np.abs(course[-half:])])
            partner = -widest if tick // half % 2 == 0 else widest
        state = (step @ [*state, partner])[:2]
        course.append(state[0])
    return np.array(course)


figure, ax = plt.subplots(layout="constrained")
time = np.arange(0, 20, period)
for factor in (1.0, 0.75, 0.49):
    ax.plot(time, 1000 * attacked(factor * critical, 20.0), label=f"{factor:g} $k_m$", linewidth=1)
ax.set(
    xlabel="Time, s",
    ylabel="Position of robot 1, mm",
    title=f"Two robots of 1 kg and 4 N·s/m, $k_m$ = {critical:g} N/m",
)
ax.legend()

# %%
# Robot 2 is the mirror image of robot 1. The verdict "any network" gives b²/(4m), half of k_m, for free
# handles.

judged = ts.verdicts(ts.Dyad(ts.Robot(mass, damping), ts.Robot(mass, damping)), critical, 0.1)
bound = judged.tier("any network").stiffness_bound
print(f"any network: {bound:g} N/m")
assert np.isclose(bound, critical / 2)
assert np.isclose(critical, damping**2 / (2 * mass))
assert abs(attacked(critical, 20.0)).max() > 0.025
assert abs(attacked(0.49 * critical, 20.0)).max() <= 0.01 + 1e-9
