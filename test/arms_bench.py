"""A test bench for the arms: Pinocchio forward dynamics with motors, everything else prescribed.

Independent of the package's plant: base, legs, trunk and neck follow a given motion exactly, the
arms are integrated with motor voltages, wrist sensors are read from the joint reactions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.core.samples import SIDES, Array, Inertial, Joints, Odometry, Side, Wrench
from follower_humanoid.robot.model import RobotModel

STEP = 0.001
TICK = 0.002
PREFIX = {Side.LEFT: "l", Side.RIGHT: "r"}

# Base pose as (x, y, z, yaw, pitch, roll) over time; trunk joints follow their own function.
BaseMotion = Callable[[float], Array]


def at_rest(time: float) -> Array:
    return np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])


def carrying(robot: RobotModel) -> Array:
    """Joint positions with both forearms forward, shape (45,)."""
    position = np.zeros(45)
    for prefix, sign in (("l", 1.0), ("r", -1.0)):
        position[robot.joint_index(f"{prefix}_shoulder_pitch")] = 0.25
        position[robot.joint_index(f"{prefix}_shoulder_roll")] = 0.12 * sign
        position[robot.joint_index(f"{prefix}_elbow")] = -1.5
    return position


@dataclass
class Bench:
    """State and one tick of integration."""

    robot: RobotModel
    base: BaseMotion = at_rest
    trunk: Callable[[float], Array] | None = None
    motor: MotorModel = field(default_factory=MotorModel)

    def __post_init__(self) -> None:
        self.model = self.robot.pin_model
        self.data = self.model.createData()
        self.arms = self.robot.groups.arms
        self.motors = MotorInverse(self.motor, self.robot, self.arms)
        self.time = 0.0
        self.position = carrying(self.robot)
        self.arm_velocity = np.zeros(14)
        self.hand = {side: self.model.getJointId(f"{PREFIX[side]}_wrist_roll") for side in SIDES}
        self.gripper = {side: self.robot.frame_id(f"{PREFIX[side]}_gripper") for side in SIDES}
        self.readings = {side: np.zeros(6) for side in SIDES}
        self.peak_voltage = 0.0
        q, v, a = self._rest(self.time)
        v[6 + self.arms] = 0.0
        self._read_wrists(q, v, a, {}, 1.0)

    def _rest(self, time: float) -> tuple[Array, Array, Array]:
        """Full q, v, v̇ with the prescribed parts; the arms' velocity as it is, their v̇ zero."""
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
        steps = round(TICK / STEP)
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
