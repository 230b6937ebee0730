"""Acceleration of the floating base and of all joints from IMU and joint velocities."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import Array, Inertial
from follower_humanoid.robot.model import ACTUATED, BASE_DOF, GRAVITY, RobotModel
from follower_humanoid.sensing.low_pass import LowPass


class BodyAcceleration:
    """Estimates v̇ of the robot's velocity vector v, low-passed.

    Linear part of the base from the accelerometer, everything else from differences over one tick.
    """

    def __init__(self, robot: RobotModel, period: float, filter_time: float) -> None:
        """`filter_time`: time constant of the low-pass [s]."""
        self._period = period
        self._filter = LowPass(filter_time, period)
        self._before: Array | None = None

    def step(self, v: Array, imu: Inertial, base_to_world: Array) -> Array:
        """v̇, shape (51,), in the convention of `RobotModel`.

        At the first call angular and joint accelerations are those of time 0, which is static.

        Args:
            v: Velocity vector, shape (51,).
            imu: Specific force at and in base_link.
            base_to_world: Rotation, shape (3, 3).
        """
        turning = np.concatenate((imu.angular_velocity, v[BASE_DOF:]))
        before = turning if self._before is None else self._before
        self._before = turning
        rate = np.empty(BASE_DOF + ACTUATED)
        rate[3:] = (turning - before) / self._period
        # d/dt of the velocity's components in the turning base axes: Rᵀ(c̈) − ω × v
        x, y, z = v[:3].tolist()
        p, q, r = imu.angular_velocity.tolist()
        rate[:3] = imu.linear_acceleration - GRAVITY * base_to_world[2]
        rate[:3] -= (q * z - r * y, r * x - p * z, p * y - q * x)
        return self._filter.step(rate)
