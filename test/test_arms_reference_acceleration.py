"""The desired acceleration of the arms: a derivative through a low-pass, for which a switch is no motion."""

from __future__ import annotations

import numpy as np

from follower_humanoid.control.reference_acceleration import ReferenceAcceleration
from follower_humanoid.sensing.low_pass import LowPass

TICK = 0.002


def test_it_is_the_low_passed_derivative_from_rest() -> None:
    velocity = np.random.default_rng(1).normal(size=(20, 2, 7))
    acceleration, low_pass = ReferenceAcceleration(0.01, TICK), LowPass(0.01, TICK)
    for before, now in zip([velocity[0], *velocity], velocity, strict=False):
        expected = low_pass.step((now - before) / TICK)
        np.testing.assert_array_equal(acceleration.step(now, None), expected)


def test_without_a_filter_it_is_the_derivative() -> None:
    acceleration = ReferenceAcceleration(0.0, TICK)
    for tick in range(5):
        found = acceleration.step(np.full((2, 7), 3.0 * TICK * tick), None)
    np.testing.assert_allclose(found, 3.0)


def test_an_arm_whose_law_changes_begins_at_rest_and_the_other_goes_on() -> None:
    acceleration, speed = ReferenceAcceleration(0.01, TICK), np.zeros((2, 7))
    for tick in range(50):
        acceleration.step(speed + TICK * tick, None)
    found = acceleration.step(speed + 9.0 * np.array([[1.0], [0.0]]) + TICK * 50, np.array([True, False]))
    np.testing.assert_array_equal(found[0], 0.0)
    np.testing.assert_allclose(found[1], 1.0, rtol=1e-3)
