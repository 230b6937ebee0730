"""From wanted joint accelerations of both arms to motor voltages: eqs. (2), (12), (13)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.control.hand_task import HandMotion
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Inertial, Wrench
from follower_humanoid.robot.model import BASE_DOF, Indices, RobotModel
from follower_humanoid.sensing.body_acceleration import BodyAcceleration


class ArmTorque:
    """Feedback linearisation on the measured state, with the measured motion of what carries the arms."""

    def __init__(self, robot: RobotModel, motor: MotorModel, period: float, filter_time: float) -> None:
        """`period`: control tick [s]; `filter_time`: low-pass on the measured body acceleration [s]."""
        self._robot, self._period = robot, period
        self._rows = BASE_DOF + robot.groups.arms.reshape(2, -1)
        self._data = robot.pin_model.createData()
        self._motors = MotorInverse(motor, robot, robot.groups.arms)
        self._body_acceleration = BodyAcceleration(robot, period, filter_time)

    def voltage(
        self,
        q: Array,
        v: Array,
        imu: Inertial,
        hands: HandMotion,
        wrenches: tuple[Wrench, Wrench],
        velocity: Array,
        acceleration: Array,
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Voltages held over the tick, shape (14,) [V], and where they are cut.

        Torques are those of eq. (2). Inverse dynamics of the whole body gives `H a + C q̇ + G` of the arm
        rows, including what the measured acceleration of base and trunk does to the arms.

        The back-EMF is taken in the middle of the tick: behind a gear it changes so much within
        one that a voltage for its beginning would deliver a quarter less acceleration.

        Args:
            q, v: State of the robot.
            imu: What it feels.
            hands: Its hands in this state.
            wrenches: On them, axes of world.
            velocity, acceleration: q̇ and wanted q̈ of both arms, shape (2, 7) [rad/s], [rad/s²].
        """
        rate = self._body_acceleration.step(v, imu, hands.base_to_world)
        rate[self._rows] = acceleration
        forces = pin.rnea(self._robot.pin_model, self._data, q, v, rate)
        left, right = wrenches
        motor_torque, middle = np.empty(velocity.size), np.empty(velocity.size)
        _motor_demand(
            forces, self._rows, hands.wrench_jacobian, left.force, left.torque, right.force, right.torque,
            velocity, acceleration, self._motors.rotor_inertia, 0.5 * self._period, motor_torque, middle,
        )  # fmt: skip
        return self._motors.voltage(motor_torque, middle)


@kernel(
    "void(float64[::1], intp[:,::1], float64[:,:,::1], float64[:], float64[:], float64[:], float64[:],"
    " float64[:,::1], float64[:,::1], float64[::1], float64, float64[::1], float64[::1])"
)
def _motor_demand(
    forces: Array, rows: Indices, jacobian: Array, left_force: Array, left_moment: Array, right_force: Array,
    right_moment: Array, velocity: Array, acceleration: Array, rotor_inertia: Array, half_tick: float,
    motor_torque: Array, middle: Array,
) -> None:  # fmt: skip
    """Writes `τ + A q̈` with `τ = forces − Jᵀ (f, m)`, and the velocity in the middle of the tick.

    Of all joints of both arms, left first, which are the `rows` of `forces`, shape (2, joints); J of
    shape (2, 6, joints).
    """
    joints = rows.shape[1]
    for arm in range(2):
        force, moment = (left_force, left_moment) if arm == 0 else (right_force, right_moment)
        for joint in range(joints):
            torque = forces[rows[arm, joint]]
            for axis in range(3):
                torque -= jacobian[arm, axis, joint] * force[axis]
                torque -= jacobian[arm, 3 + axis, joint] * moment[axis]
            n, a = joints * arm + joint, acceleration[arm, joint]
            motor_torque[n] = torque + rotor_inertia[n] * a
            middle[n] = velocity[arm, joint] + half_tick * a
