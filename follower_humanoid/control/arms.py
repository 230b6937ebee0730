"""Arm controller: hands that keep their places with springs, or let themselves be led.

Each tick, for both arms at once:

1. where the hands belong: places relative to the pelvis or targets, and the velocity back to them
   (eqs. 17, 18); a hand that is led belongs where it is;
2. desired joint velocity, posture or joint limits in the null space (eqs. 6, 7);
3. impedance and null-space acceleration (corrected eq. 8), without springs where the hand is led
   (eq. 10), blended at a switch of modes;
4. torque by feedback linearisation (eq. 2) on the measured state, with the measured motion of the
   torso that carries the arms, so that walking does not shake the hands;
5. motor voltage (corrected eqs. 12, 13).

The task is the hand's position. Its orientation is held by the posture term: the arm has four
degrees of freedom left, of which the wrist's three are far stiffer than any moment of the tasks
here, and a second task would bring singularities of its own in front of a straight wrist.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from follower_humanoid.control.arm_config import ArmControllerConfig
from follower_humanoid.control.arm_modes import COMPENSATION, IMPEDANCE, Blend, ModeSwitch
from follower_humanoid.control.arm_torque import ArmTorque
from follower_humanoid.control.gravity_compensation import compensation, leading_force
from follower_humanoid.control.hand_law import HandLaw
from follower_humanoid.control.hand_reference import GlideLimits, HandReference
from follower_humanoid.control.hand_task import (
    HandKinematics,
    HandMotion,
    Mask,
    forces_in_task_axes,
    unwritten_motion,
)
from follower_humanoid.control.impedance import Impedance, joint_acceleration
from follower_humanoid.control.null_space import (
    JointReference,
    TaskInverse,
    joint_reference,
    limit_avoidance,
)
from follower_humanoid.control.reference_acceleration import ReferenceAcceleration
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import (
    SIDES,
    Array,
    Inertial,
    Joints,
    Odometry,
    PrimitiveStates,
    Wrench,
)
from follower_humanoid.robot.model import RobotModel

__all__ = ["ArmController", "ArmControllerConfig", "ArmControllerInputs", "ArmControllerOutputs"]

# Time in which a glide comes to its speed [s]; by default longer than a switch fades (blend_time).
_GLIDE_RISE = 0.5
# What a hand feels whose wrench has not been measured yet: nothing to yield to.
_NO_WRENCH = Wrench(np.zeros(3), np.zeros(3))


class ArmControllerInputs(NamedTuple):
    """State of this tick and sensed hand wrenches (axes of world) of an earlier one.

    A wrench is None before the first is measured: that arm then feels no force and holds its place
    by stiffness alone. A target is where the gripper shall be relative to base_link, in pelvis-yaw
    axes (position [m], linear velocity [m/s]); None: it comes to rest at the last one, or keeps its
    first place.
    """

    joints: Joints
    odometry: Odometry
    imu: Inertial
    left_hand: Wrench | None
    right_hand: Wrench | None
    left_target: Odometry | None = None
    right_target: Odometry | None = None


class ArmControllerOutputs(NamedTuple):
    """What the controller decided.

    Attributes:
        command: Motor voltages [V] as effort, with the references q_d, q̇_d they were computed for.
        mode: Which hand is in which mode.
    """

    command: Joints
    mode: PrimitiveStates


class ArmController:
    """Component: state, hand wrenches and targets in, arm motor voltages out.

    The places and postures that it keeps without targets are those of the first tick.
    """

    Config = ArmControllerConfig
    Inputs = ArmControllerInputs
    Outputs = ArmControllerOutputs

    def __init__(self, config: ArmControllerConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._period = period
        self._arms = robot.groups.arms.reshape(2, 7)
        self._kinematics = HandKinematics(robot)
        self._actuation = ArmTorque(robot, config.motor, period, config.acceleration_filter_time)
        self._impedance = Impedance.with_damping_ratio(
            np.array(config.inertia), np.array(config.stiffness), config.damping_ratio
        )
        self._compensation = compensation(self._impedance.inertia, config.compensation_damping)
        self._law = HandLaw(config, self._impedance, period)
        self._lower = robot.lower[self._arms] + config.stop_margin
        self._upper = robot.upper[self._arms] - config.stop_margin
        self._reference_acceleration = ReferenceAcceleration(config.reference_filter_time, period)
        self._switch = ModeSwitch(period)
        self._modes = self._mode_report()
        self._blend = Blend(config.blend_time, period)
        self._reference: HandReference | None = None
        self._hands = unwritten_motion()  # of the newest tick, as is the following
        self._inverse = TaskInverse(np.empty((2, 7, 3)), np.empty((2, 7, 7)))

    def reconfigure(self, config: ArmControllerConfig) -> None:
        """Takes over what may change while it runs: the mode and what decides about it."""
        self._config = config

    def step(self, inputs: ArmControllerInputs, time: float) -> ArmControllerOutputs:
        """The command of this tick."""
        del time
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        hands = self._kinematics.motion(q, v, self._hands)
        position = inputs.joints.position[self._arms]
        velocity = inputs.joints.velocity[self._arms]
        reference = self._reference = self._reference or self._first_reference(hands, position)
        wrenches = (inputs.left_hand or _NO_WRENCH, inputs.right_hand or _NO_WRENCH)
        felt = forces_in_task_axes(hands.yaw_to_world, wrenches[0].force, wrenches[1].force)
        if not reference.all_loaded:
            reference.take_load(
                felt, (inputs.left_hand is not None, inputs.right_hand is not None),
                self._law.return_force, self._impedance.stiffness,
            )  # fmt: skip
        self._choose_modes(felt)
        switch = self._switch
        if switch.switched:
            self._modes = self._mode_report()
        reference.receive((inputs.left_target, inputs.right_target))
        reference.glide(switch.yielding)
        if switch.anybody:
            reference.follow(switch.yielding, hands, position)

        stretch, hand_velocity, force = self._law.step(reference, hands, felt, self._stopped(reference))
        if switch.anybody:
            force = self._leading_force(force, hands, felt)
        posture_error = reference.posture - position
        wanted = self._joint_reference(hands, position, stretch, hand_velocity, posture_error)
        begun_anew = switch.changed if switch.switched else None
        acceleration = self._joint_acceleration(
            self._reference_acceleration.step(wanted.velocity, begun_anew),
            hands, force, wanted.velocity, posture_error, position, velocity,
        )  # fmt: skip
        acceleration = self._blend.step(acceleration, begun_anew)
        voltage, saturated = self._actuation.voltage(
            q, v, inputs.imu, hands, wrenches, velocity, acceleration
        )

        if self._config.limit_avoidance > 0.0:
            reference.move_posture(wanted.velocity)
        _note_saturated(saturated, reference.saturated)
        return ArmControllerOutputs(
            Joints(wanted.position.reshape(-1), wanted.velocity.reshape(-1), voltage), self._modes
        )

    def _first_reference(self, hands: HandMotion, position: Array) -> HandReference:
        config = self._config
        limits = GlideLimits(config.glide_speed, config.glide_turn, _GLIDE_RISE)
        return HandReference(hands.place, position, limits, self._period, config.limit_avoidance > 0.0)

    def _choose_modes(self, felt: Array) -> None:
        """Decides which hands yield at this tick."""
        config = self._config
        pull = leading_force(felt, config.payload) if config.payload else felt
        self._switch.step(config.mode, pull, config.auto_pulled, config.auto_released, config.auto_delay)

    def _mode_report(self) -> PrimitiveStates:
        words = [COMPENSATION if yields else IMPEDANCE for yields in self._switch.yielding]
        names = tuple(f"{side.value}_hand/{word}" for side, word in zip(SIDES, words, strict=True))
        return PrimitiveStates(names, (1.0, 1.0))

    def _stopped(self, reference: HandReference) -> Mask:
        """Hands that do not return to their places, shape (2,): the springs' ends never wind up."""
        if self._switch.anybody:
            stopped: Mask = reference.saturated | self._switch.yielding
            return stopped
        return reference.saturated

    def _joint_reference(
        self, hands: HandMotion, position: Array, stretch: Array, hand_velocity: Array, posture_error: Array
    ) -> JointReference:
        """q̇_d of eq. (6): back to the place, against what the body does, posture aside; and q_d."""
        config = self._config
        if config.limit_avoidance > 0.0:
            posture = limit_avoidance(position, self._lower, self._upper, config.limit_avoidance)
        else:
            posture = config.posture_return * posture_error
        if self._switch.anybody:
            posture = np.where(self._switch.yielding[:, None], 0.0, posture)
        return joint_reference(
            hands.jacobian, config.singular_threshold, config.singular_damping, position,
            self._lower, self._upper, stretch, hand_velocity, posture, self._inverse,
        )  # fmt: skip

    def _leading_force(self, force: Array, hands: HandMotion, felt: Array) -> Array:
        """What moves hands that are led, which have no springs; others keep `force`, shape (2, 3) [N]."""
        led = self._compensation.force(np.zeros((2, 3)), -hands.place_rate)
        led += leading_force(felt, self._config.payload)
        return np.where(self._switch.yielding[:, None], led, force)

    def _joint_acceleration(
        self, feedforward: Array, hands: HandMotion, force: Array,
        desired_velocity: Array, posture_error: Array, position: Array, velocity: Array,
    ) -> Array:  # fmt: skip
        """Corrected eq. (8) with its null-space term, and distance from the stops, shape (2, 7) [rad/s²]."""
        config = self._config
        return joint_acceleration(
            feedforward, self._impedance.inertia, hands.jacobian, *self._inverse, force,
            desired_velocity, posture_error, config.posture_stiffness, config.posture_damping,
            position, velocity, self._lower, self._upper, config.stop_stiffness, config.stop_damping,
        )  # fmt: skip


@kernel("void(boolean[::1], boolean[::1])")
def _note_saturated(joints: Mask, arms: Mask) -> None:
    """Writes which arm has a joint whose voltage was cut, from which joint of both has."""
    per_arm = joints.size // arms.size
    for arm in range(arms.size):
        arms[arm] = joints[per_arm * arm : per_arm * (arm + 1)].any()
