"""The DCM law as a whole: from what is measured and wanted to foot wrenches and a corrected reference."""

from __future__ import annotations

import numpy as np

from follower_humanoid.balance.attitude import Vector, attitude_shift, yaw_moment
from follower_humanoid.balance.balance_config import BalanceConfig
from follower_humanoid.balance.com_offset import ComOffset
from follower_humanoid.balance.correction import Correction, Kinematics, Situation
from follower_humanoid.balance.dcm_law import CenterState, desired_force, desired_zmp, measured_dcm
from follower_humanoid.balance.foot_wrenches import reachable_zmp, share_force
from follower_humanoid.core.samples import Joints
from follower_humanoid.gait.ik_kernels import turn_to
from follower_humanoid.gait.pendulum import momentum_shift, natural_frequency
from follower_humanoid.gait.swing_momentum import MomentumRate
from follower_humanoid.robot.model import BASE_DOF, RobotModel

UPRIGHT = AT_REST = (0.0, 0.0, 0.0)  # no attitude error, no rate


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
            state, wanted, error, rate = reference, now.zmp, UPRIGHT, AT_REST
        zmp = reachable_zmp(wanted, soles, now.contacts, config.soles)
        momentum_rate = self._swing.step(self._wanted.angular_momentum.copy(), self._period)
        turning = momentum_shift(momentum_rate, mass)
        force = desired_force(state, reference, zmp, turning, hands, omega, mass, config.dcm)
        shift = attitude_shift(error, rate, mass, config.attitude)
        moment = yaw_moment(error, rate, float(momentum_rate[2]), config.attitude)
        # Of the wanted ZMP, not of what soles leave of it: at their edge the DCM goes before the attitude.
        feet = share_force(wanted + shift, force, moment, soles, now.contacts, config.soles)
        return Correction(feet.zmp, self._corrected(now), dcm, feet.left, feet.right)

    def _attitude_error(self) -> tuple[Vector, Vector]:
        """Rotation vector from the pelvis to its desired attitude and its rate against that, in world."""
        rate: Vector = (self._body.angular_velocity - self._wanted.angular_velocity).tolist()
        return turn_to(self._upright, self._body.base), rate

    def _corrected(self, now: Situation) -> Joints:
        """The reference against the pull of the hands."""
        if not self._config.offset.enabled:
            position, velocity = now.q_wanted[BASE_DOF + 1 :], now.v_wanted[BASE_DOF:]
            return Joints(position, velocity, np.zeros(len(velocity)))
        return self._offset.step(now.q_wanted, now.v_wanted, now.hands, self._period)
