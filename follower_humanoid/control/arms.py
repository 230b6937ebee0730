"""Arm controller: compliant in the horizontal plane, stiff vertically; places kept through turns.

Each tick, for both arms at once:

1. place of the hands relative to the pelvis, and the velocity back to it (eqs. 17, 18);
2. desired joint velocity, posture kept in the null space (eq. 6);
3. impedance and null-space acceleration (corrected eq. 8);
4. torque by feedback linearisation (eq. 2) on the measured state, with the measured motion of the
   torso that carries the arms, so that walking does not shake the hands;
5. motor voltage (corrected eqs. 12, 13).

The task is the hand's position. Its orientation is held by the posture term: the arm has four
degrees of freedom left, of which the wrist's three are far stiffer than any moment of the tasks
here, and a second task would bring singularities of its own in front of a straight wrist.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.control.hand_task import (
    HandKinematics,
    HandMotion,
    limited_return,
    return_velocity,
)
from follower_humanoid.control.impedance import (
    Impedance,
    impedance_acceleration,
    posture_acceleration,
    range_force,
    stop_avoidance,
)
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.control.null_space import TaskInverse, task_inverse
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Inertial, Joints, Odometry, Wrench
from follower_humanoid.robot.model import BASE_DOF, RobotModel
from follower_humanoid.sensing.body_acceleration import BodyAcceleration
from follower_humanoid.sensing.low_pass import LowPass


@dataclass(frozen=True)
class ArmControllerConfig:
    """Parameters of the arm controller. Axes of triples: ahead of the pelvis, to its left, up."""

    stiffness: tuple[float, float, float] = parameter(
        (100.0, 100.0, 3000.0), "stiffness K_m of the hand", "N/m", 1.0, 20000.0
    )
    inertia: tuple[float, float, float] = parameter(
        (3.0, 3.0, 3.0), "inertia H_m of the hand as a leader feels it", "kg", 0.5, 50.0
    )
    damping_ratio: float = parameter(1.0, "D_m over critical damping", "", 0.1, 5.0)
    return_proportional: float = parameter(
        0.8, "K_P of eq. (17): how fast the hand returns to its place", "1/s", 0.0, 20.0
    )
    return_differential: float = parameter(0.1, "K_D of eq. (17)", "", 0.0, 0.9)
    return_force: tuple[float, float, float] = parameter(
        (60.0, 60.0, 200.0), "largest force with which the hand returns to its place", "N", 1.0, 500.0
    )
    reach: float = parameter(0.12, "how far a hand may be pulled from its place", "m", 0.01, 1.0)
    reach_stiffness: float = parameter(2000.0, "stiffness beyond that", "N/m", 0.0, 20000.0)
    posture_stiffness: float = parameter(
        100.0, "null-space stiffness, to the first posture", "1/s²", 0.0, 2000.0
    )
    posture_damping: float = parameter(20.0, "null-space damping", "1/s", 0.0, 200.0)
    posture_return: float = parameter(2.0, "rate of return to the first posture", "1/s", 0.0, 20.0)
    singular_threshold: float = parameter(
        0.08, "singular value of the Jacobian below which its inverse is damped", "m/rad", 0.001, 0.5
    )
    singular_damping: float = parameter(0.05, "damping of the inverse at a singularity", "m/rad", 0.001, 0.5)
    stop_margin: float = parameter(0.08, "distance from a joint stop where springs begin", "rad", 0.0, 0.5)
    stop_stiffness: float = parameter(900.0, "push away from a joint stop", "1/s²", 0.0, 5000.0)
    stop_damping: float = parameter(40.0, "braking towards a joint stop", "1/s", 0.0, 200.0)
    acceleration_filter_time: float = parameter(
        0.01, "low-pass on the measured body acceleration", "s", 0.0, 0.2
    )
    reference_filter_time: float = parameter(
        0.01, "low-pass on the desired joint acceleration (derivative of eq. (6))", "s", 0.0, 0.2
    )
    motor: MotorModel = field(default_factory=MotorModel)


@dataclass(frozen=True)
class ArmControllerInputs:
    """State of this tick and sensed hand wrenches (axes of world) of an earlier one.

    A wrench is None before the first is measured: that arm then feels no force and holds its place
    by stiffness alone.
    """

    joints: Joints
    odometry: Odometry
    imu: Inertial
    left_hand: Wrench | None
    right_hand: Wrench | None


@dataclass(frozen=True)
class ArmControllerOutputs:
    """Motor voltages [V] as effort, with the references q_d, q̇_d they were computed for."""

    command: Joints


@dataclass
class _Reference:
    """What the controller remembers from tick to tick, left arm first.

    Attributes:
        place: Where the hands belong relative to the pelvis, x_d of eq. (18), shape (2, 3) [m].
        posture: q_0, shape (2, 7) [rad].
        virtual: Place that the springs of the impedance pull to: x_d displaced by the integral of
            v_ref, shape (2, 3) [m].
        velocity: q̇_d of the last tick, shape (2, 7) [rad/s]; None before the first.
        saturated: Which arm has a motor at its voltage limit, shape (2,).
        loaded: Whose first wrench has come, shape (2,).
    """

    place: Array
    posture: Array
    virtual: Array
    velocity: Array | None
    saturated: NDArray[np.bool_]
    loaded: NDArray[np.bool_]


class ArmController:
    """Component: state and hand wrenches in, arm motor voltages out.

    The places and postures that it keeps are those of the first tick.
    """

    Config = ArmControllerConfig
    Inputs = ArmControllerInputs
    Outputs = ArmControllerOutputs

    def __init__(self, config: ArmControllerConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._period = period
        self._arms = robot.groups.arms
        self._data = robot.pin_model.createData()
        self._kinematics = HandKinematics(robot)
        self._motors = MotorInverse(config.motor, robot, self._arms)
        self._impedance = Impedance.with_damping_ratio(
            np.array(config.inertia), np.array(config.stiffness), config.damping_ratio
        )
        self._return_force = np.array(config.return_force)
        self._lower = (robot.lower[self._arms] + config.stop_margin).reshape(2, 7)
        self._upper = (robot.upper[self._arms] - config.stop_margin).reshape(2, 7)
        self._body_acceleration = BodyAcceleration(robot, period, config.acceleration_filter_time)
        self._reference_acceleration = LowPass(config.reference_filter_time, period)
        self._reference: _Reference | None = None

    def step(self, inputs: ArmControllerInputs, time: float) -> ArmControllerOutputs:
        """The command of this tick."""
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        hands = self._kinematics.motion(q, v)
        position = inputs.joints.position[self._arms].reshape(2, 7)
        velocity = inputs.joints.velocity[self._arms].reshape(2, 7)
        if self._reference is None:
            nothing = np.zeros(2, dtype=bool)
            self._reference = _Reference(
                hands.place, position, hands.place.copy(), None, nothing, nothing.copy()
            )
        reference = self._reference
        inverse = task_inverse(hands.jacobian, self._config.singular_threshold, self._config.singular_damping)
        wrenches = (inputs.left_hand, inputs.right_hand)
        self._take_load(reference, hands, wrenches)

        back = self._return_velocity(reference, hands)
        desired_velocity = self._desired_velocity(back, reference, hands, inverse, position)
        acceleration = self._desired_acceleration(desired_velocity, reference.velocity)
        force = self._hand_force(back, reference, hands, wrenches)
        acceleration = acceleration + impedance_acceleration(
            self._impedance.inertia, hands.jacobian, inverse, force
        )
        acceleration += self._joint_acceleration(
            inverse, position, velocity, desired_velocity, reference.posture
        )
        torque = self._torque(q, v, inputs.imu, acceleration, hands, wrenches)
        voltage, saturated = self._voltage(torque, velocity.ravel(), acceleration.ravel())

        stretch = inverse.inverse @ (reference.virtual - hands.place)[..., None]
        held = np.clip(position + stretch[..., 0], self._lower, self._upper)
        reference.virtual = reference.virtual + self._period * back
        reference.velocity = desired_velocity
        reference.saturated[:] = saturated.reshape(2, 7).any(axis=1)
        return ArmControllerOutputs(Joints(held.ravel(), desired_velocity.ravel(), voltage))

    def _take_load(
        self, reference: _Reference, hands: HandMotion, wrenches: tuple[Wrench | None, Wrench | None]
    ) -> None:
        """Lets the springs carry the first force measured: the robot starts with the object in hand."""
        for hand, wrench in enumerate(wrenches):
            if wrench is not None and not reference.loaded[hand]:
                force = wrench.force @ hands.yaw_to_world
                carried = np.clip(force, -self._return_force, self._return_force)
                reference.virtual[hand] -= carried / self._impedance.stiffness
                reference.loaded[hand] = True

    def _return_velocity(self, reference: _Reference, hands: HandMotion) -> Array:
        """v_ref of eqs. (17), (18), shape (2, 3) [m/s]; stops where it would only wind up."""
        back = return_velocity(
            reference.place - hands.place, -hands.place_rate,
            self._config.return_proportional, self._config.return_differential,
        )  # fmt: skip
        spring = self._impedance.stiffness * (reference.virtual - hands.place)
        back = limited_return(back, spring, self._return_force)
        back[reference.saturated] = 0.0
        return back

    def _desired_velocity(
        self, back: Array, reference: _Reference, hands: HandMotion, inverse: TaskInverse, position: Array
    ) -> Array:
        """q̇_d of eq. (6), shape (2, 7): back to the place, against what the body does, posture aside."""
        posture = self._config.posture_return * (reference.posture - position)
        task, null = (back - hands.carried)[..., None], posture[..., None]
        desired: Array = (inverse.inverse @ task + inverse.null @ null)[..., 0]
        return desired

    def _desired_acceleration(self, desired_velocity: Array, before: Array | None) -> Array:
        """q̈_d, the low-passed derivative of q̇_d."""
        change = np.zeros_like(desired_velocity) if before is None else desired_velocity - before
        return self._reference_acceleration.step(change / self._period)

    def _hand_force(
        self,
        back: Array,
        reference: _Reference,
        hands: HandMotion,
        wrenches: tuple[Wrench | None, Wrench | None],
    ) -> Array:
        """Everything that shall move the hands' masses H_m, task axes, shape (2, 3) [N]."""
        force = self._impedance.force(reference.virtual - hands.place, back - hands.place_rate)
        force += range_force(
            reference.place - hands.place, -hands.place_rate,
            self._config.reach, self._config.reach_stiffness, float(self._impedance.inertia[0]),
        )  # fmt: skip
        for hand, wrench in enumerate(wrenches):
            if wrench is not None:  # not measured yet: nothing to yield to
                force[hand] += wrench.force @ hands.yaw_to_world
        return force

    def _joint_acceleration(
        self, inverse: TaskInverse, position: Array, velocity: Array, desired_velocity: Array, posture: Array
    ) -> Array:
        """Null-space term of corrected eq. (8), and distance from the stops, shape (2, 7) [rad/s²]."""
        config = self._config
        still = posture_acceleration(
            inverse, desired_velocity - velocity, posture - position,
            config.posture_stiffness, config.posture_damping,
        )  # fmt: skip
        return still + stop_avoidance(
            position, velocity, self._lower, self._upper, config.stop_stiffness, config.stop_damping
        )

    def _torque(
        self,
        q: Array,
        v: Array,
        imu: Inertial,
        acceleration: Array,
        hands: HandMotion,
        wrenches: tuple[Wrench | None, Wrench | None],
    ) -> Array:
        """Joint torques of both arms by eq. (2), shape (14,) [N·m].

        Inverse dynamics of the whole body gives `H a + C q̇ + G` of the arm rows, including what
        the measured acceleration of base and trunk does to the arms.
        """
        rate = self._body_acceleration.step(v, imu, hands.base_to_world)
        rate[BASE_DOF + self._arms] = acceleration.ravel()
        torque: Array = pin.rnea(self._robot.pin_model, self._data, q, v, rate)[BASE_DOF + self._arms]
        for hand, wrench in enumerate(wrenches):
            if wrench is not None:
                felt = np.concatenate((wrench.force, wrench.torque))
                torque[7 * hand : 7 * hand + 7] -= hands.wrench_jacobian[hand].T @ felt
        return torque

    def _voltage(
        self, torque: Array, velocity: Array, acceleration: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Voltages held over the tick, and where they are clipped.

        The back-EMF is taken in the middle of the tick: behind a gear it changes so much within
        one that a voltage for its beginning would deliver a quarter less acceleration.
        """
        motor_torque = torque + self._motors.rotor_inertia * acceleration
        middle = velocity + 0.5 * self._period * acceleration
        return self._motors.clipped(self._motors.voltage(motor_torque, middle))
