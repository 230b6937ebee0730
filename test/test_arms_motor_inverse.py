"""Voltage from torque: constants on the output side, inverse, saturation mask."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.robot.model import RobotModel


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def test_output_side_constants_by_hand(robot: RobotModel) -> None:
    inverse = MotorInverse(MotorModel(viscous=1e-5), robot)
    knee, toe = robot.joint_index("l_knee"), robot.joint_index("r_toe_pitch")
    assert inverse.torque_per_volt[knee] == pytest.approx(50 * 0.0934 / 0.608)
    assert inverse.torque_per_volt[toe] == pytest.approx(20 * 0.0934 / 0.608)
    assert inverse.back_emf[knee] == pytest.approx(50 * 0.0934)
    assert inverse.rotor_inertia[knee] == pytest.approx(0.134)
    assert inverse.rotor_inertia[toe] == pytest.approx(0.02144)
    assert inverse.viscous[knee] == pytest.approx(0.025)
    assert inverse.damping[knee] == pytest.approx(0.025 + 50**2 * 0.0934**2 / 0.608)


def test_voltage_makes_the_torque_of_equations_12_and_13(robot: RobotModel) -> None:
    motor = MotorModel(viscous=2e-5, voltage_limit=500.0)
    inverse = MotorInverse(motor, robot)
    rng = np.random.default_rng(1)
    torque, velocity, acceleration = rng.normal(size=(3, 45)) * [[20.0], [2.0], [10.0]]
    voltage, saturated = inverse.voltage(torque + inverse.rotor_inertia * acceleration, velocity)
    assert not saturated.any()
    gear = np.array([20.0 if "toe" in name else 50.0 for name in robot.joint_names])
    current = (voltage - motor.back_emf * gear * velocity) / motor.resistance
    rotor_torque = (
        motor.torque_constant * current
        - motor.viscous * gear * velocity
        - motor.rotor_inertia * gear * acceleration
    )
    np.testing.assert_allclose(gear * rotor_torque, torque, atol=1e-10)


def test_motor_torque_inverts_voltage_on_a_subset(robot: RobotModel) -> None:
    inverse = MotorInverse(MotorModel(voltage_limit=500.0), robot, robot.groups.legs)
    rng = np.random.default_rng(2)
    torque, velocity = rng.normal(size=(2, len(robot.groups.legs)))
    np.testing.assert_allclose(
        inverse.motor_torque(inverse.voltage(torque, velocity)[0], velocity), torque, atol=1e-12
    )
    assert inverse.torque_per_volt[6] < inverse.torque_per_volt[5], "toe gear follows the subset"


def test_the_limit_cuts_and_says_which_joints_saturate(robot: RobotModel) -> None:
    inverse = MotorInverse(MotorModel(voltage_limit=10.0), robot)
    wanted = np.zeros(45)
    wanted[[3, 5, 7]] = 12.0, 10.0, -30.0
    limited, saturated = inverse.voltage(inverse.motor_torque(wanted, np.zeros(45)), np.zeros(45))
    np.testing.assert_allclose(limited[[3, 5, 7]], [10.0, 10.0, -10.0])
    assert set(np.flatnonzero(saturated)) - {5} == {3, 7}
    assert not limited[[0, 1, 2]].any()
