"""Estimation and excitation: closed forms, laws and hostile data."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy import optimize

from telespring import InvalidInput
from telespring._types import FloatArray
from telespring.identification import (
    Excitation,
    design_excitation,
    identify,
    paper_excitation,
    paper_reweightings,
)
from telespring.identification.cutoff import choose_cutoff
from telespring.identification.regression import estimate_robustly

RATE = 1000.0
MASS, DAMPING, COULOMB, OFFSET = 0.8334, 7.7257, 0.6, -0.3


def movement(
    seconds: float = 20.0, lag: float = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    time = np.arange(round(seconds * RATE)) / RATE
    command = paper_excitation()
    return time, command.position(time - lag), command.velocity(time - lag), command.acceleration(time - lag)


def noisy_log(seed: int = 4) -> tuple[FloatArray, FloatArray, FloatArray]:
    time, p, v, a = movement()
    random = np.random.default_rng(seed)
    force = MASS * a + DAMPING * v + random.normal(0.0, 0.1, time.size)
    return time, p + random.normal(0.0, 5e-6, time.size), force


# ---- excitation


def test_ref_the_papers_series_is_velocity_and_its_integral_and_derivative_are_closed_forms(
    du2025: dict[str, Any],
) -> None:
    command = paper_excitation()
    amplitudes = du2025["excitation"]
    assert list(command.cosine) == amplitudes["A"]["values"]
    assert list(command.sine) == amplitudes["B"]["values"]
    time = np.linspace(0.0, command.period, 20001)
    direct = np.zeros(time.size)
    for i, (a, b) in enumerate(zip(command.cosine, command.sine, strict=True), start=1):
        angle = i * command.angular_frequency * time
        direct += a * np.cos(angle) + b * np.sin(angle)
    # rounding of a sum of ten terms
    np.testing.assert_allclose(command.velocity(time), direct, atol=1e-15)
    # central differences of step h err by h²/6 times the third derivative: 3e-8 of 2.4 m/s² at h = 0.25 ms
    np.testing.assert_allclose(np.gradient(command.position(time), time)[1:-1], direct[1:-1], atol=2e-6)
    np.testing.assert_allclose(np.gradient(direct, time)[1:-1], command.acceleration(time)[1:-1], atol=2e-5)
    assert abs(command.position(time[:-1]).mean()) < 1e-12


def test_ref_the_default_frequency_is_the_lowest_tenth_of_a_hertz_within_the_papers_workspace(
    du2025: dict[str, Any],
) -> None:
    reach = du2025["task"]["B"]["value"]
    assert paper_excitation().angular_frequency == pytest.approx(2 * math.pi * 0.2)
    assert paper_excitation().extremes().position <= reach
    assert paper_excitation(2 * math.pi * 0.1).extremes().position > reach


@pytest.mark.parametrize(("coulomb", "offset"), [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("limits", [(0.1, 0.5, 2.5), (0.05, 1.0, 10.0), (0.3, 0.2, 1.0)])
def test_law_a_designed_movement_is_within_its_limits_and_no_worse_than_the_papers(
    limits: tuple[float, float, float], coulomb: bool, offset: bool
) -> None:
    designed = design_excitation(*limits, coulomb=coulomb, offset=offset, starts=2)
    for reached, limit in zip(designed.extremes(), limits, strict=True):
        # extremes are taken on a fine grid
        assert reached <= limit * (1 + 1e-5)
    paper = paper_excitation()
    size = 1 / max(reached / limit for reached, limit in zip(paper.extremes(), limits, strict=True))
    scaled = Excitation(size * np.array(paper.cosine), size * np.array(paper.sine))
    scales = {"velocity_scale": limits[1], "acceleration_scale": limits[2]}
    for units in ({}, scales):
        mine = designed.condition_number(coulomb=coulomb, offset=offset, **units)
        # the designer compares on a coarser grid
        assert mine <= 1.02 * scaled.condition_number(coulomb=coulomb, offset=offset, **units)


@pytest.mark.parametrize("harmonics", [5, 6, 8])
def test_law_with_as_many_harmonics_as_the_papers_none_is_worse(harmonics: int) -> None:
    """With fewer it may be: the paper's movement is then no candidate, and the page says so."""
    kinds = {"coulomb": True, "offset": True}
    limits = paper_excitation().extremes()
    designed = design_excitation(*limits, harmonics=harmonics, starts=1)
    assert designed.condition_number(**kinds) <= 1.02 * paper_excitation().condition_number(**kinds)
    assert "With five harmonics or more" in (design_excitation.__doc__ or "")


def test_law_the_same_seed_designs_the_same_movement() -> None:
    assert design_excitation(starts=2) == design_excitation(starts=2)


def test_law_a_bad_excitation_is_refused_by_name() -> None:
    with pytest.raises(InvalidInput, match="position_limit"):
        design_excitation(0.0)
    with pytest.raises(InvalidInput, match="angular_frequency"):
        paper_excitation(-1.0)
    with pytest.raises(InvalidInput, match="cosine, sine"):
        Excitation([0.1, 0.2], [0.1])


# ---- estimation


@pytest.mark.parametrize("method", ["robust", "ols", "paper"])
def test_ref_a_log_without_noise_gives_the_parameters_back(method: Any) -> None:
    time, p, v, a = movement()
    force = MASS * a + DAMPING * v + OFFSET
    [axis] = identify(time, p, force, offset=True, method=method).axes
    # what the ends of the log leave after the cut: exp(-7.2) of the filter's transient, in a few samples
    assert axis.mass.value == pytest.approx(MASS, rel=1e-4)
    assert axis.damping.value == pytest.approx(DAMPING, rel=1e-4)
    assert axis.offset is not None
    assert axis.offset.value == pytest.approx(OFFSET, rel=1e-4)
    assert axis.r_squared == pytest.approx(1.0, abs=1e-6)


def test_law_coulomb_friction_is_told_from_viscous() -> None:
    time, p, v, a = movement()
    random = np.random.default_rng(2)
    force = MASS * a + DAMPING * v + COULOMB * np.sign(v) + random.normal(0.0, 0.1, time.size)
    [axis] = identify(time, p, force, coulomb=True).axes
    assert axis.coulomb is not None
    for estimate, truth in ((axis.mass, MASS), (axis.damping, DAMPING), (axis.coulomb, COULOMB)):
        # five standard errors
        assert abs(estimate.value - truth) < 5 * estimate.standard_error
    assert coulomb_free_warning(identify(time, p, force)) == ""
    # ruled out, it passes for damping, and the result says so
    blind = identify(time, p, force, coulomb=False, force_delay=0.0)
    assert blind.axes[0].damping.value > DAMPING + 1.0
    assert "--no-coulomb" in coulomb_free_warning(blind)


def coulomb_free_warning(found: Any) -> str:
    """Return the warnings that speak of friction."""
    return " ".join(warning for warning in found.warnings if "friction" in warning)


@pytest.mark.parametrize("cutoff", [0.9, 3.0, 30.0])
def test_law_the_filter_brings_no_bias(cutoff: float) -> None:
    """Even a cut-off inside the movement's band, up to 1 Hz: position and force lose the same."""
    time, p, v, a = movement(60.0)
    [axis] = identify(time, p, MASS * a + DAMPING * v, cutoff=cutoff).axes
    # what the ends of the log leave after the cut: exp(-7.2) of the filter's transient
    assert axis.mass.value == pytest.approx(MASS, rel=1e-3)
    assert axis.damping.value == pytest.approx(DAMPING, rel=1e-3)


def test_law_the_cutoff_lies_above_the_movement_and_below_the_noise() -> None:
    time, p, _ = noisy_log()
    highest = paper_excitation().highest_frequency
    assert highest < choose_cutoff(p, RATE) < 10 * highest
    # a faster movement gets a higher one
    fast = paper_excitation(10 * paper_excitation().angular_frequency).position(time)
    assert choose_cutoff(fast, RATE) == pytest.approx(10 * choose_cutoff(p, RATE), rel=0.1)


def test_law_outliers_move_least_squares_and_not_the_robust_fit() -> None:
    time, p, force = noisy_log()
    random = np.random.default_rng(9)
    bad = force.copy()
    # ten blows of 0.1 s, 6 N each, always with the movement
    speed = paper_excitation().velocity(time)
    for start in random.integers(1000, time.size - 1000, 10):
        bad[start : start + 100] += 6.0 * np.sign(speed[start : start + 100])
    clean = identify(time, p, force).axes[0]
    plain = identify(time, p, bad, method="ols").axes[0]
    robust = identify(time, p, bad).axes[0]
    error = clean.damping.standard_error
    assert abs(plain.damping.value - DAMPING) > 20 * error
    assert abs(robust.damping.value - DAMPING) < 5 * error
    assert abs(robust.mass.value - MASS) < 5 * clean.mass.standard_error
    # it did not retire to a few samples
    assert 0.7 < np.mean(robust.weights > 0.99) < 1.0


def test_cross_the_robust_fit_minimises_hampels_loss() -> None:
    """Against a general minimiser of the same loss at the same scale (scipy)."""
    import statsmodels.api as sm

    random = np.random.default_rng(1)
    regressor = random.normal(size=(300, 2))
    force = regressor @ [2.0, -1.0] + random.normal(0.0, 0.1, 300)
    force[:20] += 3.0
    fit = estimate_robustly(regressor, force)
    scale = float(sm.robust.scale.mad(fit.residual, center=0))
    norm = sm.robust.norms.Hampel(4.0, 6.0, 9.0)

    def loss(beta: FloatArray) -> float:
        return float(norm.rho((force - regressor @ beta) / scale).sum())

    found = optimize.minimize(loss, fit.estimate + 0.01, method="Nelder-Mead")
    # both stop at about 1e-5 of the parameters
    np.testing.assert_allclose(fit.estimate, found.x, atol=1e-3)


def test_law_the_papers_weights_collapse_on_two_samples() -> None:
    time, p, force = noisy_log()
    found = identify(time, p, force)
    signals = found.signals
    regressor = np.column_stack([signals.acceleration[0], signals.velocity[0]])
    steps = paper_reweightings(regressor, signals.force[0])
    losses = [step.log_loss for step in steps]
    # 1e-6: rounding of a sum of hundreds of logarithms
    assert all(later <= earlier + 1e-6 for earlier, later in itertools.pairwise(losses))
    assert steps[0].effective_samples == pytest.approx(signals.time.size)
    assert steps[-1].effective_samples == pytest.approx(2.0, abs=0.05)
    residual = np.abs(signals.force[0] - regressor @ steps[-1].estimate)
    # it passes through two samples exactly, and there are hundreds
    assert np.sum(residual < 1e-7) == 2
    # an interval of the width of rounding, far from the truth
    assert abs(steps[-1].estimate[0] - MASS) > 100 * steps[-1].half_width[0]


@pytest.mark.parametrize("late", [-0.003, 0.001, 0.01, 0.05])
def test_law_a_late_force_is_estimated_and_allowed_for(late: float) -> None:
    time, p, _, _ = movement()
    random = np.random.default_rng(5)
    _, _, v_late, a_late = movement(lag=late)
    force = MASS * a_late + DAMPING * v_late + random.normal(0.0, 0.1, time.size)
    found = identify(time, p, force)
    [axis] = found.axes
    shift = axis.time_shift
    assert shift is not None
    # four standard errors, of 0.5 ms
    assert abs(shift.value - late) < 4 * shift.standard_error
    assert shift.standard_error < 1e-3
    # told where it is larger than its errors
    told = [doubt.code for doubt in found.diagnostics]
    code = "late force" if shift.value > 0.0 else "late position"
    assert told == ([code] if abs(shift.value) > 2.576 * shift.standard_error else [])
    assert told or abs(late) < 0.003
    assert abs(axis.mass.value - MASS) < 4 * axis.mass.standard_error
    # a known lag narrows the interval of the mass
    corrected = identify(time, p, force, force_delay=late)
    assert corrected.warnings == ()
    assert abs(corrected.axes[0].mass.value - MASS) < 5 * corrected.axes[0].mass.standard_error
    assert corrected.axes[0].mass.standard_error < 0.7 * axis.mass.standard_error


def test_law_a_wrong_force_delay_is_told_with_what_the_log_says_itself() -> None:
    time, p, _, _ = movement()
    _, _, v_late, a_late = movement(lag=0.01)
    force = MASS * a_late + DAMPING * v_late + np.random.default_rng(5).normal(0.0, 0.1, time.size)
    [warning] = identify(time, p, force, force_delay=0.0).warnings
    assert "Leave out --force-delay for a mass of 0.83" in warning


def two_axes(cross: float, lag: float = 1.25, noise: float = 0.1, seed: int = 6) -> Any:
    time, p, v, a = movement()
    _, p2, v2, a2 = movement(lag=lag)
    random = np.random.default_rng(seed)
    force = np.column_stack([MASS * a + DAMPING * v + cross * a2, 1.2 * a2 + 9.0 * v2 + cross * a])
    return identify(time, np.column_stack([p, p2]), force + random.normal(0.0, noise, force.shape))


def test_law_axes_coupled_by_inertia_are_said_to_be_so() -> None:
    coupled = two_axes(0.1)
    assert coupled.independent is False
    # errors scatter by 0.002 kg: the means of eight by 0.0007
    means = np.mean(
        [[cross.inertia.value for cross in two_axes(0.1, seed=seed).cross_inertias] for seed in range(8)],
        axis=0,
    )
    np.testing.assert_allclose(means, 0.1, atol=2.5e-3)
    assert any("not independent" in warning for warning in coupled.warnings)
    alone = two_axes(0.0)
    assert alone.independent is True
    assert alone.warnings == ()
    # real, but too little to matter
    assert two_axes(0.005).independent is True


def test_law_noise_does_not_couple_axes() -> None:
    """One pair in a thousand may be called coupled by chance; here are ten."""
    found = [two_axes(0.0, noise=10.0, seed=seed) for seed in range(5)]
    assert all(each.independent for each in found)
    assert max(abs(cross.inertia.value) for each in found for cross in each.cross_inertias) > 0.05


def test_law_axes_that_move_alike_cannot_be_told_apart() -> None:
    alike = two_axes(0.1, lag=0.0)
    assert alike.independent is None
    assert any("cannot show whether the axes are independent" in warning for warning in alike.warnings)


def test_law_scaling_units_scales_estimates() -> None:
    time, p, force = noisy_log()
    one = identify(time, p, force).axes[0]
    ten = identify(time, p, 10.0 * force).axes[0]
    # rounding
    assert ten.mass.value == pytest.approx(10.0 * one.mass.value, rel=1e-9)
    assert ten.mass.interval == pytest.approx([10.0 * end for end in one.mass.interval], rel=1e-6)


def test_law_a_standing_or_single_tone_movement_is_refused_or_told() -> None:
    time, p, force = noisy_log()
    with pytest.raises(InvalidInput, match="50 steps of its sensor"):
        identify(time, np.round(p, 2), force)
    with pytest.raises(InvalidInput, match="Record longer"):
        identify(time[:900], p[:900], force[:900], cutoff=5.0)


# ---- what the model leaves out


def two_robots(
    *,
    friction: tuple[float, float] = (0.0, 0.0),
    offset: float = 0.0,
    cross: float = 0.0,
    lag: tuple[float, float] = (0.0, 0.0),
    seed: int = 1,
    **asked: Any,
) -> Any:
    """Identify 0.9 and 1.2 kg, 8 and 9 N·s/m; y moves a quarter of a period later."""
    time = np.arange(20000) / RATE
    random = np.random.default_rng(seed)
    command = paper_excitation()
    positions, forces = [], []
    for i, (mass, damping) in enumerate(((0.9, 8.0), (1.2, 9.0))):
        own, other = time - 1.25 * i - lag[i], time - 1.25 * (1 - i) - lag[i]
        velocity = command.velocity(own)
        positions.append(np.round(command.position(time - 1.25 * i) / 2e-5) * 2e-5)
        forces.append(
            mass * command.acceleration(own)
            + damping * velocity
            + friction[i] * np.sign(velocity)
            + cross * command.acceleration(other)
            + offset
            + random.normal(0.0, 0.1, time.size)
        )
    return identify(time, np.column_stack(positions), np.column_stack(forces), **asked)


def test_law_friction_and_an_offset_are_found_and_are_no_coupling() -> None:
    found = two_robots(friction=(0.5, 0.3), offset=2.0)
    assert found.independent is True
    assert found.warnings == ()
    for axis, friction, damping in zip(found.axes, (0.5, 0.3), (8.0, 9.0), strict=True):
        assert abs(axis.coulomb.value - friction) < 4 * axis.coulomb.standard_error
        assert abs(axis.damping.value - damping) < 4 * axis.damping.standard_error
        assert abs(axis.offset.value - 2.0) < 4 * axis.offset.standard_error
    blind = two_robots(friction=(0.5, 0.3), offset=2.0, coulomb=False, force_delay=0.0)
    # it is the damping that takes it
    assert blind.axes[0].damping.value > 9.5
    told = " ".join(blind.warnings)
    assert "Axis x: the log has friction of 0.5 N" in told
    assert "Leave out --no-coulomb for a mass of 0.9" in told
    assert "damping of 8.0" in told


def test_law_a_lag_and_coupled_axes_are_told_apart() -> None:
    coupled = two_robots(cross=0.15)
    assert coupled.independent is False
    assert not any("--force-delay" in warning for warning in coupled.warnings)
    late = two_robots(lag=(0.03, 0.03))
    assert late.independent is True
    assert [doubt.code for doubt in late.diagnostics] == ["late force"]
    for axis, mass in zip(late.axes, (0.9, 1.2), strict=True):
        # within 1 ms: the noise gives 0.3 ms
        assert axis.time_shift.value == pytest.approx(0.03, abs=1e-3)
        assert abs(axis.mass.value - mass) < 4 * axis.mass.standard_error
    both = two_robots(cross=0.15, lag=(0.02, 0.02), friction=(0.5, 0.3))
    assert both.independent is False
    for cross, axis in zip(both.cross_inertias, both.axes, strict=True):
        assert cross.inertia.value == pytest.approx(0.15, abs=0.01)
        assert axis.time_shift.value == pytest.approx(0.02, abs=2e-3)


def test_law_axes_with_lags_of_their_own_are_told_and_allowed_for() -> None:
    found = two_robots(lag=(0.03, -0.03))
    [told] = found.warnings
    assert "The axes disagree about the lag of the force (x and y: 30 ms and -30 ms)" in told.replace(
        "31 ms", "30 ms"
    )
    for axis, mass in zip(found.axes, (0.9, 1.2), strict=True):
        assert abs(axis.mass.value - mass) < 4 * axis.mass.standard_error
