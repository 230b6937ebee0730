"""Sliding mode with boundary layer: sign, bounds, disturbance estimate, rest at saturation."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.control.sliding_mode import SlidingMode, SlidingModeConfig
from follower_humanoid.core.samples import Array

DT = 0.002
FREE = np.zeros(1, dtype=bool)
CONFIG = SlidingModeConfig()


def accelerate(mode: SlidingMode, error: float, rate: float = 0.0, **values: object) -> float:
    arguments = {
        "error": np.array([error]),
        "error_velocity": np.array([rate]),
        "feedforward": np.zeros(1),
        "weight": np.ones(1),
        "saturated": FREE,
        "dt": DT,
    }
    return float(mode.acceleration(**{**arguments, **values})[0])  # type: ignore[arg-type]


def test_error_is_desired_minus_measured() -> None:
    # A joint behind its reference is accelerated forward.
    assert accelerate(SlidingMode(CONFIG, 1), 0.01) > 0.0
    assert accelerate(SlidingMode(CONFIG, 1), 0.0, 0.1) > 0.0
    assert accelerate(SlidingMode(CONFIG, 1), -0.01) < 0.0


def test_the_law_term_by_term() -> None:
    config = SlidingModeConfig(slope=20, reaching=40, switching=10, boundary=0.3, estimator=0.0)
    error, rate = 0.004, 0.05
    s = rate + 20 * error
    expected = 7.0 + 0.5 * (20 * rate + 40 * s + 10 * s / 0.3)
    found = accelerate(
        SlidingMode(config, 1), error, rate, feedforward=np.array([7.0]), weight=np.array([0.5])
    )
    assert found == pytest.approx(expected)


def test_the_switching_term_is_continuous_and_bounded() -> None:
    config = SlidingModeConfig(slope=0.0, reaching=0.0, switching=10.0, boundary=0.3, estimator=0.0)
    rates = np.linspace(-1.0, 1.0, 401)
    values = np.array([accelerate(SlidingMode(config, 1), 0.0, rate) for rate in rates])
    inside = np.abs(rates) <= 0.3
    np.testing.assert_allclose(values[inside], 10.0 * rates[inside] / 0.3, atol=1e-12)
    np.testing.assert_allclose(values[~inside], 10.0 * np.sign(rates[~inside]), atol=1e-12)


def test_weight_zero_leaves_the_feedforward() -> None:
    mode = SlidingMode(CONFIG, 2)
    a = mode.acceleration(
        np.ones(2), np.ones(2), np.array([3.0, -3.0]), np.zeros(2), np.zeros(2, dtype=bool), DT
    )
    np.testing.assert_array_equal(a, [3.0, -3.0])


def test_the_estimate_grows_with_s_and_stays_bounded() -> None:
    mode = SlidingMode(CONFIG, 1)
    accelerate(mode, 0.01)
    assert mode.estimate[0] == pytest.approx(CONFIG.estimator * DT * CONFIG.slope * 0.01)
    for _ in range(1000):
        accelerate(mode, 1.0)
    assert mode.estimate[0] == CONFIG.estimate_limit
    for _ in range(2000):
        accelerate(mode, -1.0)
    assert mode.estimate[0] == -CONFIG.estimate_limit


def test_the_estimate_rests_where_the_motor_saturates_and_only_there() -> None:
    mode = SlidingMode(CONFIG, 2)
    error = np.array([0.01, 0.01])
    for _ in range(10):
        mode.acceleration(error, np.zeros(2), np.zeros(2), np.ones(2), np.array([False, True]), DT)
    assert mode.estimate[0] > 0.0
    assert mode.estimate[1] == 0.0


def follow(
    disturbance: float, seconds: float = 3.0, start: float = 0.0, **values: float
) -> tuple[Array, Array]:
    """Errors and estimates of a joint that obeys q̈ = a + disturbance along a moving reference."""
    mode = SlidingMode(SlidingModeConfig(**values), 1)
    position, velocity = start, 1.0
    errors, estimates = [], []
    for tick in range(round(seconds / DT)):
        t = tick * DT
        wanted, rate, feedforward = np.sin(t), np.cos(t), -np.sin(t)
        errors.append(wanted - position)
        a = accelerate(mode, wanted - position, rate - velocity, feedforward=np.array([feedforward]))
        velocity += DT * (a + disturbance)
        position += DT * velocity
        estimates.append(mode.estimate[0])
    return np.array(errors), np.array(estimates)


@pytest.mark.parametrize("disturbance", [0.0, 8.0, -20.0])
def test_the_estimate_takes_up_a_disturbance_and_the_error_goes(disturbance: float) -> None:
    errors, estimates = follow(disturbance, seconds=6.0)
    # Inside the boundary layer: d̂ → −d at the rate l/(k + η/φ).
    rate = CONFIG.estimator / (CONFIG.reaching + CONFIG.switching / CONFIG.boundary)
    for seconds in (1.0, 3.0, 5.9):
        expected = -disturbance * (1.0 - np.exp(-rate * seconds))
        assert estimates[round(seconds / DT)] == pytest.approx(expected, abs=0.03 * abs(disturbance) + 0.05)
    left = abs(disturbance) * np.exp(-rate * 6.0) / (CONFIG.reaching + CONFIG.switching / CONFIG.boundary)
    assert abs(errors[-1]) < 1.2 * left / CONFIG.slope + 1e-4


def test_a_joint_far_away_reaches_its_moving_reference() -> None:
    errors, _ = follow(0.0, start=0.3)
    assert np.abs(errors[:2]).max() > 0.29
    assert np.abs(errors[-100:]).max() < 0.01


def test_without_the_estimate_a_disturbance_leaves_an_error_inside_the_boundary_layer() -> None:
    errors, estimates = follow(8.0, estimator=0.0)
    assert np.all(estimates == 0.0)
    assert np.abs(errors[-500:]).max() > 4e-3
    # Inside the boundary layer: |s| ≤ φ, so |e| ≤ φ/λ.
    assert np.abs(errors[-500:]).max() < 0.3 / 20.0


def test_the_estimate_can_be_switched_off() -> None:
    mode = SlidingMode(SlidingModeConfig(estimate=False), 1)
    first = accelerate(mode, 0.01)
    assert accelerate(mode, 0.01) == first
    np.testing.assert_array_equal(mode.estimate, np.zeros(1))
    assert first == accelerate(SlidingMode(SlidingModeConfig(estimator=0.0), 1), 0.01)
