"""Acceleration of the floating base and of all joints from IMU and joint velocities."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Inertial
from follower_humanoid.robot.model import BASE_DOF, GRAVITY, RobotModel
from follower_humanoid.sensing.low_pass import filter_share


class BodyAcceleration:
    """Estimates v̇ of the robot's velocity vector v, low-passed.

    Linear part of the base from the accelerometer, everything else from differences over one tick.
    """

    def __init__(self, robot: RobotModel, period: float, filter_time: float) -> None:
        """`filter_time`: time constant of the low-pass [s]."""
        self._period, self._share = period, filter_share(filter_time, period)
        self._before: Array | None = None
        self._rate = np.zeros(robot.pin_model.nv)

    def step(self, v: Array, imu: Inertial, base_to_world: Array) -> Array:
        """v̇, shape (51,), in the convention of `RobotModel`; valid until the next step.

        At the first call angular and joint accelerations are those of time 0, which is static, and
        nothing is filtered yet.

        Args:
            v: Velocity vector, shape (51,).
            imu: Specific force at and in base_link.
            base_to_world: Rotation, shape (3, 3).
        """
        share = self._share
        if self._before is None:
            self._before, share = np.concatenate((imu.angular_velocity, v[BASE_DOF:])), 1.0
        _rate(
            v, imu.angular_velocity, imu.linear_acceleration, base_to_world, self._period, share,
            self._before, self._rate,
        )  # fmt: skip
        return self._rate


@kernel(
    "void(float64[::1], float64[:], float64[:], float64[:,::1], float64, float64, float64[::1], float64[::1])"
)
def _rate(
    v: Array, turning: Array, specific_force: Array, base_to_world: Array, period: float, share: float,
    before: Array, rate: Array,
) -> None:  # fmt: skip
    """Moves v̇ of `BodyAcceleration` on, shape (51,), by a share of its distance from what is measured.

    The linear part is d/dt of the velocity's components in the turning base axes: `Rᵀ(c̈) − ω × v`. The
    others are differences to `before`, shape (48,), which holds ω and joint velocities and moves on.
    """
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        measured = specific_force[axis] - GRAVITY * base_to_world[2, axis]
        measured -= turning[after] * v[last] - turning[last] * v[after]
        rate[axis] += share * (measured - rate[axis])
    for n in range(before.size):
        now = turning[n] if n < 3 else v[3 + n]
        measured = (now - before[n]) / period
        rate[3 + n] += share * (measured - rate[3 + n])
        before[n] = now
