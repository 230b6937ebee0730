"""External wrench on each hand from the wrist sensor: the hand's weight and inertia taken out.

With F_s what the hand does to the forearm, Newton's law of the hand (mass m, CoM c) reads

    m (c̈ − g) = F_ext − F_s     ⇒     F_ext = m (c̈ − g) + F_s

and likewise for moments. The sensor gives the mean over the last control tick; so does the
difference of the hand's momentum over that tick, which is why no acceleration is ever
differentiated twice or filtered on one side only. Nothing is tared while running: taring would
swallow the very pull that is to be followed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Side, Wrench
from follower_humanoid.robot.model import GRAVITY, RobotModel
from follower_humanoid.sensing.low_pass import LowPass


@dataclass(frozen=True)
class HandWrenchConfig:
    """Parameters of the wrench sensing."""

    filter_time: float = parameter(
        0.008, "time constant of the low-pass on the sensed wrench; 0: none", "s", 0.0, 0.3
    )


@dataclass(frozen=True)
class HandWrenchInputs:
    """State and wrist sensors of one tick."""

    joints: Joints
    odometry: Odometry
    left_wrist: Wrench
    right_wrist: Wrench


@dataclass(frozen=True)
class HandWrenchOutputs:
    """What others do to the hands: axes of world, moment about `l_gripper`, `r_gripper`."""

    left_hand: Wrench
    right_hand: Wrench


@dataclass(frozen=True)
class _HandState:
    """A hand at one tick.

    Attributes:
        placement: Hand link in world.
        momentum: Linear and angular momentum, at and in the link.
        gripper: Gripper position in world, shape (3,) [m].
    """

    placement: pin.SE3
    momentum: pin.Force
    gripper: Array

    def seen_from(self, point: Array) -> pin.SE3:
        """Transport of a wrench at and in the link to world axes at `point`."""
        return pin.SE3(self.placement.rotation, self.placement.translation - point)


class _Hand:
    """What the URDF says about one hand, and what the sensing remembers of it."""

    def __init__(self, robot: RobotModel, side: Side, filter_time: float, period: float) -> None:
        model = robot.pin_model
        wrist = model.frames[robot.frame_id(f"{side.prefix}_wrist")]
        gripper = model.frames[robot.frame_id(f"{side.prefix}_gripper")]
        inertia = model.inertias[wrist.parentJoint]
        self.joint = int(wrist.parentJoint)
        self.wrist_in_joint: pin.SE3 = wrist.placement
        self.gripper_in_joint: Array = gripper.placement.translation.copy()
        self.inertia: pin.Inertia = inertia
        self.center_in_wrist: Array = wrist.placement.actInv(inertia.lever)
        self.weight = inertia.mass * GRAVITY
        self.filter = LowPass(filter_time, period)
        self.before: _HandState | None = None

    def state(self, data: pin.Data) -> _HandState:
        """The hand after forward kinematics."""
        joint_in_world = data.oMi[self.joint]
        return _HandState(
            placement=joint_in_world * self.wrist_in_joint,
            momentum=self.wrist_in_joint.actInv(self.inertia * data.v[self.joint]),
            gripper=joint_in_world.act(self.gripper_in_joint),
        )

    def weight_about(self, to_reference: pin.SE3) -> Array:
        """Weight of the hand about the reference point, world axes, shape (6,)."""
        x, y, _ = to_reference.act(self.center_in_wrist).tolist()
        return np.array([0.0, 0.0, -self.weight, -y * self.weight, x * self.weight, 0.0])


class HandWrenchSensing:
    """Component: wrist sensors and robot state in, external wrench on each hand out.

    At the first tick the hand is taken to be at rest, which is how time 0 begins.
    """

    Config = HandWrenchConfig
    Inputs = HandWrenchInputs
    Outputs = HandWrenchOutputs

    def __init__(self, config: HandWrenchConfig, robot: RobotModel, period: float) -> None:
        self._robot = robot
        self._data = robot.pin_model.createData()
        self._period = period
        self._left, self._right = (_Hand(robot, side, config.filter_time, period) for side in SIDES)

    def step(self, inputs: HandWrenchInputs, time: float) -> HandWrenchOutputs:
        """The wrenches of this tick."""
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        pin.forwardKinematics(self._robot.pin_model, self._data, q, v)
        return HandWrenchOutputs(
            left_hand=self._external(self._left, inputs.left_wrist),
            right_hand=self._external(self._right, inputs.right_wrist),
        )

    def _external(self, hand: _Hand, wrist: Wrench) -> Wrench:
        now = hand.state(self._data)
        before = hand.before or now
        hand.before = now
        reference = 0.5 * (now.gripper + before.gripper)
        to_now, to_before = now.seen_from(reference), before.seen_from(reference)

        reading = pin.Force(wrist.force, wrist.torque)
        hand_on_forearm = (to_now.act(reading) + to_before.act(reading)).vector / 2
        momentum_rate = (to_now.act(now.momentum) - to_before.act(before.momentum)).vector / self._period
        weight = (hand.weight_about(to_now) + hand.weight_about(to_before)) / 2

        external = hand.filter.step(momentum_rate - weight + hand_on_forearm)
        return Wrench(external[:3], external[3:])
