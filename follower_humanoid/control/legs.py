"""Leg and trunk control: sliding mode, feedback linearisation, volts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.control.floating_base import motor_torque
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.control.sliding_mode import SlidingMode, SlidingModeConfig
from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Wrench
from follower_humanoid.robot.model import ACTUATED, Indices, RobotModel
from follower_humanoid.robot.placed_frames import PlacedFrames

# How long the first reference may take [s].
FIRST_REFERENCE = 0.1
# Of a hand whose wrench has not been measured yet.
_NO_WRENCH = Wrench(np.zeros(3), np.zeros(3))


@dataclass(frozen=True)
class LegConfig:
    """Parameters of the leg controller."""

    ankle_weight: float = parameter(0.1, "σ of the ankles of a foot that carries", "", 0, 1)
    ankle_swing_weight: float = parameter(0.5, "σ of the ankles of a foot in the air", "", 0, 1)
    carrying: float = parameter(100.0, "normal force at which a foot carries fully", "N", 1, 500)
    neck_weight: float = parameter(0.2, "σ of the neck", "", 0, 1)
    stiffness: float = parameter(
        12000.0, "of stiff joints, when balance asks for no foot wrenches", "N·m/rad", 0, 1e5
    )
    damping: float = parameter(160.0, "of stiff joints", "N·m·s/rad", 0, 1e4)
    toe_stiffness: float = parameter(60.0, "spring of the toe joints", "N·m/rad", 0, 500)
    toe_damping: float = parameter(0.3, "damper of the toe joints", "N·m·s/rad", 0, 50)
    sliding_mode: SlidingModeConfig = field(default_factory=SlidingModeConfig)
    motor: MotorModel = field(default_factory=MotorModel)


class LegInputs(NamedTuple):
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


class LegOutputs(NamedTuple):
    """Motor voltages of legs, trunk and neck; None leaves the joints to the motor drives, which hold them."""

    command: Joints | None


class Tracking(NamedTuple):
    """How the driven joints follow their reference at one tick, each of shape (n,).

    Attributes:
        velocity: q̇ [rad/s].
        error: e = q_d − q [rad].
        error_velocity: ė [rad/s].
        feedforward: q̈_d: what q̇_d has changed by since the last tick [rad/s²].
        last_speed: q̇_d, for the next tick [rad/s].
    """

    velocity: Array
    error: Array
    error_velocity: Array
    feedforward: Array
    last_speed: Array


class LegController:
    """Drives legs, trunk and neck along the reference while the feet push as balance asks.

    Where balance asks for no foot wrenches, as the paper's law does, the joints are stiff instead: what
    the feet do follows from where they are sent.
    Before the first reference it holds the first measured posture, for a moment. Without one later it
    commands nothing: joints driven by a model of the robot need to know what the ground shall do to the feet.
    """

    Config = LegConfig
    Inputs = LegInputs
    Outputs = LegOutputs

    def __init__(self, config: LegConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._period = period
        self._legs = robot.groups.legs
        self._data = robot.pin_model.createData()
        self._mass_matrix: Array = self._data.M  # a view: it follows Pinocchio's algorithm
        self._motors = MotorInverse(config.motor, robot, self._legs)
        self._sliding = SlidingMode(config.sliding_mode, len(self._legs))
        names = [f"{side.prefix}_{frame}" for frame in ("sole", "gripper") for side in SIDES]
        self._contacts = PlacedFrames(robot, self._data, names)
        self._in_frame = np.array([name.endswith("sole") for name in names])
        self._wrenches: Array = np.zeros((len(names), 6))
        self._ankles, self._toes = _rows(robot, "ankle_pitch", "ankle_roll"), _rows(robot, "toe_pitch")
        self._weight: Array = np.where(np.isin(self._legs, robot.groups.neck), config.neck_weight, 1.0)
        self._weight[self._toes] = 0.0  # springs
        self._tracking = Tracking(*np.zeros((len(Tracking._fields), len(self._legs))))
        self._load: Array = np.zeros(len(SIDES))
        self._hold: Joints | None = None
        self._patience = FIRST_REFERENCE  # for a reference [s]
        self._silent = False
        self._toe_preload: Array = np.zeros(len(SIDES))
        self._first_load: Array = np.ones(len(SIDES))
        self._saturated = np.zeros(len(self._legs), dtype=bool)
        self._saturated_ticks = 0
        self._peak = 0.0

    def step(self, inputs: LegInputs, time: float) -> LegOutputs:
        """One tick: state and reference in, volts out."""
        del time
        self._patience = 0.0 if inputs.reference is not None else self._patience - self._period
        if self._patience < 0.0:
            self._silent = True
            return LegOutputs(None)
        joints, config, load, tracking = inputs.joints, self._config, self._load, self._tracking
        load[0], load[1] = inputs.left_foot.force[2], inputs.right_foot.force[2]
        if self._hold is None:
            self._hold = Joints(joints.position, np.zeros(ACTUATED), np.zeros(ACTUATED))
            self._toe_preload, self._first_load = joints.effort[self._legs][self._toes[:, 0]], load.copy()
        reference = inputs.reference or self._hold
        if self._silent:  # nothing is known of its acceleration
            tracking.last_speed[:] = reference.velocity[self._legs]
            self._silent = False
        wanted, speed = np.empty(len(self._legs)), np.empty(len(self._legs))
        _track(
            reference.position, reference.velocity, joints.position, joints.velocity, self._legs,
            self._period, wanted, speed, *tracking,
        )  # fmt: skip
        if inputs.reference is not None and inputs.left_foot_reference is None:
            torque = config.stiffness * tracking.error + config.damping * tracking.error_velocity
        else:
            torque = self._linearised(inputs)
        _load_toes(
            load, self._first_load, self._toe_preload, self._toes, tracking.error, tracking.error_velocity,
            config.toe_stiffness, config.toe_damping, torque,
        )  # fmt: skip
        voltage, self._saturated = self._motors.voltage(torque, tracking.velocity)
        self._count(voltage)
        return LegOutputs(Joints(wanted, speed, voltage))

    def diagnostics(self) -> dict[str, float | str]:
        """Peak voltage and ticks at the limit."""
        return {"peak_voltage [V]": self._peak, "saturated_ticks": self._saturated_ticks}

    def _linearised(self, inputs: LegInputs) -> Array:
        """Sliding mode and feedback linearisation, eq. (16): torque of legs, trunk and neck [N·m]."""
        config, tracking = self._config, self._tracking
        _weigh_ankles(
            self._load, self._ankles, config.carrying, config.ankle_weight, config.ankle_swing_weight,
            self._weight,
        )  # fmt: skip
        a = self._sliding.acceleration(
            tracking.error, tracking.error_velocity, tracking.feedforward, self._weight, self._saturated,
            self._period,
        )  # fmt: skip
        bias, external = self._dynamics(inputs)
        # The arms have a controller of their own, of whose accelerations nothing is known here.
        torque, _ = motor_torque(self._mass_matrix, bias, external, self._legs, a, self._motors.rotor_inertia)
        return torque

    def _dynamics(self, inputs: LegInputs) -> tuple[Array, Array]:
        """n and the generalised force of desired foot and sensed hand wrenches; M is left in the data."""
        model, data = self._robot.pin_model, self._data
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        pin.crba(model, data, q, pin.Convention.WORLD)
        bias: Array = pin.nonLinearEffects(model, data, q, v)
        left_foot = inputs.left_foot_reference or inputs.left_foot
        right_foot = inputs.right_foot_reference or inputs.right_foot
        left_hand, right_hand = inputs.left_hand or _NO_WRENCH, inputs.right_hand or _NO_WRENCH
        _put_in_rows(
            left_foot.force, left_foot.torque, right_foot.force, right_foot.torque,
            left_hand.force, left_hand.torque, right_hand.force, right_hand.torque, self._wrenches,
        )  # fmt: skip
        external = np.zeros(model.nv)
        self._contacts.add_wrenches(self._wrenches, self._in_frame, external)
        return bias, external

    def _count(self, voltage: Array) -> None:
        largest, any_saturated = _look_over(voltage, self._saturated)
        self._peak = max(self._peak, largest)
        self._saturated_ticks += any_saturated


@kernel(
    "void(float64[:], float64[:], float64[:], float64[:], intp[::1], float64, float64[::1], float64[::1],"
    " float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])"
)
def _track(
    reference: Array, reference_velocity: Array, measured: Array, measured_velocity: Array, joints: Indices,
    period: float, wanted: Array, speed: Array,
    velocity: Array, error: Array, error_velocity: Array, feedforward: Array, last_speed: Array,
) -> None:  # fmt: skip
    """Writes q_d, q̇_d and a `Tracking` of some of all joints, whose reference and state are given."""
    for n in range(joints.size):
        joint = joints[n]
        wanted[n], speed[n] = reference[joint], reference_velocity[joint]
        velocity[n] = measured_velocity[joint]
        error[n] = wanted[n] - measured[joint]
        error_velocity[n] = speed[n] - velocity[n]
        feedforward[n] = (speed[n] - last_speed[n]) / period
        last_speed[n] = speed[n]


@kernel(
    "void(float64[:], float64[:], float64[:], float64[:], float64[:], float64[:], float64[:], float64[:],"
    " float64[:,::1])"
)
def _put_in_rows(
    force_0: Array, torque_0: Array, force_1: Array, torque_1: Array, force_2: Array, torque_2: Array,
    force_3: Array, torque_3: Array, rows: Array,
) -> None:  # fmt: skip
    """Writes four wrenches one below the other, (4, 6): less work than to join eight small arrays."""
    rows[0, :3], rows[0, 3:] = force_0, torque_0
    rows[1, :3], rows[1, 3:] = force_1, torque_1
    rows[2, :3], rows[2, 3:] = force_2, torque_2
    rows[3, :3], rows[3, 3:] = force_3, torque_3


@kernel("Tuple((float64, boolean))(float64[::1], boolean[::1])")
def _look_over(voltage: Array, saturated: NDArray[np.bool_]) -> tuple[float, bool]:
    """Largest voltage of either sign [V], and whether any was cut."""
    largest, any_saturated = 0.0, False
    for joint in range(voltage.size):
        largest = max(largest, abs(voltage[joint]))
        any_saturated = any_saturated or saturated[joint]
    return largest, any_saturated


def _rows(robot: RobotModel, *names: str) -> Indices:
    """Where joints of left and right stand in the command, shape (2, joints)."""
    legs = robot.groups.legs.tolist()
    return np.array(
        [[legs.index(robot.joint_index(f"{side.prefix}_{name}")) for name in names] for side in SIDES]
    )


@kernel("void(float64[::1], intp[:,::1], float64, float64, float64, float64[::1])")
def _weigh_ankles(
    load: Array, ankles: Indices, carrying: float, standing: float, swinging: float, weight: Array
) -> None:
    """σ of the ankles: those of a foot that carries give way to the foot wrench.

    Args:
        load: Normal forces of the feet, shape (2,) [N].
        ankles: Where their joints stand in `weight`, shape (2, 2).
        carrying: Load at which a foot carries fully [N].
        standing, swinging: σ of a foot that carries, and in the air.
        weight: σ of all joints, written to.
    """
    for foot in range(load.size):
        share = min(max(load[foot] / carrying, 0.0), 1.0)
        for joint in ankles[foot]:
            weight[joint] = share * standing + (1.0 - share) * swinging


@kernel(
    "void(float64[::1], float64[::1], float64[::1], intp[:,::1], float64[::1], float64[::1],"
    " float64, float64, float64[::1])"
)
def _load_toes(
    load: Array, first_load: Array, preload: Array, toes: Indices, error: Array, error_velocity: Array,
    stiffness: float, damping: float, torque: Array,
) -> None:  # fmt: skip
    """Springs that carry the toes' part of the foot's load.

    That part is what they carried at the first tick, in proportion to the load since.

    Args:
        load, first_load: Normal forces of the feet now and at the first tick, shape (2,) [N].
        preload: What the toes carried then, shape (2,) [N·m].
        toes: Where they stand among the joints, shape (2, 1).
        error, error_velocity: Of all joints [rad], [rad/s].
        stiffness, damping: [N·m/rad], [N·m·s/rad].
        torque: Of all joints, written to [N·m].
    """
    for foot in range(load.size):
        carried = min(max(load[foot] / max(first_load[foot], 1.0), 0.0), 1.0)
        for toe in toes[foot]:
            torque[toe] = preload[foot] * carried + stiffness * error[toe] + damping * error_velocity[toe]
