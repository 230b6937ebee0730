"""Acceleration of the floating base and of all joints from IMU and joint velocities."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Inertial
from follower_humanoid.robot.model import BASE_DOF, GRAVITY, RobotModel
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
        change = (turning - before) / self._period
        rate = _rate(v, imu.angular_velocity, imu.linear_acceleration, base_to_world, change)
        return self._filter.step(rate)


@kernel("(float64[::1], float64[:], float64[:], float64[:,::1], float64[::1])")
def _rate(v: Array, turning: Array, specific_force: Array, base_to_world: Array, change: Array) -> Array:
    """v̇ of `BodyAcceleration`, whose angular and joint parts are `change`.

    The linear part is d/dt of the velocity's components in the turning base axes: `Rᵀ(c̈) − ω × v`.
    """
    rate = np.empty(v.size)
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        rate[axis] = specific_force[axis] - GRAVITY * base_to_world[2, axis]
        rate[axis] -= turning[after] * v[last] - turning[last] * v[after]
    rate[3:] = change
    return rate
