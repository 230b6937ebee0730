"""ZMP balance: corrects the reference motion and says what the ground must do to the feet."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from follower_humanoid.balance.com_offset import ComOffset, OffsetConfig
from follower_humanoid.balance.dcm_law import (
    CenterState,
    DcmConfig,
    attitude_shift,
    desired_force,
    desired_zmp,
    measured_dcm,
    yaw_moment,
)
from follower_humanoid.balance.foot_wrenches import FootShares, SoleConfig, foot_wrench, share_feet
from follower_humanoid.balance.hand_forces import HandEffect, hand_effect
from follower_humanoid.balance.zmp import SolePlace, ZmpConfig, convex_hull, measured_zmp, polygon_margin
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
from follower_humanoid.robot.model import RobotModel

LAWS = ("dcm",)


@dataclass(frozen=True)
class BalanceConfig:
    """Parameters of ZMP balance."""

    law: str = parameter("dcm", "balance law", choices=LAWS)
    zmp: ZmpConfig = field(default_factory=ZmpConfig)
    dcm: DcmConfig = field(default_factory=DcmConfig)
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
    """Corrected reference, desired foot wrenches and what was measured; None before a reference came."""

    reference: Joints | None
    left_foot_reference: Wrench | None
    right_foot_reference: Wrench | None
    zmp: Point | None
    zmp_command: Point | None
    com: Point
    dcm: Point | None
    support_polygon: Polygon | None


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
        self._last_momentum: Array | None = None
        self._smooth_rate: Array = np.zeros(3)
        self._margin: float | None = None
        self._smallest_margin = float("inf")

    def step(self, inputs: BalanceInputs, time: float) -> BalanceOutputs:
        """One tick: measure, correct, distribute."""
        del time
        q, v = self._robot.state(inputs.odometry, inputs.joints)
        state = self._update(q, v)
        places = {side: self._place(side) for side in SIDES}
        zmp = measured_zmp(
            inputs.left_foot, inputs.right_foot, places[Side.LEFT], places[Side.RIGHT],
            self._config.zmp.force_floor,
        )  # fmt: skip
        polygon = self._support_polygon(inputs)
        self._watch(zmp, polygon)
        measured = {
            "zmp": _ground(zmp),
            "com": Point(state.com),
            "support_polygon": None if polygon is None else Polygon(_at_ground(polygon)),
        }
        if (
            inputs.reference is None or inputs.base is None or inputs.contacts is None
            or inputs.zmp_reference is None or inputs.dcm_reference is None
        ):  # fmt: skip
            nothing = dict.fromkeys(("reference", "left_foot_reference", "right_foot_reference", "zmp_command", "dcm"))
            return BalanceOutputs(**measured, **nothing)
        hands = self._hands(inputs)
        shares, force, moment, dcm = self._correct(inputs, state, hands, places, v)
        friction = self._config.soles.friction
        wrenches = {
            side: foot_wrench(shares.share[side], shares.point[side], force, moment, places[side], friction)
            for side in SIDES
        }
        return BalanceOutputs(
            **measured,
            reference=self._offset.step(inputs.reference, inputs.base, hands, self._period),
            left_foot_reference=wrenches[Side.LEFT],
            right_foot_reference=wrenches[Side.RIGHT],
            zmp_command=_ground(shares.zmp),
            dcm=_ground(dcm),
        )

    def diagnostics(self) -> dict[str, float | str]:
        """Distance of the ZMP to the edge of the support polygon, now and at its smallest."""
        if self._margin is None:
            return {"zmp_margin [m]": "no ZMP"}
        return {"zmp_margin [m]": self._margin, "smallest_zmp_margin [m]": self._smallest_margin}

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

    def _correct(
        self, inputs: BalanceInputs, state: CenterState, hands: HandEffect, places: dict[Side, SolePlace], v: Array
    ) -> tuple[FootShares, Array, float, Array]:
        """Desired ZMP from the DCM error, the ground force and yaw moment that make it, and the DCM."""
        if inputs.base is None or inputs.reference is None or inputs.contacts is None:
            raise ValueError("a correction needs a reference")
        if inputs.zmp_reference is None or inputs.dcm_reference is None:
            raise ValueError("a correction needs a plan")
        config, robot = self._config, self._robot
        q_ref, v_ref = robot.state(inputs.base, inputs.reference)
        pin.computeCentroidalMomentum(robot.pin_model, self._wanted, q_ref, v_ref)
        reference = CenterState(np.array(self._wanted.com[0]), np.array(self._wanted.vcom[0]))
        omega = natural_frequency(float(reference.com[2]))
        dcm = measured_dcm(state, hands, omega)
        zmp = desired_zmp(
            dcm, inputs.dcm_reference.xyz[:2], inputs.zmp_reference.xyz[:2], omega, config.dcm.proportional
        )
        zmp = share_feet(zmp, places, inputs.contacts, config.soles).zmp
        rotation, wanted = self._measured.oMi[1].rotation, self._wanted.oMi[1].rotation
        error = pin.log3(wanted @ rotation.T)
        rate = rotation @ v[3:6] - wanted @ v_ref[3:6]
        shift = attitude_shift(error, rate, robot.mass, config.dcm)
        momentum_rate = self._momentum_rate()
        force = desired_force(
            state, float(reference.com[2]), float(reference.velocity[2]), zmp,
            momentum_shift(momentum_rate, robot.mass), hands, omega, robot.mass, config.dcm,
        )  # fmt: skip
        moment = yaw_moment(error, rate, float(momentum_rate[2]), config.dcm)
        return share_feet(zmp + shift, places, inputs.contacts, config.soles), force, moment, dcm

    def _momentum_rate(self) -> Array:
        """L̇ of the reference about its CoM, from one tick to the next, low-passed, shape (3,) [N·m]."""
        momentum, config = np.array(self._wanted.hg.angular), self._config.dcm
        if self._last_momentum is not None:
            rate = (momentum - self._last_momentum) / self._period
            rate = np.clip(rate, -config.momentum_limit, config.momentum_limit)
            share = 1.0 - math.exp(-self._period / config.momentum_filter)
            self._smooth_rate = self._smooth_rate + share * (rate - self._smooth_rate)
        self._last_momentum = momentum
        return self._smooth_rate

    def _support_polygon(self, inputs: BalanceInputs) -> Array | None:
        config = self._config.zmp
        points = []
        for side, wrench in zip(SIDES, (inputs.left_foot, inputs.right_foot), strict=True):
            if wrench.force[2] > config.carrying:
                places = (self._measured.oMf[frame].translation for frame in self._contacts[side])
                points += [place[:2] for place in places if place[2] < config.clearance]
        return convex_hull(np.array(points)) if points else None

    def _watch(self, zmp: Array | None, polygon: Array | None) -> None:
        self._margin = None if zmp is None or polygon is None else polygon_margin(polygon, zmp)
        if self._margin is not None:
            self._smallest_margin = min(self._smallest_margin, self._margin)


def _ground(point: Array | None) -> Point | None:
    """A point of the ground as a sample."""
    return None if point is None else Point(np.array([point[0], point[1], 0.0]))


def _at_ground(polygon: Array) -> Array:
    """Vertices with z = 0, shape (n, 3)."""
    return np.column_stack((polygon, np.zeros(len(polygon))))
