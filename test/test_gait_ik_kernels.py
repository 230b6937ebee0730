"""Inner loops of the differential IK against Pinocchio and NumPy."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from follower_humanoid.errors import PhysicsError
from follower_humanoid.gait.ik_kernels import damped_normal, solve_cholesky, turn_to


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-7, 1e-3, 0.5, 2.0, 3.1])
def test_the_turn_between_attitudes_is_the_logarithm(size: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(10):
        direction = rng.normal(size=3)
        vector = size * direction / np.linalg.norm(direction)
        now = pin.exp3(rng.normal(size=3))
        wanted = np.ascontiguousarray(pin.exp3(vector) @ now)
        np.testing.assert_allclose(turn_to(wanted, np.ascontiguousarray(now.T)), vector, atol=1e-12)


def test_the_damped_system_is_solved() -> None:
    rng = np.random.default_rng(2)
    for damping in (1e-4, 0.3):
        jacobian, rates = rng.normal(size=(18, 18)), rng.normal(size=18)
        jacobian[rng.random((18, 18)) < 0.4] = 0.0
        normal = jacobian @ jacobian.T + damping**2 * np.eye(18)
        solution = rates.copy()
        solve_cholesky(damped_normal(np.ascontiguousarray(jacobian.T), damping), solution)
        np.testing.assert_allclose(normal @ solution, rates, rtol=1e-6, atol=1e-8)


def test_numbers_that_are_none_are_told() -> None:
    with pytest.raises(PhysicsError):
        solve_cholesky(np.full((18, 18), np.nan), np.zeros(18))
