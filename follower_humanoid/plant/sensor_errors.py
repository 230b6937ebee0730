"""Errors of the robot's sensors: constant biases, and white noise on every sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Inertial, Joints, Odometry, Wrench

_ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SensorConfig:
    """Sensor errors: noise is the standard deviation per sample, white, seeded."""

    seed: int = parameter(0, "seed of all sensor noise", "", 0, 2**31 - 1)
    position_noise: float = parameter(0.0, "joint position noise", "rad", 0.0, 1.0)
    velocity_noise: float = parameter(0.0, "joint velocity noise", "rad/s", 0.0, 10.0)
    foot_force_noise: float = parameter(0.0, "foot force noise", "N", 0.0, 1e3)
    foot_torque_noise: float = parameter(0.0, "foot moment noise", "N·m", 0.0, 1e3)
    wrist_force_noise: float = parameter(0.0, "wrist force noise", "N", 0.0, 1e3)
    wrist_torque_noise: float = parameter(0.0, "wrist moment noise", "N·m", 0.0, 1e3)
    left_wrist_bias: tuple[float, float, float] = parameter(
        _ZERO, "left wrist force bias", "N", -100.0, 100.0
    )
    right_wrist_bias: tuple[float, float, float] = parameter(
        _ZERO, "right wrist force bias", "N", -100.0, 100.0
    )
    gyro_noise: float = parameter(0.0, "gyroscope noise", "rad/s", 0.0, 10.0)
    gyro_bias: tuple[float, float, float] = parameter(_ZERO, "gyroscope bias", "rad/s", -1.0, 1.0)
    accelerometer_noise: float = parameter(0.0, "accelerometer noise", "m/s²", 0.0, 100.0)
    accelerometer_bias: tuple[float, float, float] = parameter(
        _ZERO, "accelerometer bias", "m/s²", -10.0, 10.0
    )
    odometry_position_noise: float = parameter(0.0, "base position noise", "m", 0.0, 1.0)
    odometry_velocity_noise: float = parameter(0.0, "base velocity noise", "m/s", 0.0, 1.0)


class Readings(NamedTuple):
    """All sensors at one tick."""

    joints: Joints
    odometry: Odometry
    imu: Inertial
    left_foot: Wrench
    right_foot: Wrench
    left_wrist: Wrench
    right_wrist: Wrench


class SensorErrors:
    """What is wrong with the readings of one robot.

    Attributes:
        any: False if every sensor is exact.
    """

    def __init__(self, config: SensorConfig) -> None:
        """Starts the noise at its seed."""
        self._config = config
        self._random = np.random.default_rng(config.seed)
        self._biases = {
            name: np.array(getattr(config, name)) if any(getattr(config, name)) else None
            for name in ("left_wrist_bias", "right_wrist_bias", "gyro_bias", "accelerometer_bias")
        }
        self.any = replace(config, seed=0) != SensorConfig()

    def added_to(self, exact: Readings) -> Readings:
        """What the sensors say where they should say `exact`; every call draws new noise, in this order."""
        config, biases, measured = self._config, self._biases, self._measured
        left_foot, right_foot = self._foot(exact.left_foot), self._foot(exact.right_foot)
        joints, odometry, imu = exact.joints, exact.odometry, exact.imu
        return Readings(
            joints=Joints(
                measured(joints.position, config.position_noise),
                measured(joints.velocity, config.velocity_noise),
                joints.effort,
            ),
            odometry=Odometry(
                measured(odometry.position, config.odometry_position_noise),
                odometry.quat_xyzw,
                measured(odometry.linear_velocity, config.odometry_velocity_noise),
                odometry.angular_velocity,
            ),
            imu=Inertial(
                imu.quat_xyzw,
                measured(imu.angular_velocity, config.gyro_noise, biases["gyro_bias"]),
                measured(imu.linear_acceleration, config.accelerometer_noise, biases["accelerometer_bias"]),
            ),
            left_foot=left_foot,
            right_foot=right_foot,
            left_wrist=self._wrist(exact.left_wrist, biases["left_wrist_bias"]),
            right_wrist=self._wrist(exact.right_wrist, biases["right_wrist_bias"]),
        )

    def _foot(self, exact: Wrench) -> Wrench:
        config = self._config
        return Wrench(
            self._measured(exact.force, config.foot_force_noise),
            self._measured(exact.torque, config.foot_torque_noise),
        )

    def _wrist(self, exact: Wrench, bias: Array | None) -> Wrench:
        config = self._config
        return Wrench(
            self._measured(exact.force, config.wrist_force_noise, bias),
            self._measured(exact.torque, config.wrist_torque_noise),
        )

    def _measured(self, value: Array, deviation: float, bias: Array | None = None) -> Array:
        if bias is not None:
            value = value + bias
        if deviation > 0.0:
            value = value + self._random.normal(0.0, deviation, value.shape)
        return value
