"""The DCM law as a whole: from what is measured and wanted to foot wrenches and a corrected reference."""

from __future__ import annotations

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
        self._body, (left, right), self._wanted = where
        self._upright = self._wanted.base[:3].T
        self._spin, self._wanted_spin = self._body.base_twist[1], self._wanted.base_twist[1]
        self._offset = ComOffset(config.offset, robot, self._wanted)
        self._swing = MomentumRate(config.momentum)
        # What stays the same from tick to tick, in the order of `attitude_feedback` and `corrected`.
        self._centers = (
            self._body.com, self._body.com_velocity, self._wanted.com, self._wanted.com_velocity
        )  # fmt: skip
        self._soles = (left.position, left.rotation, right.position, right.rotation)
        dcm, soles, attitude = config.dcm, config.soles, config.attitude
        self._gains = (
            robot.mass, dcm.proportional, dcm.height_stiffness, dcm.height_damping,
            soles.center, soles.back, soles.front, soles.side, soles.friction,
        )  # fmt: skip
        self._attitude_gains = (
            attitude.stiffness, attitude.damping, attitude.inertia, attitude.zmp_limit, attitude.yaw_limit
        )  # fmt: skip

    def correct(self, now: Situation) -> Correction:
        """One tick."""
        config, mass, hands, plan = self._config, self._mass, now.hands, now.contacts
        omega = natural_frequency(float(self._wanted.com[2]))
        momentum_rate = self._swing.step(self._wanted.angular_momentum.copy(), self._period)
        error, spin = NO_TURN, self._wanted_spin
        if config.feedback:
            error, spin = turn_to(self._upright, self._body.base), self._spin
        shift, yaw_moment = attitude_feedback(
            error, spin, self._wanted_spin, momentum_rate, mass * GRAVITY, *self._attitude_gains
        )
        dcm, zmp, left_force, left_torque, right_force, right_torque = corrected(
            config.feedback, *self._centers,
            now.dcm.xyz, now.zmp.xyz, hands.gamma, hands.force, hands.kappa,
            momentum_shift(momentum_rate, mass), shift, yaw_moment,
            *self._soles, plan.left, plan.right, omega, mass * omega**2, *self._gains,
        )  # fmt: skip
        left, right = Wrench(left_force, left_torque), Wrench(right_force, right_torque)
        return Correction(Point(zmp), self._against_hands(now), Point(dcm), left, right)

    def _against_hands(self, now: Situation) -> Joints:
        """The reference against the pull of the hands."""
        if not self._config.offset.enabled:
            position, velocity = now.q_wanted[BASE_DOF + 1 :], now.v_wanted[BASE_DOF:]
            return Joints(position, velocity, np.zeros(len(velocity)))
        return self._offset.step(now.q_wanted, now.v_wanted, now.hands, self._period)
