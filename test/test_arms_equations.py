"""Equations (1) to (10) on seeded random configurations, each with the property it must have."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arms_bench import random_jacobians

from follower_humanoid.control.gravity_compensation import compensation, leading_force
from follower_humanoid.control.impedance import Impedance, impedance_acceleration, posture_acceleration
from follower_humanoid.control.null_space import joint_velocity, limit_avoidance, task_inverse
from follower_humanoid.robot.model import RobotModel

RNG = np.random.default_rng(11)


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


@pytest.fixture(scope="module")
def jacobians():
    return random_jacobians(3)


def random_state(robot, rng):
    q = np.concatenate((rng.normal(size=3), rng.normal(size=4), rng.uniform(robot.lower, robot.upper)))
    q[3:7] /= np.linalg.norm(q[3:7])
    return q, rng.normal(size=51)


def dynamics(robot, q, v):
    """H, C q̇ + G, and the Jacobian of the left gripper's force, axes of world."""
    data = robot.pin_model.createData()
    mass = pin.crba(robot.pin_model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias = pin.nonLinearEffects(robot.pin_model, data, q, v)
    frame = robot.frame_id("l_gripper")
    jacobian = pin.computeFrameJacobian(robot.pin_model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
    return mass, bias, jacobian[:3]


@pytest.mark.parametrize("seed", range(5))
def test_equations_1_and_2_force_on_the_robot_leaves_the_wanted_acceleration(robot, seed):
    rng = np.random.default_rng(seed)
    q, v = random_state(robot, rng)
    wanted, force = rng.normal(size=51), rng.normal(scale=30.0, size=3)
    mass, bias, jacobian = dynamics(robot, q, v)
    torque = mass @ wanted + bias - jacobian.T @ force  # (2)
    total = torque + jacobian.T @ force  # (1): H q̈ + C q̇ + G = τ + Jᵀ F
    found = pin.aba(robot.pin_model, robot.pin_model.createData(), q, v, total)
    np.testing.assert_allclose(found, wanted, atol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_equation_1_power_of_torque_and_force_is_the_change_of_energy(robot, seed):
    rng = np.random.default_rng(seed)
    q, v = random_state(robot, rng)
    _, _, jacobian = dynamics(robot, q, v)
    torque, force = rng.normal(scale=5.0, size=51), rng.normal(scale=30.0, size=3)
    rate = pin.aba(robot.pin_model, robot.pin_model.createData(), q, v, torque + jacobian.T @ force)
    h = 1e-5

    def energy(s):
        data = robot.pin_model.createData()
        there = pin.integrate(robot.pin_model, q, s * v + 0.5 * s * s * rate)
        moving = v + s * rate
        return pin.computeKineticEnergy(robot.pin_model, data, there, moving) + pin.computePotentialEnergy(
            robot.pin_model, data, there
        )

    change = (energy(h) - energy(-h)) / (2 * h)
    assert change == pytest.approx(torque @ v + force @ (jacobian @ v), rel=1e-5, abs=1e-4)


def test_equations_3_and_4_power_balance_and_static_displacement_along_the_force():
    for _ in range(20):
        inertia, stiffness = RNG.uniform(1, 5, 3), RNG.uniform(50, 3000, 3)
        wanted = Impedance.with_damping_ratio(inertia, stiffness, RNG.uniform(0.3, 2.0))
        x, v, force = RNG.normal(size=3), RNG.normal(size=3), RNG.normal(scale=10, size=3)
        a = (force + wanted.force(-x, -v)) / inertia
        stored = v @ (inertia * a) + x @ (stiffness * v)  # d/dt (½ ẋᵀHẋ + ½ xᵀKx)
        assert stored == pytest.approx(force @ v - v @ (wanted.damping * v))
        still = force / stiffness
        np.testing.assert_allclose(wanted.force(-still, np.zeros(3)), -force)
        assert (still * force >= 0.0).all()


def test_equation_5_is_equation_3_seen_from_the_joints(jacobians):
    for jacobian in jacobians:
        inertia, force = RNG.uniform(1, 5, 3), RNG.normal(scale=20, size=3)
        inverse = task_inverse(jacobian[None], 0.08, 0.05)
        a = impedance_acceleration(inertia, jacobian[None], inverse.inverse, force[None])[0]
        np.testing.assert_allclose(jacobian @ a, force / inertia, atol=1e-9)


def test_equation_6_reaches_the_task_velocity_and_the_rest_stays_in_the_null_space(jacobians):
    for jacobian in jacobians:
        inverse = task_inverse(jacobian[None], 0.08, 0.05)
        wanted, one, other = RNG.normal(size=3), RNG.normal(size=7), RNG.normal(size=7)
        found, otherwise = (joint_velocity(inverse, wanted[None], aside[None])[0] for aside in (one, other))
        np.testing.assert_allclose(jacobian @ found, wanted, atol=1e-10)
        np.testing.assert_allclose(jacobian @ (found - otherwise), np.zeros(3), atol=1e-10)


@pytest.mark.parametrize("seed", range(5))
def test_equation_7_is_the_gradient_of_the_distance_from_the_limits(robot, seed):
    arm = robot.groups.left_arm
    lower, upper = robot.lower[arm], robot.upper[arm]
    q, gain, h = np.random.default_rng(seed).uniform(lower, upper), 4.0, 1e-6

    def omega(position):
        return -(((position - 0.5 * (lower + upper)) / (upper - lower)) ** 2).sum() / (2 * len(position))

    slope = [(omega(q + h * unit) - omega(q - h * unit)) / (2 * h) for unit in np.eye(7)]
    found = limit_avoidance(q, lower, upper, gain)
    np.testing.assert_allclose(found, gain * np.array(slope), rtol=1e-6, atol=1e-8)
    assert omega(q + 0.01 * found) > omega(q)


def test_equation_8_corrected_pulls_back_and_as_printed_would_push_away(jacobians):
    wanted = Impedance.with_damping_ratio(np.full(3, 2.0), np.full(3, 1000.0), 1.0)
    for jacobian in jacobians:
        inverse = task_inverse(jacobian[None], 0.08, 0.05)
        shift, rate, force = RNG.normal(scale=0.01, size=7), RNG.normal(size=7), RNG.normal(size=3)
        x, v = jacobian @ shift, jacobian @ rate
        total = force + wanted.force(-x, -v)
        a = impedance_acceleration(wanted.inertia, jacobian[None], inverse.inverse, total[None])[0]
        residual = wanted.inertia * (jacobian @ a) + wanted.damping * v + wanted.stiffness * x - force
        assert np.abs(residual).max() < 1e-9
        own = wanted.inertia * (jacobian @ a) - force
        assert own @ x < 0.0 or own @ v < 0.0
        printed = jacobian.T @ (wanted.stiffness * x)
        assert shift @ printed > 0.0, "the printed sign adds energy along the displacement"


def test_the_null_space_term_of_equation_8_moves_no_hand(jacobians):
    for jacobian in jacobians:
        inverse = task_inverse(jacobian[None], 0.08, 0.05)
        errors = RNG.normal(size=(2, 1, 7))
        a = posture_acceleration(inverse.null, *errors, 100.0, 20.0)
        np.testing.assert_allclose(jacobian @ a[0], np.zeros(3), atol=1e-9)


def test_equations_9_and_10_terminal_speed_decay_time_and_no_return():
    inertia, damping, h = np.array([2.0, 3.0, 4.0]), 60.0, 1e-4
    led = compensation(inertia, damping)
    assert not led.stiffness.any()
    force, x, v = np.array([6.0, -3.0, 9.0]), np.zeros(3), np.zeros(3)
    for _ in range(20000):
        v = v + h * (force + led.force(-x, -v)) / inertia
        x = x + h * v
    np.testing.assert_allclose(v, force / damping, rtol=1e-6)
    begin, speed = x, v
    for step in range(20000):
        v = v + h * led.force(-x, -v) / inertia
        x = x + h * v
        if step == round(inertia[0] / damping / h) - 1:
            assert v[0] == pytest.approx(speed[0] / np.e, rel=0.01)
    np.testing.assert_allclose(x - begin, inertia * speed / damping, rtol=1e-2)
    np.testing.assert_allclose(v, 0.0, atol=1e-12)


def test_equation_10_only_ever_takes_energy():
    led = compensation(np.full(3, 2.0), 60.0)
    for velocity in RNG.normal(size=(50, 3)):
        assert velocity @ led.force(RNG.normal(size=3), -velocity) < 0.0


def test_the_payload_is_carried_and_does_not_lead():
    felt = np.array([[0.0, 0.0, -10.0], [1.0, 2.0, -10.0]])
    np.testing.assert_array_equal(leading_force(felt, 10.0), [[0, 0, 0], [1, 2, 0]])
    assert felt[0, 2] == -10.0, "what was measured stays"
