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
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Wrench
from follower_humanoid.robot.model import GRAVITY, Indices, RobotModel
from follower_humanoid.robot.pose_table import pose_table
from follower_humanoid.sensing.hand_state import SHAPE, follow_hands
from follower_humanoid.sensing.low_pass import filter_share


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


class _Hands(NamedTuple):
    """What the URDF says about both hands, left first, in the axes of the joints that carry them.

    Attributes:
        joints: Pinocchio's ids of these joints, shape (2,).
        masses, centers: m [kg] and CoM [m], shapes (2,), (2, 3).
        inertias: About the CoM, shape (2, 3, 3) [kg·m²].
        wrists: Axes (rows) and origin of the wrist frames, shape (2, 4, 3).
        grippers: Origins of the gripper frames, shape (2, 3) [m].
    """

    joints: Indices
    masses: Array
    centers: Array
    inertias: Array
    wrists: Array
    grippers: Array


def _hands(robot: RobotModel) -> _Hands:
    model = robot.pin_model
    wrists, grippers = (
        [model.frames[robot.frame_id(f"{side.prefix}_{name}")] for side in SIDES]
        for name in ("wrist", "gripper")
    )
    joints = np.array([wrist.parentJoint for wrist in wrists], dtype=np.intp)
    hands = [model.inertias[joint] for joint in joints.tolist()]
    return _Hands(
        joints,
        masses=np.array([hand.mass for hand in hands]),
        centers=np.array([hand.lever for hand in hands]),
        inertias=np.array([hand.inertia for hand in hands]),
        wrists=np.array([np.vstack((w.placement.rotation.T, w.placement.translation)) for w in wrists]),
        grippers=np.array([gripper.placement.translation for gripper in grippers]),
    )


class HandWrenchSensing:
    """Component: wrist sensors and robot state in, external wrench on each hand out.

    At the first tick the hand is taken to be at rest, which is how time 0 begins.
    """

    Config = HandWrenchConfig
    Inputs = HandWrenchInputs
    Outputs = HandWrenchOutputs

    def __init__(self, config: HandWrenchConfig, robot: RobotModel, period: float) -> None:
        self._robot = robot
        self._data = data = robot.pin_model.createData()
        self._hands = _hands(robot)
        # Views of Pinocchio's memory: they follow the kinematics.
        self._poses = pose_table(data.oMi)
        self._left_twist, self._right_twist = (data.v[joint].vector for joint in self._hands.joints.tolist())
        self._period, self._share = period, filter_share(config.filter_time, period)
        self._first = True
        self._states, self._filtered = np.zeros((len(SIDES), *SHAPE)), np.zeros((len(SIDES), 6))
        self._parts = self._filtered.reshape(-1, 3)  # the same: force and moment of either hand

    def step(self, inputs: HandWrenchInputs, time: float) -> HandWrenchOutputs:
        """The wrenches of this tick."""
        del time
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        pin.forwardKinematics(self._robot.pin_model, self._data, q, v)
        left, right = inputs.left_wrist, inputs.right_wrist
        follow_hands(
            self._poses, self._hands.joints, self._left_twist, self._right_twist, *self._hands[1:],
            left.force, left.torque, right.force, right.torque,
            GRAVITY, self._period, self._share, self._first, self._states, self._filtered,
        )  # fmt: skip
        self._first = False
        left_force, left_moment, right_force, right_moment = self._parts.copy()
        return HandWrenchOutputs(Wrench(left_force, left_moment), Wrench(right_force, right_moment))
