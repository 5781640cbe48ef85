"""Wrong statements of the paper on its experiment and on how it was evaluated."""

from __future__ import annotations

import math

import numpy as np

from telespring._json import finite_or_none
from telespring.identification.reweighting import paper_reweightings
from telespring.model import Dyad, Operator, hman
from telespring.paper import published
from telespring.paper.misprints.record import Evidence, Misprint
from telespring.references import read_reference

__all__ = [
    "wrong_statement_on_free_handles",
    "wrong_statement_on_spot_velocity",
    "wrong_statement_on_weights",
]

#: Forces (N) of equal samples, of which the weights leave one; the last is far from the others.
_FORCES = (0.9, 1.0, 1.05, 1.2, 3.0)
_ITERATIONS = 100
#: Appendix C, m/s.
_PRINTED_RANGE = 0.2


def wrong_statement_on_free_handles() -> Misprint:
    """Show how the stable delays change when the agents hold the handles."""
    free = hman()
    hand = Operator(stiffness=published.AGENT_STIFFNESS)
    held = Dyad(*free.robots, operators=(hand, hand))
    stiff, stiffer = published.EXPERIMENT_STIFFNESSES[-2:]
    evidence = [
        Evidence("stiffness of the agents", published.AGENT_STIFFNESS, "N/m"),
        Evidence("stiffness of the spring", stiff, "N/m"),
        *(
            Evidence(f"maximum delay there, axis {axis.name}, {what}", finite_or_none(maximum), "s")
            for what, dyad in (("free handles", free), ("held by agents", held))
            for axis in dyad
            for maximum in (float(axis.maximum_delay(stiff)),)
        ),
        Evidence("stiffness of the spring", stiffer, "N/m"),
    ]
    for axis in held:
        (_, lost), (back, _), *_ = axis.stable_delays(stiffer, 1.0)
        evidence += [
            Evidence(f"axis {axis.name}, held: unstable from a delay of", float(lost), "s"),
            Evidence(f"axis {axis.name}, held: stable again from", float(back), "s"),
        ]
    return Misprint(
        key="free-handles",
        where="Sections IV-D and VI against Eq. 1",
        printed="The experiment's conditions are stable, marginal or unstable by Eqs. 5 to 9.",
        true=(
            "Those are for free handles. In the experiment agents hold them, as springs to the ground. With "
            "these 71 N/m is stable at every constant delay, and 142 N/m loses stability and regains it."
        ),
        consequence=(
            "That tracking was worse at 71 N/m and 167 or 334 ms is put down to an instability that the held "
            "robots do not have."
        ),
        evidence=tuple(evidence),
    )


def wrong_statement_on_weights() -> Misprint:
    """Show how the weights leave one sample of five."""
    forces = np.array(_FORCES)
    *_, last = paper_reweightings(np.ones((len(forces), 1)), forces, (_ITERATIONS,))
    estimate = float(last.estimate[0])
    return Misprint(
        key="weights",
        where="Appendix B",
        printed="Weighted least squares with w = 1/(r² + ε), ε the floating-point accuracy.",
        true=(
            "Iterated, these weights minimise Σ log(r² + ε): the fit meets as many samples exactly as it has "
            "parameters, and all others count for nothing."
        ),
        consequence="The estimate hangs on a few samples, and its interval is as narrow as rounding.",
        evidence=(
            Evidence("forces whose size is estimated", float(len(forces)), "1"),
            Evidence("their median", float(np.median(forces)), "N"),
            Evidence(f"the estimate after {_ITERATIONS} iterations", estimate, "N"),
            Evidence("its distance from the nearest sample", float(np.abs(forces - estimate).min()), "N"),
            Evidence("effective number of samples", float(last.effective_samples), "1"),
        ),
    )


def wrong_statement_on_spot_velocity() -> Misprint:
    """Compare the range of the mean of the spots' velocities with that of one spot."""
    task = read_reference("du2025")["task"]
    spots, deviation = task["spots"], task["spot_velocity_standard_deviation"]["value"]
    error = deviation / math.sqrt(spots)
    return Misprint(
        key="spot-velocity",
        where="Appendix C against Section IV-C",
        printed="The velocity of each spot is in the 95 % range of the mean of all spots.",
        true=(
            "A single spot scatters more than three times as far: the mean of ten has its standard deviation "
            "(Section IV-C) divided by √10."
        ),
        consequence="Spots drawn by Appendix C make a cloud whose centre moves a third as fast.",
        evidence=(
            Evidence("range of a spot, as printed", _PRINTED_RANGE, "m/s"),
            Evidence("standard deviation of a spot's velocity", deviation, "m/s"),
            Evidence("standard error of the mean of all spots", error, "m/s"),
            Evidence("95 % range of the mean", 1.96 * error, "m/s"),
            Evidence("95 % range of a spot", 1.96 * deviation, "m/s"),
            Evidence(
                "deviation of the mean, were a spot's that of the mean", error / math.sqrt(spots), "m/s"
            ),
        ),
    )
