"""A test bench for the arms: Pinocchio forward dynamics with motors, everything else prescribed.

Independent of the package's plant: base, legs, trunk and neck follow a given motion exactly, the
arms are integrated with motor voltages, wrist sensors are read from the joint reactions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from follower_humanoid.control.arms import ArmController, ArmControllerConfig
from follower_humanoid.control.hand_task import HandKinematics
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.core.samples import SIDES, Array, Inertial, Joints, Odometry, Side, Wrench
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.sensing.hand_wrench import HandWrenchConfig, HandWrenchSensing

STEP = 0.001
TICK = 0.002
PREFIX = {Side.LEFT: "l", Side.RIGHT: "r"}

# Base pose as (x, y, z, yaw, pitch, roll) over time; trunk joints follow their own function.
BaseMotion = Callable[[float], Array]


def at_rest(time: float) -> Array:
    return np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])


def smooth(time: float, rise: float = 1.0) -> float:
    """From 0 to 1 with continuous acceleration."""
    u = min(max(time / rise, 0.0), 1.0)
    return u**3 * (10 - 15 * u + 6 * u * u)


def swaying(time: float) -> Array:
    """A pelvis that sways, bobs, tilts and turns faster than in walking at 1.2 s per stride."""
    a, w = smooth(time), 2 * np.pi / 1.2
    sway, bob = a * np.sin(w * time), a * np.sin(2 * w * time)
    return np.array([0.02 * bob, 0.04 * sway, 0.9 + 0.015 * bob, 0.1 * sway, 0.03 * bob, 0.03 * sway])


def bending(time: float) -> Array:
    """A trunk that follows, shape (15,)."""
    return 0.015 * smooth(time) * np.sin(2 * np.pi / 1.2 * time) * np.ones(15)


def turning(time: float) -> Array:
    """Walks on and turns by 36.87 degrees within 7 s."""
    sway = 0.03 * np.sin(time) * smooth(time)
    return np.array([0.15 * time, sway, 0.9, 0.6435 * smooth(time, 7.0), 0.0, 0.0])


def carrying(robot: RobotModel) -> Array:
    """Joint positions with both forearms forward, shape (45,)."""
    position = np.zeros(45)
    for prefix, sign in (("l", 1.0), ("r", -1.0)):
        position[robot.joint_index(f"{prefix}_shoulder_pitch")] = 0.25
        position[robot.joint_index(f"{prefix}_shoulder_roll")] = 0.12 * sign
        position[robot.joint_index(f"{prefix}_elbow")] = -1.5
    return position


def random_jacobians(seed: int) -> Array:
    """Jacobians of both hands at random arm postures away from singularities, shape (40, 3, 7)."""
    robot, rng = RobotModel(), np.random.default_rng(seed)
    kinematics = HandKinematics(robot)
    found = []
    while len(found) < 40:
        position = rng.uniform(robot.lower, robot.upper)
        q = np.concatenate(([0, 0, 0.9, 0, 0, 0, 1], position))
        for jacobian in kinematics.motion(q, np.zeros(51)).jacobian:
            if np.linalg.svd(jacobian, compute_uv=False)[-1] > 0.09:
                found.append(jacobian)
    return np.array(found[:40])


@dataclass
class Bench:
    """State and one tick of integration."""

    robot: RobotModel
    base: BaseMotion = at_rest
    trunk: Callable[[float], Array] | None = None
    motor: MotorModel = field(default_factory=MotorModel)
    tick_length: float = TICK
    position: Array | None = None
    held: dict[Side, Array] = field(default_factory=dict)  # forces that act before time 0 already

    def __post_init__(self) -> None:
        self.model = self.robot.pin_model
        self.data = self.model.createData()
        self.arms = self.robot.groups.arms
        self.motors = MotorInverse(self.motor, self.robot, self.arms)
        self.time = 0.0
        if self.position is None:
            self.position = carrying(self.robot)
        self.arm_velocity = np.zeros(14)
        self.hand = {side: self.model.getJointId(f"{PREFIX[side]}_wrist_roll") for side in SIDES}
        self.gripper = {side: self.robot.frame_id(f"{PREFIX[side]}_gripper") for side in SIDES}
        self.readings = {side: np.zeros(6) for side in SIDES}
        self.peak_voltage = 0.0
        q, v, a = self._rest(self.time)
        v[6 + self.arms] = 0.0
        self._read_wrists(q, v, a, self.held, 1.0)

    def _rest(self, time: float) -> tuple[Array, Array, Array]:
        """Full q, v, v̇ with the prescribed parts; the arms' velocity as it is, their v̇ zero."""
        if self.base is at_rest and self.trunk is None:
            return self._at_rest(time)
        h = 1e-4

        def pose(t: float) -> pin.SE3:
            x, y, z, yaw, pitch, roll = self.base(t)
            return pin.SE3(pin.rpy.rpyToMatrix(roll, pitch, yaw), np.array([x, y, z]))

        before, now, after = pose(time - h), pose(time), pose(time + h)
        twist = (pin.log6(now.actInv(after)).vector - pin.log6(now.actInv(before)).vector) / (2 * h)
        rate = (pin.log6(now.actInv(after)).vector + pin.log6(now.actInv(before)).vector) / h**2
        q = np.concatenate((now.translation, pin.Quaternion(now.rotation).coeffs(), self.position))
        v, a = np.zeros(51), np.zeros(51)
        v[:6], a[:6] = twist, rate
        if self.trunk is not None:
            index = self.robot.groups.trunk
            q[7 + index] = self.trunk(time)
            v[6 + index] = (self.trunk(time + h) - self.trunk(time - h)) / (2 * h)
            a[6 + index] = (self.trunk(time + h) - 2 * self.trunk(time) + self.trunk(time - h)) / h**2
        v[6 + self.arms] = self.arm_velocity
        return q, v, a

    def _at_rest(self, time: float) -> tuple[Array, Array, Array]:
        """As `_rest` for a base that does not move, without differentiating it."""
        v = np.zeros(51)
        v[6 + self.arms] = self.arm_velocity
        return np.concatenate((self.base(time)[:3], [0, 0, 0, 1], self.position)), v, np.zeros(51)

    def state(self) -> tuple[Joints, Odometry, Inertial]:
        q, v, a = self._rest(self.time)
        rotation = pin.Quaternion(q[3:7]).matrix()
        specific = a[:3] + np.cross(v[3:6], v[:3]) + rotation.T @ np.array([0, 0, 9.81])
        return (
            Joints(q[7:].copy(), v[6:].copy(), np.zeros(45)),
            Odometry(q[:3].copy(), q[3:7].copy(), v[:3].copy(), v[3:6].copy()),
            Inertial(q[3:7].copy(), v[3:6].copy(), specific),
        )

    def wrist(self, side: Side) -> Wrench:
        return Wrench(self.readings[side][:3].copy(), self.readings[side][3:].copy())

    def hand_place(self, side: Side) -> Array:
        """Gripper relative to base_link in pelvis-yaw axes."""
        q, _, _ = self._rest(self.time)
        pin.framesForwardKinematics(self.model, self.data, q)
        yaw = self.base(self.time)[3]
        c, s = np.cos(yaw), np.sin(yaw)
        turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        place: Array = turn @ (self.data.oMf[self.gripper[side]].translation - q[:3])
        return place

    def tick(self, voltage: Array, force: dict[Side, Array]) -> None:
        """One control tick with held voltages (14) and forces [N] in world at the grippers."""
        self.peak_voltage = max(self.peak_voltage, float(np.abs(voltage).max()))
        steps = round(self.tick_length / STEP)
        for side in SIDES:
            self.readings[side] = np.zeros(6)
        rows = 6 + self.arms
        for _ in range(steps):
            q, v, a = self._rest(self.time)
            mass = pin.crba(self.model, self.data, q)
            mass = np.triu(mass) + np.triu(mass, 1).T
            bias = pin.nonLinearEffects(self.model, self.data, q, v)
            pin.computeJointJacobians(self.model, self.data, q)
            pin.updateFramePlacements(self.model, self.data)
            generalised = self.motors.torque_per_volt * voltage - self.motors.damping * self.arm_velocity
            generalised -= bias[rows] + mass[rows] @ a
            for side, newton in force.items():
                jacobian = pin.getFrameJacobian(
                    self.model, self.data, self.gripper[side], pin.LOCAL_WORLD_ALIGNED
                )
                generalised += jacobian[:3, rows].T @ newton
            implicit = np.diag(self.motors.rotor_inertia + STEP * self.motors.damping)
            a[rows] = np.linalg.solve(mass[np.ix_(rows, rows)] + implicit, generalised)
            self._read_wrists(q, v, a, force, 1.0 / steps)
            self.arm_velocity = self.arm_velocity + STEP * a[rows]
            self.position = q[7:].copy()
            self.position[self.arms] += STEP * self.arm_velocity
            self.time += STEP

    def _read_wrists(self, q: Array, v: Array, a: Array, force: dict[Side, Array], share: float) -> None:
        pin.rnea(self.model, self.data, q, v, a)
        pin.forwardKinematics(self.model, self.data, q)  # rnea leaves the joints' world placements alone
        pin.updateFramePlacements(self.model, self.data)
        for side in SIDES:
            placement = self.data.oMi[self.hand[side]]
            external = pin.Force.Zero()
            if side in force:
                offset = self.model.frames[self.gripper[side]].placement.translation
                local = placement.rotation.T @ force[side]
                external = pin.Force(local, np.cross(offset, local))
            reaction = (self.data.f[self.hand[side]] - external).vector
            self.readings[side] = self.readings[side] - share * reaction


@dataclass(frozen=True)
class Trace:
    """What a bench run did, one row per tick, left hand first.

    Attributes:
        time: Shape (T,).
        shift: Hands relative to their first places, pelvis-yaw axes, shape (T, 2, 3).
        sensed: Sensed wrenches, shape (T, 2, 6).
        applied: Applied forces, shape (T, 2, 3).
        arm_velocity: Shape (T, 14).
        voltage: Shape (T, 14).
    """

    time: Array
    shift: Array
    sensed: Array
    applied: Array
    arm_velocity: Array
    voltage: Array

    @property
    def left(self) -> Array:
        """Shift of the left hand [m]."""
        return self.shift[:, 0]

    @property
    def right(self) -> Array:
        """Shift of the right hand [m]."""
        return self.shift[:, 1]


Forces = Callable[[float], dict[Side, Array]]


def nobody(time: float) -> dict[Side, Array]:
    return {}


def on_left(*force: float) -> Forces:
    """A constant force on the left hand from time 0 on."""
    return lambda time: {Side.LEFT: np.array(force)}


def run_arms(
    bench: Bench, seconds: float, forces: Forces = nobody, config: ArmControllerConfig | None = None
) -> Trace:
    """Arm controller and wrench sensing on the bench, wired as in the graph."""
    period = bench.tick_length
    sensing = HandWrenchSensing(HandWrenchConfig(), bench.robot, period)
    controller = ArmController(config or ArmControllerConfig(), bench.robot, period)
    first = np.array([bench.hand_place(side) for side in SIDES])
    sensed, rows = None, []
    for _ in range(round(seconds / period)):
        joints, odometry, imu = bench.state()
        left, right = (sensed.left_hand, sensed.right_hand) if sensed else (None, None)
        inputs = ArmController.Inputs(joints, odometry, imu, left, right)
        command = controller.step(inputs, bench.time).command
        wrists = (bench.wrist(side) for side in SIDES)
        sensed = sensing.step(HandWrenchSensing.Inputs(joints, odometry, *wrists), bench.time)
        wrenches = (sensed.left_hand, sensed.right_hand)
        force = forces(bench.time)
        rows.append(
            (
                bench.time,
                np.array([bench.hand_place(side) for side in SIDES]) - first,
                np.array([np.concatenate((wrench.force, wrench.torque)) for wrench in wrenches]),
                np.array([force.get(side, np.zeros(3)) for side in SIDES]),
                bench.arm_velocity,
                command.effort,
            )
        )
        bench.tick(command.effort, force)
    return Trace(*(np.array(column) for column in zip(*rows, strict=True)))
