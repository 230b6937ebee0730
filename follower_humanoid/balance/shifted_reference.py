"""The reference with its CoM shifted: other velocities of base and legs, feet and pelvis where they were."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import SIDES, Array, Joints
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig
from follower_humanoid.robot.body_state import BodyState
from follower_humanoid.robot.model import ACTUATED, BASE_DOF, RobotModel

SOLES = [f"{side.prefix}_sole" for side in SIDES]


class ShiftedReference:
    """Turns a shift of the CoM into joint references, tick by tick."""

    def __init__(self, config: IkConfig, robot: RobotModel, wanted: BodyState) -> None:
        """Args: parameters of the IK, the robot, kinematics of the reference with the twists of `SOLES`."""
        self._config = config
        self._robot = robot
        # Soles and pelvis go where the reference has them: views that follow it.
        places = [wanted.frames[robot.frame_id(name)] for name in SOLES]
        self._feet = {
            side: FootTask(place[3], place[:3].T, twist[0], twist[1])
            for side, place, twist in zip(SIDES, places, wanted.twists, strict=True)
        }
        self._base_velocity, self._base_spin = wanted.base_twist
        self._com, self._com_velocity = wanted.com[:2], wanted.com_velocity[:2]
        self._rotation = wanted.base[:3].T
        self._no_effort: Array = np.zeros(ACTUATED)
        self._ik: DifferentialIk | None = None

    def step(self, q: Array, v: Array, offset: Array, rate: Array, dt: float) -> Joints:
        """One tick.

        Args:
            q, v: Configuration, shape (52,), and velocity, shape (51,), of which `wanted` has the kinematics.
            offset: Shift of the CoM over the ground, shape (2,) [m].
            rate: Its velocity, shape (2,) [m/s].
            dt: Tick [s].

        Returns:
            The corrected joint reference.
        """
        if self._ik is None:
            self._ik = DifferentialIk(self._robot, self._config, q)
        ik = self._ik
        body = BodyTask(
            com=self._com + offset, com_velocity=self._com_velocity + rate,
            pelvis_height=float(q[2]), pelvis_height_velocity=float(self._base_velocity[2]),
            pelvis_rotation=self._rotation, pelvis_angular_velocity=self._base_spin,
        )  # fmt: skip
        # Joints outside the IK follow the reference as it is.
        given = np.empty(ACTUATED)
        _lead(q, v, ik.q, self._config.foot_gain, given)
        ik.advance(self._feet, body, given, dt)
        return Joints(ik.q[BASE_DOF + 1 :], ik.v[BASE_DOF:], self._no_effort)


@kernel("void(float64[::1], float64[::1], float64[::1], float64, float64[::1])")
def _lead(q: Array, v: Array, q_now: Array, gain: float, given: Array) -> None:
    """Writes velocities that lead the joints to a reference: q̇_d + k (q_d − q).

    Args:
        q, v: Reference configuration, shape (52,), and velocity, shape (51,).
        q_now: Present configuration, shape (52,).
        gain: k [1/s].
        given: Written, shape (45,) [rad/s].
    """
    for joint in range(given.size):
        error = q[BASE_DOF + 1 + joint] - q_now[BASE_DOF + 1 + joint]
        given[joint] = v[BASE_DOF + joint] + gain * error
