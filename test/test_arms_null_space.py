"""Inverse of the hand's Jacobian: eq. (6), projector, bounds near singularities."""

from __future__ import annotations

import numpy as np
import pytest
from arms_bench import random_jacobians

from follower_humanoid.control.null_space import TaskInverse, joint_reference, joint_velocity, task_inverse

THRESHOLD, DAMPING = 0.08, 0.05


def test_away_from_singularities_it_is_the_right_pseudo_inverse() -> None:
    jacobian = random_jacobians(1)
    inverse, null = task_inverse(jacobian, THRESHOLD, DAMPING)
    transposed = jacobian.swapaxes(-1, -2)
    np.testing.assert_allclose(inverse, transposed @ np.linalg.inv(jacobian @ transposed), atol=1e-10)
    np.testing.assert_allclose(jacobian @ null, 0, atol=1e-12)
    np.testing.assert_allclose(null @ null, null, atol=1e-12)
    np.testing.assert_allclose(null, null.swapaxes(-1, -2), atol=1e-12)
    np.testing.assert_allclose(np.trace(null, axis1=1, axis2=2), 4.0, atol=1e-10)


def test_equation_6_moves_the_hand_as_asked_whatever_the_null_space_wants() -> None:
    jacobian, rng = random_jacobians(2), np.random.default_rng(2)
    inverse, null = task_inverse(jacobian, THRESHOLD, DAMPING)
    wanted = rng.normal(size=(len(jacobian), 3, 1))
    one, other = rng.normal(size=(2, len(jacobian), 7, 1))
    velocity = inverse @ wanted + null @ one
    np.testing.assert_allclose(jacobian @ velocity, wanted, atol=1e-11)
    np.testing.assert_allclose(jacobian @ (null @ (other - one)), 0, atol=1e-11)


def gain(sigma: float, threshold: float, damping: float) -> float:
    """Of a direction with a singular value, beside two that are far from singular."""
    jacobian = np.zeros((3, 7))
    jacobian[0, 0] = jacobian[1, 1] = 0.4
    jacobian[2, 2] = sigma
    return float(task_inverse(jacobian[None], threshold, damping).inverse[0, 2, 2])


def largest_gain(threshold: float, damping: float) -> float:
    if damping > threshold / np.sqrt(2.0):
        return 1.0 / threshold
    return float(1.0 / (2.0 * damping * np.sqrt(1.0 - (damping / threshold) ** 2)))


@pytest.mark.parametrize("damping", [0.01, 0.03, DAMPING, 0.0565, 0.06, 0.08, 0.2])
def test_the_largest_gain_is_what_the_docstring_says(damping: float) -> None:
    gains = [gain(sigma, THRESHOLD, damping) for sigma in np.linspace(0.0, 0.2, 4001)]
    assert max(gains) == pytest.approx(largest_gain(THRESHOLD, damping), rel=1e-5)
    assert largest_gain(THRESHOLD, DAMPING) == pytest.approx(12.81, abs=0.01)


def test_bounded_at_and_near_singularities() -> None:
    rng = np.random.default_rng(3)
    left, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    right, _ = np.linalg.qr(rng.normal(size=(7, 3)))
    for smallest in (0.0, 1e-12, 1e-6, 1e-3, 0.02, 0.079):
        jacobian = left @ np.diag([0.5, 0.3, smallest]) @ right.T
        inverse, null = (stack[0] for stack in task_inverse(jacobian[None], THRESHOLD, DAMPING))
        assert np.linalg.norm(inverse, 2) <= largest_gain(THRESHOLD, DAMPING) * (1 + 1e-9)
        assert np.linalg.eigvalsh(null).min() > -1e-12
        assert np.linalg.eigvalsh(null).max() < 1 + 1e-12


def test_a_lost_direction_passes_to_the_null_space() -> None:
    jacobian = np.zeros((3, 7))
    jacobian[0, 0] = jacobian[1, 1] = 0.4
    _, null = task_inverse(jacobian[None], THRESHOLD, DAMPING)
    np.testing.assert_allclose(np.diag(null[0]), [0, 0, 1, 1, 1, 1, 1], atol=1e-12)


def test_damping_sets_in_continuously() -> None:
    above, below = (gain(THRESHOLD + side, THRESHOLD, DAMPING) for side in (1e-9, -1e-9))
    assert above == pytest.approx(below, rel=1e-5)
    gains = [gain(sigma, THRESHOLD, DAMPING) for sigma in np.linspace(0, 2 * THRESHOLD, 200)]
    assert np.abs(np.diff(gains)).max() < 0.4


def test_the_joint_reference_is_made_of_inverse_velocity_and_ranges() -> None:
    jacobian, rng = random_jacobians(4), np.random.default_rng(4)
    position, rest = rng.normal(size=(2, len(jacobian), 7))
    shift, velocity = rng.normal(size=(2, len(jacobian), 3))
    lower, upper = np.full(position.shape, -1.0), np.full(position.shape, 1.0)
    kept = TaskInverse(np.full((len(jacobian), 7, 3), np.nan), np.full((len(jacobian), 7, 7), np.nan))
    for _ in range(2):  # what was in the memory does not matter
        found = joint_reference(
            jacobian, THRESHOLD, DAMPING, position, lower, upper, shift, velocity, rest, kept
        )
        expected = task_inverse(jacobian, THRESHOLD, DAMPING)
        np.testing.assert_array_equal(kept.inverse, expected.inverse)
        np.testing.assert_array_equal(kept.null, expected.null)
        np.testing.assert_array_equal(found.velocity, joint_velocity(expected, velocity, rest))
        moved = position + (expected.inverse @ shift[..., None])[..., 0]
        np.testing.assert_allclose(found.position, np.clip(moved, -1.0, 1.0), atol=1e-12)
