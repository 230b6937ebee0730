"""Acceleration of base and joints from IMU and joint velocities."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arms_bench import TICK, Bench, bending, swaying

from follower_humanoid.robot.model import RobotModel
from follower_humanoid.sensing.body_acceleration import BodyAcceleration
from follower_humanoid.sensing.low_pass import LowPass


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def test_it_is_the_derivative_of_the_velocity_vector(robot: RobotModel) -> None:
    bench = Bench(robot, swaying, bending)
    estimate = BodyAcceleration(robot, TICK, 0.0)
    errors = []
    before = None
    for _ in range(800):
        joints, odometry, imu = bench.state()
        v = robot.velocity(odometry, joints.velocity)
        rate = estimate.step(v, imu, pin.Quaternion(odometry.quat_xyzw).matrix())
        if before is not None:
            errors.append(rate - (v - before) / TICK)
        before = v
        bench.time += TICK
    errors = np.array(errors)
    assert np.abs(errors[:, :3]).max() < 0.05, "half a tick apart"
    assert np.abs(errors[:, 3:]).max() < 1e-9


def test_at_rest_it_is_zero_whatever_the_tilt(robot: RobotModel) -> None:
    bench = Bench(robot, base=lambda time: np.array([1.0, 2.0, 0.9, 0.4, 0.1, -0.2]))
    joints, odometry, imu = bench.state()
    rate = BodyAcceleration(robot, TICK, 0.01).step(
        robot.velocity(odometry, joints.velocity), imu, pin.Quaternion(odometry.quat_xyzw).matrix()
    )
    np.testing.assert_allclose(rate, 0, atol=1e-9)


def test_the_filter_is_a_low_pass_on_every_component(robot: RobotModel) -> None:
    bench = Bench(robot, swaying, bending)
    plain, filtered = BodyAcceleration(robot, TICK, 0.0), BodyAcceleration(robot, TICK, 0.01)
    low_pass = LowPass(0.01, TICK)
    for _ in range(20):
        joints, odometry, imu = bench.state()
        v = robot.velocity(odometry, joints.velocity)
        axes = pin.Quaternion(odometry.quat_xyzw).matrix()
        expected = low_pass.step(plain.step(v, imu, axes).copy())
        np.testing.assert_allclose(filtered.step(v, imu, axes), expected, atol=1e-9)
        bench.time += TICK
