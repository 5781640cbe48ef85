"""Delivered against intended force, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from telespring._types import FloatArray
from telespring.comparison.force_fidelity import (
    force_fidelity,
    force_frequencies,
    force_response,
    intended_force,
)

PERIOD = 0.01  # s
TIMES = PERIOD * np.arange(2400, dtype=np.float64)


def sines(frequencies: FloatArray, times: FloatArray, seed: int = 3) -> FloatArray:
    """Sum sines of one amplitude and different phases, (trial, time, robot, axis)."""
    phase = 2.0 * np.pi * np.random.default_rng(seed).random((2, 1, 2, 2, len(frequencies)))
    angle = 2.0 * np.pi * frequencies * times[None, :, None, None, None]
    return np.asarray(np.sin(angle + phase).sum(axis=-1))


def at(frequencies: FloatArray, wanted: FloatArray) -> list[int]:
    return [int(np.argmin(np.abs(frequencies - each))) for each in wanted]


@pytest.mark.parametrize("delay", [0.0, 0.0836, 0.3344])
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_ref_a_delayed_force_has_its_share_as_gain_and_a_phase_of_minus_omega_delta(
    delay: float, share: float
) -> None:
    lines: FloatArray = np.array([0.5, 1.25, 2.0, 4.0])  # Hz, whole periods in every segment of 12 s
    intended, delivered = sines(lines, TIMES), share * sines(lines, TIMES - delay)
    response = force_response(intended, delivered, PERIOD)
    places = at(response.frequency, lines)
    assert response.frequency[places] == pytest.approx(lines)
    # A Hann window leaks nothing of these lines into each other.
    assert response.gain[places] == pytest.approx(share, rel=1e-6)
    late = np.exp(-2j * np.pi * lines * delay)
    assert np.exp(1j * response.phase[places]) == pytest.approx(late, abs=1e-6)
    assert response.coherence[places] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("delay", [0.05, 0.5, 1.5])
def test_ref_the_gain_of_a_late_random_force_is_low_by_what_leaves_the_window(delay: float) -> None:
    shift, rng = round(delay / PERIOD), np.random.default_rng(11)
    force = rng.normal(size=(60, len(TIMES) + shift, 2, 2))
    response = force_response(force[:, shift:], force[:, : len(TIMES)], PERIOD)
    window = np.hanning(len(TIMES) // 2 + 1)[:-1]
    # E[S_xy]/E[S_xx] = Σ w(t) w(t + δ)/Σ w(t)² for a white force
    overlap = (window[shift:] * window[: len(window) - shift]).sum() / (window**2).sum()
    # The documented factor leaves out terms of higher order.
    assert 1.0 - overlap == pytest.approx(2.0 * np.pi**2 / 3.0 * (delay / 12.0) ** 2, rel=0.06)
    real = response.gain * np.cos(response.phase + 2.0 * np.pi * response.frequency * delay)
    # 240 frequencies, each from 240 channels of 3 segments
    assert np.median(real) == pytest.approx(overlap, abs=0.004)


def test_ref_the_coherence_of_a_force_with_independent_noise_is_its_share_of_the_power() -> None:
    rng = np.random.default_rng(5)
    force, noise = rng.normal(size=(2, 80, 2400, 2, 2))
    response = force_response(force, force + 0.5 * noise, PERIOD)
    assert np.median(response.coherence) == pytest.approx(1.0 / 1.25, abs=0.01)
    assert np.median(response.gain) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.2, 0.4])
def test_ref_the_variance_accounted_for_of_a_late_sine_is_2_cos_omega_delta_minus_1(delay: float) -> None:
    omega = 2.0 * np.pi * 1.25
    angle = omega * TIMES[:, None, None] + np.array([[0.0, 0.5 * np.pi], [1.0, 2.0]])
    fidelity = force_fidelity(3.0 * np.sin(angle), 3.0 * np.sin(angle - omega * delay))
    assert fidelity == pytest.approx(2.0 * np.cos(omega * delay) - 1.0, abs=1e-9)


def test_ref_a_share_of_the_force_leaves_the_square_of_the_rest_unaccounted() -> None:
    force = np.random.default_rng(2).normal(size=(4, 300, 2, 2))
    for share in (0.0, 0.3, 1.0, 2.0):
        assert force_fidelity(force, share * force) == pytest.approx(1.0 - (1.0 - share) ** 2)


def test_law_robots_are_apart_and_what_is_missing_has_no_fidelity() -> None:
    force = np.random.default_rng(2).normal(size=(300, 2, 2))
    given = force.copy()
    given[:, 1] = 0.0
    assert force_fidelity(force, given).tolist() == [1.0, 0.0]
    force[:, 0] = 0.0
    given[7, 1, 1] = np.nan
    assert np.isnan(force_fidelity(force, given)).all()


def test_cross_the_intended_force_is_that_of_the_spring_between_both_handles() -> None:
    rng = np.random.default_rng(9)
    position, velocity = rng.normal(size=(2, 3, 2, 2))
    force = intended_force(position, velocity, 71.2, 1.5)
    for i in range(3):
        for robot in range(2):
            for axis in range(2):
                stretch = position[i, 1 - robot, axis] - position[i, robot, axis]
                rate = velocity[i, 1 - robot, axis] - velocity[i, robot, axis]
                assert force[i, robot, axis] == pytest.approx(71.2 * stretch + 1.5 * rate, rel=1e-12)
    assert force.sum(axis=1) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("samples", [2, 3, 5, 40, 2400])
def test_law_the_frequencies_are_known_before_any_trial(samples: int) -> None:
    frequency = force_frequencies(samples, PERIOD)
    force = np.random.default_rng(4).normal(size=(2, samples, 2, 2))
    response = force_response(force, force, PERIOD)
    assert response.frequency.tolist() == frequency.tolist()
    assert response.gain.shape == frequency.shape
    assert (frequency > 0.0).all()
    assert (frequency <= 20.0).all()
