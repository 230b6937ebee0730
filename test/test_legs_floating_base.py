"""Feedback linearisation on the floating base: the closed loop does exactly what was asked."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import robot, standing_configuration

from follower_humanoid.control.floating_base import motor_torque
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError
from follower_humanoid.robot.model import ACTUATED, BASE_DOF, GRAVITY

ROTOR = np.linspace(0.02, 0.15, ACTUATED)


def random_state(rng: np.random.Generator) -> tuple[Array, Array]:
    model = robot().pin_model
    q = pin.integrate(model, standing_configuration(), rng.normal(0, 0.2, model.nv))
    return np.array(q), rng.normal(0, 0.5, model.nv)


def torques(mass: Array, bias: Array, external: Array, a: Array, rotor: Array) -> tuple[Array, Array]:
    """Of all joints."""
    return motor_torque(np.asfortranarray(mass), bias, external, np.arange(ACTUATED), a, rotor)


def dynamics(q: Array, v: Array) -> tuple[Array, Array]:
    model, data = robot().pin_model, robot().pin_model.createData()
    upper = np.triu(pin.crba(model, data, q))
    return upper + np.triu(upper, 1).T, np.array(pin.nonLinearEffects(model, data, q, v))


def wrenches(q: Array, rng: np.random.Generator) -> Array:
    """Generalised force of random wrenches on feet and hands."""
    model, data = robot().pin_model, robot().pin_model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    force = np.zeros(model.nv)
    for name in ("l_sole", "r_sole", "l_gripper", "r_gripper"):
        jacobian = pin.getFrameJacobian(model, data, robot().frame_id(name), pin.ReferenceFrame.LOCAL)
        force += jacobian.T @ (rng.normal(0, 1, 6) * [50, 50, 300, 10, 10, 10])
    return force


@pytest.mark.parametrize("seed", range(5))
def test_forward_dynamics_under_the_torque_give_the_acceleration_asked_for(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, v = random_state(rng)
    external, a = wrenches(q, rng), rng.normal(0, 20, ACTUATED)
    torque, base = torques(*dynamics(q, v), external, a, ROTOR)
    # Pinocchio's articulated-body algorithm, with the part that turns the rotors taken off.
    model, data = robot().pin_model, robot().pin_model.createData()
    at_joint = np.concatenate((np.zeros(BASE_DOF), torque - ROTOR * a)) + external
    acceleration = pin.aba(model, data, q, v, at_joint)
    np.testing.assert_allclose(acceleration[BASE_DOF:], a, atol=1e-7)
    np.testing.assert_allclose(acceleration[:BASE_DOF], base, atol=1e-7)


def test_with_rotors_on_actuated_rows_only_the_motor_equation_holds() -> None:
    rng = np.random.default_rng(9)
    q, v = random_state(rng)
    mass, bias = dynamics(q, v)
    external, a = wrenches(q, rng), rng.normal(0, 20, ACTUATED)
    torque, _ = torques(mass, bias, external, a, ROTOR)
    armature = np.diag(np.concatenate((np.zeros(BASE_DOF), ROTOR)))
    right = np.concatenate((np.zeros(BASE_DOF), torque)) + external - bias
    np.testing.assert_allclose(np.linalg.solve(mass + armature, right)[BASE_DOF:], a, atol=1e-7)


def test_it_is_equation_16_partitioned() -> None:
    # τ = (H_aa − H_ab H_bb⁻¹ H_ba) a + h_a − H_ab H_bb⁻¹ h_b with h = n − external.
    rng = np.random.default_rng(10)
    q, v = random_state(rng)
    mass, bias = dynamics(q, v)
    external, a = wrenches(q, rng), rng.normal(0, 20, ACTUATED)
    b, j = slice(0, BASE_DOF), slice(BASE_DOF, None)
    h = bias - external
    across = mass[j, b] @ np.linalg.inv(mass[b, b])
    expected = (mass[j, j] - across @ mass[b, j]) @ a + h[j] - across @ h[b]
    torque, _ = torques(mass, bias, external, a, np.zeros(ACTUATED))
    np.testing.assert_allclose(torque, expected, atol=1e-8)


def test_the_right_ground_force_holds_the_robot_still() -> None:
    # Feet that carry the weight with the CoM above: no acceleration of the base, static joint torques.
    q = standing_configuration()
    model, data = robot().pin_model, robot().pin_model.createData()
    mass, bias = dynamics(q, np.zeros(model.nv))
    com = pin.centerOfMass(model, data, q).copy()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    external = np.zeros(model.nv)
    for name in ("l_sole", "r_sole"):
        frame = robot().frame_id(name)
        jacobian = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        half = 0.5 * robot().mass * GRAVITY
        lever = com[0] - data.oMf[frame].translation[0]
        external += jacobian.T @ np.array([0.0, 0.0, half, 0.0, -lever * half, 0.0])
    torque, base = torques(mass, bias, external, np.zeros(ACTUATED), ROTOR)
    np.testing.assert_allclose(base, np.zeros(6), atol=1e-9)
    np.testing.assert_allclose(torque, (bias - external)[BASE_DOF:], atol=1e-9)


def test_only_the_upper_triangle_of_the_mass_matrix_is_read() -> None:
    rng = np.random.default_rng(11)
    q, v = random_state(rng)
    mass, bias = dynamics(q, v)
    external, a = wrenches(q, rng), rng.normal(0, 20, ACTUATED)
    found = torques(np.triu(mass), bias, external, a, ROTOR)
    for one, other in zip(found, torques(mass, bias, external, a, ROTOR), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_a_mass_matrix_of_nonsense_is_refused() -> None:
    nothing = np.zeros(BASE_DOF + ACTUATED)
    for mass in (np.zeros((51, 51)), np.full((51, 51), np.nan)):
        with pytest.raises(PhysicsError, match="not positive definite"):
            torques(mass, nothing, nothing, nothing[BASE_DOF:], ROTOR)


def test_joints_that_are_not_asked_for_are_joints_at_rest() -> None:
    rng = np.random.default_rng(12)
    q, v = random_state(rng)
    (mass, bias), external = dynamics(q, v), wrenches(q, rng)
    some = np.sort(rng.choice(ACTUATED, 20, replace=False))
    a = np.zeros(ACTUATED)
    a[some] = rng.normal(0, 20, 20)
    expected, base = torques(mass, bias, external, a, ROTOR)
    found = motor_torque(np.asfortranarray(mass), bias, external, some, a[some], ROTOR[some])
    np.testing.assert_array_equal(found[0], expected[some])
    np.testing.assert_array_equal(found[1], base)
