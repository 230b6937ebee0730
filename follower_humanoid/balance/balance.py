"""ZMP balance: corrects the reference motion and says what the ground must do to the feet."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from follower_humanoid.balance.attitude import AttitudeConfig, attitude_shift, yaw_moment
from follower_humanoid.balance.com_offset import ComOffset, OffsetConfig
from follower_humanoid.balance.dcm_law import CenterState, DcmConfig, desired_force, desired_zmp, measured_dcm
from follower_humanoid.balance.foot_wrenches import FootShares, SoleConfig, foot_wrench, share_feet
from follower_humanoid.balance.hand_forces import HandEffect, hand_effect
from follower_humanoid.balance.zmp import SolePlace, ZmpConfig, convex_hull, measured_zmp
from follower_humanoid.balance.zmp_watch import ZmpWatch
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import (
    SIDES,
    Array,
    ContactPlan,
    Joints,
    Odometry,
    Point,
    Polygon,
    Side,
    Wrench,
)
from follower_humanoid.gait.pendulum import momentum_shift, natural_frequency
from follower_humanoid.gait.swing_momentum import MomentumConfig, MomentumRate
from follower_humanoid.robot.model import RobotModel

LAWS = ("dcm",)


@dataclass(frozen=True)
class BalanceConfig:
    """Parameters of ZMP balance."""

    law: str = parameter("dcm", "balance law", choices=LAWS)
    zmp: ZmpConfig = field(default_factory=ZmpConfig)
    dcm: DcmConfig = field(default_factory=DcmConfig)
    attitude: AttitudeConfig = field(default_factory=AttitudeConfig)
    momentum: MomentumConfig = field(default_factory=MomentumConfig)
    soles: SoleConfig = field(default_factory=SoleConfig)
    offset: OffsetConfig = field(default_factory=OffsetConfig)


@dataclass(frozen=True, slots=True)
class BalanceInputs:
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


@dataclass(frozen=True, slots=True)
class BalanceOutputs:
    """What was measured, and once a reference came: its correction and the desired foot wrenches."""

    com: Point
    zmp: Point | None
    support_polygon: Polygon | None
    dcm: Point | None = None
    zmp_command: Point | None = None
    reference: Joints | None = None
    left_foot_reference: Wrench | None = None
    right_foot_reference: Wrench | None = None


@dataclass(frozen=True, slots=True)
class Wanted:
    """The reference of a tick, complete.

    Attributes:
        joints, base: Reference motion.
        zmp, dcm: Plan in world, shape (2,) [m].
        contacts: Planned shares of the weight.
    """

    joints: Joints
    base: Odometry
    zmp: Array
    dcm: Array
    contacts: ContactPlan

    @classmethod
    def of(cls, inputs: BalanceInputs) -> Wanted | None:
        """The reference in the inputs, None before it is complete."""
        joints, base, contacts = inputs.reference, inputs.base, inputs.contacts
        zmp, dcm = inputs.zmp_reference, inputs.dcm_reference
        if joints is None or base is None or contacts is None or zmp is None or dcm is None:
            return None
        return cls(joints, base, zmp.xyz[:2], dcm.xyz[:2], contacts)


@dataclass(frozen=True, slots=True)
class GroundWish:
    """What the ground should do.

    Attributes:
        dcm: Measured, shape (2,) [m].
        shares: Feet's shares and points.
        force: Total force in world, shape (3,) [N].
        yaw_moment: About the vertical [N·m].
    """

    dcm: Array
    shares: FootShares
    force: Array
    yaw_moment: float


class ZmpBalance:
    """Keeps the ZMP inside the support polygon by the DCM law."""

    Config = BalanceConfig
    Inputs = BalanceInputs
    Outputs = BalanceOutputs

    def __init__(self, config: BalanceConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._period = period
        self._measured = robot.pin_model.createData()
        self._wanted = robot.pin_model.createData()
        self._soles = {side: robot.frame_id(f"{side.prefix}_sole") for side in SIDES}
        self._grippers = {side: robot.frame_id(f"{side.prefix}_gripper") for side in SIDES}
        self._contacts = {
            side: [robot.frame_id(f"{side.prefix}_contact_{i}") for i in range(1, 7)] for side in SIDES
        }
        self._offset = ComOffset(config.offset, robot)
        self._swing = MomentumRate(config.momentum)
        self._watch = ZmpWatch()

    def step(self, inputs: BalanceInputs, time: float) -> BalanceOutputs:
        """One tick: measure, correct, distribute."""
        del time
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        state = self._update(q, v)
        places = {side: self._place(side) for side in SIDES}
        floor = self._config.zmp.force_floor
        left, right = places[Side.LEFT], places[Side.RIGHT]
        zmp = measured_zmp(inputs.left_foot, inputs.right_foot, left, right, floor)
        polygon = self._support_polygon(inputs)
        self._watch.see(zmp, polygon, self._measured.oMi[1].rotation[:2, 0])
        seen = BalanceOutputs(
            com=Point(state.com),
            zmp=_ground(zmp),
            support_polygon=None if polygon is None else Polygon(_at_ground(polygon)),
        )
        wanted = Wanted.of(inputs)
        if wanted is None:
            return seen
        hands = self._hands(inputs)
        wish = self._wish(wanted, state, hands, places, v)
        left_wrench, right_wrench = (
            foot_wrench(
                wish.shares.share[side], wish.shares.point[side], wish.force, wish.yaw_moment,
                places[side], self._config.soles.friction,
            )
            for side in SIDES
        )  # fmt: skip
        self._watch.command(wish.shares.zmp)
        return replace(
            seen,
            dcm=_ground(wish.dcm),
            zmp_command=_ground(wish.shares.zmp),
            reference=self._offset.step(wanted.joints, wanted.base, hands, self._period),
            left_foot_reference=left_wrench,
            right_foot_reference=right_wrench,
        )

    def diagnostics(self) -> dict[str, float | str]:
        """How the ZMP keeps to its command and to the support polygon."""
        return self._watch.diagnostics()

    def _update(self, q: Array, v: Array) -> CenterState:
        model, data = self._robot.pin_model, self._measured
        pin.centerOfMass(model, data, q, v, False)
        pin.updateFramePlacements(model, data)
        return CenterState(np.array(data.com[0]), np.array(data.vcom[0]))

    def _place(self, side: Side) -> SolePlace:
        sole = self._measured.oMf[self._soles[side]]
        return SolePlace(np.array(sole.translation), np.array(sole.rotation))

    def _hands(self, inputs: BalanceInputs) -> HandEffect:
        wrenches = [
            (wrench, np.array(self._measured.oMf[self._grippers[side]].translation))
            for side, wrench in zip(SIDES, (inputs.left_hand, inputs.right_hand), strict=True)
            if wrench is not None
        ]
        return hand_effect(wrenches, self._robot.mass)

    def _wish(
        self, wanted: Wanted, state: CenterState, hands: HandEffect, places: dict[Side, SolePlace], v: Array
    ) -> GroundWish:
        """Desired ZMP from the DCM error, then the ground force and the yaw moment that make it."""
        config, robot = self._config, self._robot
        q_ref, v_ref = robot.state(wanted.base, wanted.joints)
        momentum = np.array(
            pin.computeCentroidalMomentum(robot.pin_model, self._wanted, q_ref, v_ref).angular
        )
        reference = CenterState(np.array(self._wanted.com[0]), np.array(self._wanted.vcom[0]))
        omega = natural_frequency(float(reference.com[2]))
        dcm = measured_dcm(state, hands, omega)
        zmp = desired_zmp(dcm, wanted.dcm, wanted.zmp, omega, config.dcm.proportional)
        zmp = share_feet(zmp, places, wanted.contacts, config.soles).zmp
        momentum_rate = self._swing.step(momentum, self._period)
        force = desired_force(
            state,
            reference,
            zmp,
            momentum_shift(momentum_rate, robot.mass),
            hands,
            omega,
            robot.mass,
            config.dcm,
        )
        rotation, upright = self._measured.oMi[1].rotation, self._wanted.oMi[1].rotation
        error = pin.log3(upright @ rotation.T)
        rate = rotation @ v[3:6] - upright @ v_ref[3:6]
        shift = attitude_shift(error, rate, robot.mass, config.attitude)
        moment = yaw_moment(error, rate, float(momentum_rate[2]), config.attitude)
        return GroundWish(dcm, share_feet(zmp + shift, places, wanted.contacts, config.soles), force, moment)

    def _support_polygon(self, inputs: BalanceInputs) -> Array | None:
        config = self._config.zmp
        points = []
        for side, wrench in zip(SIDES, (inputs.left_foot, inputs.right_foot), strict=True):
            if wrench.force[2] > config.carrying:
                places = (self._measured.oMf[frame].translation for frame in self._contacts[side])
                points += [place[:2] for place in places if place[2] < config.clearance]
        return convex_hull(np.array(points)) if points else None


def _ground(point: Array | None) -> Point | None:
    """A point of the ground as a sample."""
    return None if point is None else Point(np.array([point[0], point[1], 0.0]))


def _at_ground(polygon: Array) -> Array:
    """Vertices with z = 0, shape (n, 3)."""
    return np.column_stack((polygon, np.zeros(len(polygon))))
