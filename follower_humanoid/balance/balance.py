"""ZMP balance: corrects the reference motion and says what the ground must do to the feet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from follower_humanoid.balance.balance_config import BalanceConfig
from follower_humanoid.balance.correction import Kinematics, Situation
from follower_humanoid.balance.dcm_balance import DcmBalance
from follower_humanoid.balance.hand_forces import HandEffect, hand_effect
from follower_humanoid.balance.paper_law import PaperBalance
from follower_humanoid.balance.shifted_reference import SOLES
from follower_humanoid.balance.support_polygon import ground_hull
from follower_humanoid.balance.zmp import measured_zmp
from follower_humanoid.balance.zmp_watch import ZmpWatch
from follower_humanoid.core.samples import (
    SIDES,
    Array,
    ContactPlan,
    Joints,
    Odometry,
    Point,
    Polygon,
    Wrench,
)
from follower_humanoid.robot.body_state import BodyState
from follower_humanoid.robot.model import RobotModel


class BalanceInputs(NamedTuple):
    """State of the tick, sensed hand wrenches and the reference; None before the first ones."""

    joints: Joints
    odometry: Odometry
    left_foot: Wrench
    right_foot: Wrench
    left_hand: Wrench | None
    right_hand: Wrench | None
    reference: Joints | None
    base: Odometry | None
    zmp_reference: Point | None
    dcm_reference: Point | None
    contacts: ContactPlan | None


class BalanceOutputs(NamedTuple):
    """What was measured, and once a reference came: its correction and the desired foot wrenches."""

    com: Point
    zmp: Point | None
    support_polygon: Polygon | None
    dcm: Point | None = None
    zmp_command: Point | None = None
    reference: Joints | None = None
    left_foot_reference: Wrench | None = None
    right_foot_reference: Wrench | None = None


class ZmpBalance:
    """Measures ZMP, CoM and support polygon, and has the chosen law correct the reference."""

    Config = BalanceConfig
    Inputs = BalanceInputs
    Outputs = BalanceOutputs

    def __init__(self, config: BalanceConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._body = BodyState(robot)
        self._wanted = BodyState(robot, SOLES)
        # Views that follow the body.
        frames = self._body.frames
        left_sole, right_sole = (frames[robot.frame_id(name)] for name in SOLES)
        self._soles = left_sole, right_sole
        self._grippers = [frames[robot.frame_id(f"{side.prefix}_gripper"), 3] for side in SIDES]
        left, right = ([robot.frame_id(f"{side.prefix}_contact_{i}") for i in range(1, 7)] for side in SIDES)
        # Of which feet carry: left, right.
        self._contacts = {
            (True, True): np.array(left + right), (True, False): np.array(left),
            (False, True): np.array(right), (False, False): np.zeros(0, dtype=np.int64),
        }  # fmt: skip
        self._watch = ZmpWatch()
        where = Kinematics(self._body, self._soles, self._wanted)
        self._law: DcmBalance | PaperBalance
        if config.law == "paper":
            self._law = PaperBalance(config.paper, config.offset.ik, config.feedback, robot, where, period)
        else:
            self._law = DcmBalance(config, robot, where, period)

    def step(self, inputs: BalanceInputs, time: float) -> BalanceOutputs:
        """One tick: measure, correct, distribute."""
        del time
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        self._body.update(q, v)
        zmp = measured_zmp(inputs.left_foot, inputs.right_foot, *self._soles, self._config.zmp.force_floor)
        polygon = self._support_polygon(inputs)
        self._watch.see(zmp, polygon, self._body.base[0])
        com, shown_zmp = Point(self._body.com.copy()), None if zmp is None else Point.on_ground(zmp)
        shown_polygon = None if polygon is None else Polygon(polygon)
        situation = self._situation(inputs, zmp)
        if situation is None:
            return BalanceOutputs(com, shown_zmp, shown_polygon)
        correction = self._law.correct(situation)
        self._watch.command(correction.zmp.xyz)
        return BalanceOutputs(
            com=com,
            zmp=shown_zmp,
            support_polygon=shown_polygon,
            dcm=correction.dcm,
            zmp_command=correction.zmp,
            reference=correction.reference,
            left_foot_reference=correction.left_foot,
            right_foot_reference=correction.right_foot,
        )

    def diagnostics(self) -> dict[str, float | str]:
        """How the ZMP keeps to its command and to the support polygon."""
        return self._watch.diagnostics()

    def _situation(self, inputs: BalanceInputs, measured: Array | None) -> Situation | None:
        """What the law works from; None before the reference is complete."""
        joints, base, contacts = inputs.reference, inputs.base, inputs.contacts
        zmp, dcm = inputs.zmp_reference, inputs.dcm_reference
        if joints is None or base is None or contacts is None or zmp is None or dcm is None:
            return None
        q_wanted = self._robot.configuration(base, joints.position)
        v_wanted = self._robot.velocity(base, joints.velocity)
        self._wanted.update(q_wanted, v_wanted)
        hands = self._hands(inputs)
        return Situation(hands, q_wanted, v_wanted, zmp, dcm, measured, contacts)

    def _hands(self, inputs: BalanceInputs) -> HandEffect:
        if not self._config.hand_forces:
            return hand_effect([], self._robot.mass)
        sensed = zip((inputs.left_hand, inputs.right_hand), self._grippers, strict=True)
        known = [(wrench, hand) for wrench, hand in sensed if wrench is not None]
        return hand_effect(known, self._robot.mass)

    def _support_polygon(self, inputs: BalanceInputs) -> Array | None:
        config = self._config.zmp
        carrying = (
            inputs.left_foot.force.item(2) > config.carrying,
            inputs.right_foot.force.item(2) > config.carrying,
        )
        hull = ground_hull(self._body.frames, self._contacts[carrying], config.clearance)
        return hull if len(hull) else None
