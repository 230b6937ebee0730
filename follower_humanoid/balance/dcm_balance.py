"""The DCM law as a whole: from what is measured and wanted to foot wrenches and a corrected reference."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np

from follower_humanoid.balance.attitude import attitude_feedback
from follower_humanoid.balance.balance_config import BalanceConfig
from follower_humanoid.balance.com_offset import ComOffset
from follower_humanoid.balance.correction import Correction, Kinematics, Situation
from follower_humanoid.balance.dcm_law import corrected
from follower_humanoid.core.samples import Joints, Point, Wrench
from follower_humanoid.gait.ik_kernels import turn_to
from follower_humanoid.gait.pendulum import momentum_shift, natural_frequency
from follower_humanoid.gait.swing_momentum import MomentumRate
from follower_humanoid.robot.model import BASE_DOF, GRAVITY, RobotModel

NO_TURN = (0.0, 0.0, 0.0)


class DcmBalance:
    """Desired ZMP from the DCM error, then the ground force and the yaw moment that make it."""

    def __init__(self, config: BalanceConfig, robot: RobotModel, where: Kinematics, period: float) -> None:
        self._config = config
        self._mass = robot.mass
        self._period = period
        self._body, (self._left_sole, self._right_sole), self._wanted = where
        self._upright = self._wanted.base[:3].T
        self._spin, self._wanted_spin = self._body.base_twist[1], self._wanted.base_twist[1]
        self._gains, self._usable_sole = astuple(config.dcm), astuple(config.soles)
        self._attitude_gains = astuple(config.attitude)
        self._offset = ComOffset(config.offset, robot, self._wanted)
        self._swing = MomentumRate(config.momentum)

    def correct(self, now: Situation) -> Correction:
        """One tick."""
        config, mass, body, wanted = self._config, self._mass, self._body, self._wanted
        omega = natural_frequency(float(wanted.com[2]))
        momentum_rate = self._swing.step(wanted.angular_momentum.copy(), self._period)
        error, spin = NO_TURN, self._wanted_spin
        if config.feedback:
            error, spin = turn_to(self._upright, body.base), self._spin
        shift, yaw_moment = attitude_feedback(
            error, spin, self._wanted_spin, momentum_rate, mass * GRAVITY, self._attitude_gains
        )
        dcm, zmp, left_force, left_torque, right_force, right_torque = corrected(
            config.feedback, mass, body.com, body.com_velocity, omega, wanted.com, wanted.com_velocity,
            mass * omega**2, now.dcm.xyz, now.zmp.xyz, *now.hands,
            momentum_shift(momentum_rate, mass), shift, yaw_moment, self._left_sole, self._right_sole,
            (now.contacts.left, now.contacts.right), self._gains, self._usable_sole,
        )  # fmt: skip
        left, right = Wrench(left_force, left_torque), Wrench(right_force, right_torque)
        return Correction(Point(zmp), self._against_hands(now), Point(dcm), left, right)

    def _against_hands(self, now: Situation) -> Joints:
        """The reference against the pull of the hands."""
        if not self._config.offset.enabled:
            position, velocity = now.q_wanted[BASE_DOF + 1 :], now.v_wanted[BASE_DOF:]
            return Joints(position, velocity, np.zeros(len(velocity)))
        return self._offset.step(now.q_wanted, now.v_wanted, now.hands, self._period)
