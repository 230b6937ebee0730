"""Equations (1), (2), (3), (5), (8): signs, statics, residuals, null space."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arms_bench import random_jacobians

from follower_humanoid.control.impedance import (
    Impedance,
    impedance_acceleration,
    joint_acceleration,
    posture_acceleration,
    stop_avoidance,
)
from follower_humanoid.control.null_space import task_inverse
from follower_humanoid.robot.model import RobotModel

HORIZONTAL_AND_VERTICAL = Impedance.with_damping_ratio(np.full(3, 3.0), np.array([100.0, 100.0, 3000.0]), 1.0)


def inverse_of(jacobian: np.ndarray) -> tuple:
    return task_inverse(jacobian, 0.08, 0.05)


def test_damping_ratio_one_is_critical() -> None:
    impedance = HORIZONTAL_AND_VERTICAL
    axes = zip(impedance.inertia, impedance.damping, impedance.stiffness, strict=True)
    for mass, damping, stiffness in axes:
        roots = np.roots([mass, damping, stiffness])
        np.testing.assert_allclose(roots, -np.sqrt(stiffness / mass), rtol=1e-6)


def test_equation_8_corrected_obeys_equation_5() -> None:
    """With q̈ = q̈_d + a, the task obeys H ẍ̃ + D ẋ̃ + K x̃ = F to rounding (x̃ = J q̃)."""
    rng = np.random.default_rng(5)
    jacobian = random_jacobians(5)
    inverse, impedance = inverse_of(jacobian), HORIZONTAL_AND_VERTICAL
    n = len(jacobian)
    displacement, rate = (rng.normal(size=(n, 7, 1)) * 0.1 for _ in range(2))  # q̃, q̃̇
    force = rng.normal(size=(n, 3)) * 10
    task_displacement, task_rate = (jacobian @ displacement)[..., 0], (jacobian @ rate)[..., 0]
    total = force + impedance.force(-task_displacement, -task_rate)
    acceleration = impedance_acceleration(impedance.inertia, jacobian, inverse.inverse, total)
    task_acceleration = (jacobian @ acceleration[..., None])[..., 0]
    residual = (
        impedance.inertia * task_acceleration
        + impedance.damping * task_rate
        + impedance.stiffness * task_displacement
        - force
    )
    assert np.abs(residual).max() < 1e-11


def test_equation_8_in_its_own_letters() -> None:
    """J⁺ H⁻¹ J⁺ᵀ (Jᵀ F − Jᵀ D J q̃̇ − Jᵀ K J q̃), written out."""
    rng = np.random.default_rng(6)
    stack = random_jacobians(6)[:1]
    jacobian = stack[0]
    impedance = HORIZONTAL_AND_VERTICAL
    displacement, rate, force = rng.normal(size=7), rng.normal(size=7), rng.normal(size=3)
    h, d, k = (np.diag(m) for m in (impedance.inertia, impedance.damping, impedance.stiffness))
    pinv = np.linalg.pinv(jacobian)
    joint_forces = jacobian.T @ (force - d @ jacobian @ rate - k @ jacobian @ displacement)
    literal = pinv @ np.linalg.inv(h) @ pinv.T @ joint_forces
    total = force + impedance.force(-jacobian @ displacement, -jacobian @ rate)
    ours = impedance_acceleration(impedance.inertia, stack, inverse_of(stack).inverse, total[None])[0]
    np.testing.assert_allclose(ours, literal, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_sign_of_every_term(axis: int) -> None:
    """The force pushes along, the spring pulls back, the damper brakes."""
    jacobian, impedance = random_jacobians(7), HORIZONTAL_AND_VERTICAL
    inverse = inverse_of(jacobian)

    def hand(force: np.ndarray) -> np.ndarray:
        joints = impedance_acceleration(
            impedance.inertia, jacobian, inverse.inverse, np.tile(force, (len(jacobian), 1))
        )
        return (jacobian @ joints[..., None])[:, axis, 0]

    unit, zero = np.eye(3)[axis], np.zeros(3)
    np.testing.assert_allclose(hand(unit), 1 / 3.0, rtol=1e-9)
    assert np.all(hand(impedance.force(-0.01 * unit, zero)) < 0), "displaced forward: pulled back"
    assert np.all(hand(impedance.force(zero, -0.01 * unit)) < 0), "moving forward: braked"


def test_static_displacement_is_force_over_stiffness_along_the_force() -> None:
    force, impedance = np.array([5.0, -3.0, 10.0]), HORIZONTAL_AND_VERTICAL
    displacement = force / impedance.stiffness
    np.testing.assert_allclose(force + impedance.force(-displacement, np.zeros(3)), 0, atol=1e-12)
    assert displacement[0] == pytest.approx(0.05)


def test_law_2_makes_the_plant_of_equation_1_accelerate_as_asked() -> None:
    """τ = H a + C q̇ + G − Jᵀ F put into forward dynamics with F gives q̈ = a, for any F."""
    robot, rng = RobotModel(), np.random.default_rng(8)
    model, data = robot.pin_model, robot.pin_model.createData()
    frame = robot.frame_id("l_gripper")
    for _ in range(20):
        q = pin.integrate(model, pin.neutral(model), rng.uniform(-0.4, 0.4, 51))
        v, wanted = rng.normal(size=(2, 51))
        wrench = rng.normal(size=6) * 20
        jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        torque = pin.rnea(model, data, q, v, wanted) - jacobian.T @ wrench
        acceleration = pin.aba(model, data, q, v, torque + jacobian.T @ wrench)
        np.testing.assert_allclose(acceleration, wanted, atol=1e-7)


def test_posture_term_moves_no_hand_and_brakes_self_motion() -> None:
    rng, jacobian = np.random.default_rng(9), random_jacobians(9)
    inverse = inverse_of(jacobian)
    velocity_error, posture_error = rng.normal(size=(2, len(jacobian), 7))
    acceleration = posture_acceleration(inverse.null, velocity_error, posture_error, 100.0, 20.0)
    np.testing.assert_allclose((jacobian @ acceleration[..., None])[..., 0], 0, atol=1e-10)
    braking = posture_acceleration(inverse.null, velocity_error, np.zeros_like(posture_error), 100.0, 20.0)
    velocity = -velocity_error  # the reference stands still
    assert np.all((braking * velocity).sum(axis=-1) <= 1e-12), "takes energy out of the self-motion"


def test_null_space_term_bounds_the_self_motion_after_a_push() -> None:
    """Without it a push leaves the self-motion running; with it the velocity dies and posture returns."""
    null = inverse_of(random_jacobians(10)[:1]).null
    push = null[0] @ np.array([1.0, -0.5, 0.8, 0.0, 0.4, 0.2, -0.6])
    for stiffness, damping, bounded in ((100.0, 20.0, True), (0.0, 0.0, False)):
        position, velocity = np.zeros((1, 7)), push[None]
        for _ in range(2000):
            velocity = velocity + 0.001 * posture_acceleration(null, -velocity, -position, stiffness, damping)
            position = position + 0.001 * velocity
        assert bool(np.abs(velocity).max() < 1e-4) is bounded
        assert bool(np.abs(position).max() < 1e-4) is bounded


def test_stop_avoidance_pushes_inwards_and_brakes_outward_motion_only() -> None:
    lower, upper = np.full((1, 4), -1.0), np.full((1, 4), 1.0)
    position, velocity = np.array([[0.0, 1.1, -1.1, 1.1]]), np.array([[5.0, 1.0, -1.0, -1.0]])
    acceleration = stop_avoidance(position, velocity, lower, upper, 900.0, 40.0)
    np.testing.assert_allclose(acceleration, [[0, -90 - 40, 90 + 40, -90]])


def test_everything_that_moves_the_joints_adds_up() -> None:
    rng, jacobian = np.random.default_rng(11), random_jacobians(11)
    inverse, inertia, force = inverse_of(jacobian), np.array([3.0, 2.0, 4.0]), rng.normal(size=(40, 3))
    feedforward, desired, posture_error, position, velocity = rng.normal(size=(5, 40, 7))
    lower, upper = np.full((40, 7), -0.5), np.full((40, 7), 0.5)
    found = joint_acceleration(
        feedforward, inertia, jacobian, *inverse, force, desired, posture_error, 100.0, 20.0,
        position, velocity, lower, upper, 900.0, 40.0,
    )  # fmt: skip
    expected = feedforward + impedance_acceleration(inertia, jacobian, inverse.inverse, force)
    expected += posture_acceleration(inverse.null, desired - velocity, posture_error, 100.0, 20.0)
    expected += stop_avoidance(position, velocity, lower, upper, 900.0, 40.0)
    np.testing.assert_allclose(found, expected, atol=1e-10)
