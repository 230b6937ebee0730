"""Leg and trunk control: sliding mode, feedback linearisation, volts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from follower_humanoid.control.floating_base import motor_torque
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.control.sliding_mode import SlidingMode, SlidingModeConfig
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Side, Wrench
from follower_humanoid.robot.model import ACTUATED, RobotModel


@dataclass(frozen=True)
class LegConfig:
    """Parameters of the leg controller."""

    ankle_weight: float = parameter(0.1, "σ of the ankles of a foot that carries", "", 0, 1)
    ankle_swing_weight: float = parameter(0.5, "σ of the ankles of a foot in the air", "", 0, 1)
    carrying: float = parameter(100.0, "normal force at which a foot carries fully", "N", 1, 500)
    neck_weight: float = parameter(0.2, "σ of the neck", "", 0, 1)
    toe_stiffness: float = parameter(60.0, "spring of the toe joints", "N·m/rad", 0, 500)
    toe_damping: float = parameter(0.3, "damper of the toe joints", "N·m·s/rad", 0, 50)
    sliding_mode: SlidingModeConfig = field(default_factory=SlidingModeConfig)
    motor: MotorModel = field(default_factory=MotorModel)


@dataclass(frozen=True, slots=True)
class LegInputs:
    """State of the tick; reference and desired foot wrenches are None before the first ones."""

    joints: Joints
    odometry: Odometry
    left_foot: Wrench
    right_foot: Wrench
    left_hand: Wrench | None
    right_hand: Wrench | None
    reference: Joints | None
    left_foot_reference: Wrench | None
    right_foot_reference: Wrench | None


@dataclass(frozen=True, slots=True)
class LegOutputs:
    """Motor voltages of legs, trunk and neck."""

    command: Joints


class LegController:
    """Drives legs, trunk and neck along the reference while the feet push as balance asks.

    Before a reference comes it holds the first measured posture, with the foot wrenches it measured.
    """

    Config = LegConfig
    Inputs = LegInputs
    Outputs = LegOutputs

    def __init__(self, config: LegConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._period = period
        self._data = robot.pin_model.createData()
        self._motors = MotorInverse(config.motor, robot)
        self._sliding = SlidingMode(config.sliding_mode, ACTUATED)
        self._soles = {side: robot.frame_id(f"{side.prefix}_sole") for side in SIDES}
        self._grippers = {side: robot.frame_id(f"{side.prefix}_gripper") for side in SIDES}
        self._ankles = {
            side: np.array([robot.joint_index(f"{side.prefix}_ankle_{axis}") for axis in ("pitch", "roll")])
            for side in SIDES
        }
        self._toes = np.array([robot.joint_index(f"{side.prefix}_toe_pitch") for side in SIDES])
        self._saturated = np.zeros(ACTUATED, dtype=bool)
        self._hold: Array | None = None
        self._toe_preload: Array = np.zeros(len(SIDES))
        self._first_load: Array = np.ones(len(SIDES))
        self._last_velocity: Array = np.zeros(ACTUATED)
        self._saturated_ticks = 0
        self._peak = 0.0

    def step(self, inputs: LegInputs, time: float) -> LegOutputs:
        """One tick: state and reference in, volts out."""
        del time
        joints, motors = inputs.joints, self._motors
        if self._hold is None:
            self._hold = joints.position
            self._toe_preload = joints.effort[self._toes]
            self._first_load = self._loads(inputs)
        wanted, speed = self._hold, np.zeros(ACTUATED)
        if inputs.reference is not None:
            wanted, speed = inputs.reference.position, inputs.reference.velocity
        feedforward = (speed - self._last_velocity) / self._period
        self._last_velocity = speed
        a = self._sliding.acceleration(
            wanted - joints.position, speed - joints.velocity, feedforward, self._weights(inputs),
            self._saturated, self._period,
        )  # fmt: skip
        # The arms have a controller of their own; the toes are springs.
        a[self._robot.groups.arms] = 0.0
        a[self._toes] = feedforward[self._toes]
        q, v = self._robot.state(inputs.odometry, joints)
        mass_matrix, bias, external = self._dynamics(inputs, q, v)
        torque, _ = motor_torque(mass_matrix, bias, external, a, motors.rotor_inertia)
        torque[self._toes] = self._toe_torque(inputs, wanted, speed)
        voltage = motors.voltage(torque, joints.velocity)
        limited = np.clip(voltage, -motors.voltage_limit, motors.voltage_limit)
        self._saturated = limited != voltage
        legs = self._robot.groups.legs
        self._count(limited[legs], self._saturated[legs])
        return LegOutputs(Joints(wanted[legs], speed[legs], limited[legs]))

    def diagnostics(self) -> dict[str, float | str]:
        """Peak voltage and ticks at the limit."""
        return {"peak_voltage [V]": self._peak, "saturated_ticks": self._saturated_ticks}

    def _dynamics(self, inputs: LegInputs, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """M, n and the generalised force of desired foot and sensed hand wrenches."""
        model, data = self._robot.pin_model, self._data
        pin.computeJointJacobians(model, data, q)
        upper = pin.crba(model, data, q)
        mass_matrix = np.triu(upper) + np.triu(upper, 1).T
        bias = np.array(pin.nonLinearEffects(model, data, q, v))
        external = np.zeros(model.nv)
        feet = (
            (inputs.left_foot_reference or inputs.left_foot),
            (inputs.right_foot_reference or inputs.right_foot),
        )
        for side, wrench in zip(SIDES, feet, strict=True):
            pin.updateFramePlacement(model, data, self._soles[side])
            jacobian = pin.getFrameJacobian(model, data, self._soles[side], pin.ReferenceFrame.LOCAL)
            external += jacobian[:3].T @ wrench.force + jacobian[3:].T @ wrench.torque
        for side, hand in zip(SIDES, (inputs.left_hand, inputs.right_hand), strict=True):
            if hand is None:
                continue
            pin.updateFramePlacement(model, data, self._grippers[side])
            jacobian = pin.getFrameJacobian(
                model, data, self._grippers[side], pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            external += jacobian[:3].T @ hand.force + jacobian[3:].T @ hand.torque
        return mass_matrix, bias, external

    def _toe_torque(self, inputs: LegInputs, wanted: Array, speed: Array) -> Array:
        """Springs that carry the toes' part of the foot's load, shape (2,) [N·m].

        That part is what they carried at the first tick, in proportion to the load since.
        """
        config, joints, toes = self._config, inputs.joints, self._toes
        carried = np.clip(self._loads(inputs) / np.maximum(self._first_load, 1.0), 0.0, 1.0)
        spring = config.toe_stiffness * (wanted - joints.position)[toes]
        return np.asarray(
            self._toe_preload * carried + spring + config.toe_damping * (speed - joints.velocity)[toes]
        )

    @staticmethod
    def _loads(inputs: LegInputs) -> Array:
        """Normal forces of the feet, shape (2,) [N]."""
        return np.array([inputs.left_foot.force[2], inputs.right_foot.force[2]])

    def _weights(self, inputs: LegInputs) -> Array:
        """σ: ankles of a foot that carries give way to the foot wrench."""
        config = self._config
        weight = np.ones(ACTUATED)
        weight[self._robot.groups.neck] = config.neck_weight
        for side, foot in ((Side.LEFT, inputs.left_foot), (Side.RIGHT, inputs.right_foot)):
            carried = min(max(float(foot.force[2]) / config.carrying, 0.0), 1.0)
            weight[self._ankles[side]] = (
                carried * config.ankle_weight + (1.0 - carried) * config.ankle_swing_weight
            )
        return weight

    def _count(self, voltage: Array, saturated: Array) -> None:
        self._peak = max(self._peak, float(np.max(np.abs(voltage))))
        self._saturated_ticks += int(bool(np.any(saturated)))
