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
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Side, Wrench
from follower_humanoid.robot.model import GRAVITY, RobotModel
from follower_humanoid.robot.pose_table import pose_table
from follower_humanoid.sensing.hand_state import SHAPE, external_wrench, hand_state
from follower_humanoid.sensing.low_pass import LowPass


@dataclass(frozen=True)
class HandWrenchConfig:
    """Parameters of the wrench sensing."""

    filter_time: float = parameter(
        0.008, "time constant of the low-pass on the sensed wrench; 0: none", "s", 0.0, 0.3
    )


class HandWrenchInputs(NamedTuple):
    """State and wrist sensors of one tick."""

    joints: Joints
    odometry: Odometry
    left_wrist: Wrench
    right_wrist: Wrench


class HandWrenchOutputs(NamedTuple):
    """What others do to the hands: axes of world, moment about `l_gripper`, `r_gripper`."""

    left_hand: Wrench
    right_hand: Wrench


class _Hand:
    """What the URDF says about one hand, and what the sensing remembers of it."""

    def __init__(
        self, robot: RobotModel, side: Side, data: pin.Data, filter_time: float, period: float
    ) -> None:
        model = robot.pin_model
        wrist = model.frames[robot.frame_id(f"{side.prefix}_wrist")]
        gripper = model.frames[robot.frame_id(f"{side.prefix}_gripper")]
        joint = int(wrist.parentJoint)
        hand = model.inertias[joint]
        # Views of Pinocchio's memory: they follow the kinematics.
        self._pose, self._twist = pose_table(data.oMi)[joint], data.v[joint].vector
        self._wrist = np.vstack((wrist.placement.rotation.T, wrist.placement.translation))
        self._gripper: Array = gripper.placement.translation.copy()
        self._mass, self._center = float(hand.mass), hand.lever.copy()
        self._inertia = np.ascontiguousarray(hand.inertia)
        self._period = period
        self._filter = LowPass(filter_time, period)
        self._reading = np.zeros(6)
        self._before: Array | None = None

    def step(self, wrist: Wrench) -> Wrench:
        """The external wrench of this tick, after forward kinematics."""
        now = np.empty(SHAPE)
        hand_state(
            self._pose, self._twist, self._mass, self._center, self._inertia, self._wrist, self._gripper, now
        )
        before = now if self._before is None else self._before
        self._before = now
        np.concatenate((wrist.force, wrist.torque), out=self._reading)
        sample = np.empty(6)
        external_wrench(before, now, self._reading, self._mass * GRAVITY, self._period, sample)
        external = self._filter.step(sample)
        return Wrench(external[:3], external[3:])


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
        self._left, self._right = (
            _Hand(robot, side, self._data, config.filter_time, period) for side in SIDES
        )

    def step(self, inputs: HandWrenchInputs, time: float) -> HandWrenchOutputs:
        """The wrenches of this tick."""
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        pin.forwardKinematics(self._robot.pin_model, self._data, q, v)
        return HandWrenchOutputs(
            left_hand=self._left.step(inputs.left_wrist), right_hand=self._right.step(inputs.right_wrist)
        )
