"""From wanted joint accelerations of both arms to motor voltages: eqs. (2), (12), (13)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.control.hand_task import HandMotion
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Inertial, Wrench
from follower_humanoid.robot.model import BASE_DOF, RobotModel
from follower_humanoid.sensing.body_acceleration import BodyAcceleration


class ArmTorque:
    """Feedback linearisation on the measured state, with the measured motion of what carries the arms."""

    def __init__(self, robot: RobotModel, motor: MotorModel, period: float, filter_time: float) -> None:
        """`period`: control tick [s]; `filter_time`: low-pass on the measured body acceleration [s]."""
        self._robot, self._period = robot, period
        self._rows = BASE_DOF + robot.groups.arms
        self._data = robot.pin_model.createData()
        self._motors = MotorInverse(motor, robot, robot.groups.arms)
        self._body_acceleration = BodyAcceleration(robot, period, filter_time)

    def torque(
        self,
        q: Array,
        v: Array,
        imu: Inertial,
        acceleration: Array,
        hands: HandMotion,
        wrenches: tuple[Wrench, Wrench],
    ) -> Array:
        """Joint torques of both arms by eq. (2), shape (14,) [N·m].

        Inverse dynamics of the whole body gives `H a + C q̇ + G` of the arm rows, including what
        the measured acceleration of base and trunk does to the arms.
        """
        rate = self._body_acceleration.step(v, imu, hands.base_to_world)
        rate[self._rows] = acceleration.ravel()
        torque: Array = pin.rnea(self._robot.pin_model, self._data, q, v, rate)[self._rows]
        left, right = wrenches
        _take_out(hands.wrench_jacobian, left.force, left.torque, right.force, right.torque, torque)
        return torque

    def voltage(self, torque: Array, velocity: Array, acceleration: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Voltages held over the tick, and where they are cut.

        The back-EMF is taken in the middle of the tick: behind a gear it changes so much within
        one that a voltage for its beginning would deliver a quarter less acceleration.
        """
        motor_torque, middle = np.empty(len(torque)), np.empty(len(torque))
        _motor_demand(
            torque, velocity, acceleration, self._motors.rotor_inertia, 0.5 * self._period,
            motor_torque, middle,
        )  # fmt: skip
        return self._motors.voltage(motor_torque, middle)


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], float64, float64[::1], float64[::1])"
)
def _motor_demand(
    torque: Array, velocity: Array, acceleration: Array, rotor_inertia: Array, half_tick: float,
    motor_torque: Array, middle: Array,
) -> None:  # fmt: skip
    """Writes τ + A q̈, and the velocity in the middle of the tick."""
    for joint in range(torque.size):
        motor_torque[joint] = torque[joint] + rotor_inertia[joint] * acceleration[joint]
        middle[joint] = velocity[joint] + half_tick * acceleration[joint]


@kernel("void(float64[:,:,::1], float64[:], float64[:], float64[:], float64[:], float64[::1])")
def _take_out(
    jacobian: Array, left_force: Array, left_moment: Array, right_force: Array, right_moment: Array,
    torque: Array,
) -> None:  # fmt: skip
    """`τ ← τ − Jᵀ (f, m)` for the joints of both arms, left first; J of shape (2, 6, joints)."""
    joints = jacobian.shape[2]
    for arm in range(2):
        force, moment = (left_force, left_moment) if arm == 0 else (right_force, right_moment)
        for joint in range(joints):
            for axis in range(3):
                torque[joints * arm + joint] -= jacobian[arm, axis, joint] * force[axis]
                torque[joints * arm + joint] -= jacobian[arm, 3 + axis, joint] * moment[axis]
