"""The DCM law as a whole: from what is measured and wanted to foot wrenches and a corrected reference."""

from __future__ import annotations

import numpy as np

from follower_humanoid.balance.attitude import attitude_shift, yaw_moment
from follower_humanoid.balance.balance_config import BalanceConfig
from follower_humanoid.balance.com_offset import ComOffset
from follower_humanoid.balance.correction import Correction, Situation
from follower_humanoid.balance.dcm_law import CenterState, desired_force, desired_zmp, measured_dcm
from follower_humanoid.balance.foot_wrenches import foot_wrench, share_feet
from follower_humanoid.core.samples import Array, Joints, Side
from follower_humanoid.gait.ik_kernels import turn_to
from follower_humanoid.gait.pendulum import momentum_shift, natural_frequency
from follower_humanoid.gait.swing_momentum import MomentumRate
from follower_humanoid.robot.model import BASE_DOF, RobotModel


class DcmBalance:
    """Desired ZMP from the DCM error, then the ground force and the yaw moment that make it."""

    def __init__(self, config: BalanceConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._mass = robot.mass
        self._period = period
        self._offset = ComOffset(config.offset, robot)
        self._swing = MomentumRate(config.momentum)

    def correct(self, now: Situation) -> Correction:
        """One tick."""
        config, mass, hands = self._config, self._mass, now.hands
        measured = CenterState(now.body.com, now.body.com_velocity)
        reference = CenterState(now.wanted.com, now.wanted.com_velocity)
        state = measured if config.feedback else reference
        omega = natural_frequency(float(reference.com[2]))
        dcm = measured_dcm(measured, hands, omega)
        wanted = now.zmp
        if config.feedback:
            wanted = desired_zmp(dcm, now.dcm, now.zmp, omega, config.dcm.proportional)
        zmp = share_feet(wanted, now.soles, now.contacts, config.soles).zmp
        momentum_rate = self._swing.step(now.wanted.angular_momentum.copy(), self._period)
        turning = momentum_shift(momentum_rate, mass)
        force = desired_force(state, reference, zmp, turning, hands, omega, mass, config.dcm)
        error, rate = _attitude_error(now) if config.feedback else (np.zeros(3), np.zeros(3))
        shift = attitude_shift(error, rate, mass, config.attitude)
        moment = yaw_moment(error, rate, float(momentum_rate[2]), config.attitude)
        # Of the wanted ZMP, not of what soles leave of it: at their edge the DCM goes before the attitude.
        shares = share_feet(wanted + shift, now.soles, now.contacts, config.soles)
        left, right = (
            foot_wrench(
                shares.share[side], shares.point[side], force, moment, now.soles[side], config.soles.friction
            )
            for side in (Side.LEFT, Side.RIGHT)
        )
        return Correction(shares.zmp, self._reference(now), dcm, left, right)

    def _reference(self, now: Situation) -> Joints:
        if not self._config.offset.enabled:
            position, velocity = now.q_wanted[BASE_DOF + 1 :], now.v_wanted[BASE_DOF:]
            return Joints(position, velocity, np.zeros(len(velocity)))
        return self._offset.step(now.q_wanted, now.v_wanted, now.wanted, now.hands, self._period)


def _attitude_error(now: Situation) -> tuple[Array, Array]:
    """Rotation vector from the pelvis to its desired attitude and its rate against that, in world."""
    rotation, upright = now.body.base[:3].T, now.wanted.base[:3].T
    error = np.array(turn_to(upright, now.body.base))
    return error, rotation @ now.v[3:BASE_DOF] - upright @ now.v_wanted[3:BASE_DOF]
