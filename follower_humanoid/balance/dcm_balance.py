"""The DCM law as a whole: from what is measured and wanted to foot wrenches and a corrected reference."""

from __future__ import annotations

import numpy as np

from follower_humanoid.balance.attitude import attitude_shift, yaw_moment
from follower_humanoid.balance.balance_config import BalanceConfig
from follower_humanoid.balance.com_offset import ComOffset
from follower_humanoid.balance.correction import Correction, Kinematics, Situation
from follower_humanoid.balance.dcm_law import CenterState, desired_force, desired_zmp, measured_dcm
from follower_humanoid.balance.foot_wrenches import foot_wrench, share_feet
from follower_humanoid.core.samples import Array, Joints, Side
from follower_humanoid.gait.ik_kernels import turn_to
from follower_humanoid.gait.pendulum import momentum_shift, natural_frequency
from follower_humanoid.gait.swing_momentum import MomentumRate
from follower_humanoid.robot.model import BASE_DOF, RobotModel


class DcmBalance:
    """Desired ZMP from the DCM error, then the ground force and the yaw moment that make it."""

    def __init__(self, config: BalanceConfig, robot: RobotModel, where: Kinematics, period: float) -> None:
        self._config = config
        self._mass = robot.mass
        self._period = period
        self._body, self._soles, self._wanted = where
        self._measured = CenterState(where.body.com, where.body.com_velocity)
        self._reference = CenterState(where.wanted.com, where.wanted.com_velocity)
        self._upright = where.wanted.base[:3].T
        self._offset = ComOffset(config.offset, robot, where.wanted)
        self._swing = MomentumRate(config.momentum)

    def correct(self, now: Situation) -> Correction:
        """One tick."""
        config, mass, hands, soles = self._config, self._mass, now.hands, self._soles
        measured, reference = self._measured, self._reference
        omega = natural_frequency(float(reference.com[2]))
        dcm = measured_dcm(measured, hands, omega)
        if config.feedback:
            state = measured
            wanted = desired_zmp(dcm, now.dcm, now.zmp, omega, config.dcm.proportional)
            error, rate = self._attitude_error()
        else:
            state, wanted, error, rate = reference, now.zmp, np.zeros(3), np.zeros(3)
        zmp = share_feet(wanted, soles, now.contacts, config.soles).zmp
        momentum_rate = self._swing.step(self._wanted.angular_momentum.copy(), self._period)
        turning = momentum_shift(momentum_rate, mass)
        force = desired_force(state, reference, zmp, turning, hands, omega, mass, config.dcm)
        shift = attitude_shift(error, rate, mass, config.attitude)
        moment = yaw_moment(error, rate, float(momentum_rate[2]), config.attitude)
        # Of the wanted ZMP, not of what soles leave of it: at their edge the DCM goes before the attitude.
        shares = share_feet(wanted + shift, soles, now.contacts, config.soles)
        left, right = (
            foot_wrench(
                shares.share[side], shares.point[side], force, moment, soles[side], config.soles.friction
            )
            for side in (Side.LEFT, Side.RIGHT)
        )
        return Correction(shares.zmp, self._corrected(now), dcm, left, right)

    def _attitude_error(self) -> tuple[Array, Array]:
        """Rotation vector from the pelvis to its desired attitude and its rate against that, in world."""
        error = np.array(turn_to(self._upright, self._body.base))
        return error, self._body.angular_velocity - self._wanted.angular_velocity

    def _corrected(self, now: Situation) -> Joints:
        """The reference against the pull of the hands."""
        if not self._config.offset.enabled:
            position, velocity = now.q_wanted[BASE_DOF + 1 :], now.v_wanted[BASE_DOF:]
            return Joints(position, velocity, np.zeros(len(velocity)))
        return self._offset.step(now.q_wanted, now.v_wanted, now.hands, self._period)
