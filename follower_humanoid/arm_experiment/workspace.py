"""Whether an arm can go where it shall, found out before anything moves.

The path is travelled by kinematics alone, as the controller would: eq. (6) with the joint limits of
eq. (7) in the null space. A point is out of reach where the joints cannot follow or the arm comes
close to a singularity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from follower_humanoid.arm_experiment.target_points import TargetPoint
from follower_humanoid.control.hand_task import HandKinematics
from follower_humanoid.control.null_space import joint_velocity, limit_avoidance, task_inverse
from follower_humanoid.core.samples import Array, Side
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.robot.model import RobotModel

_STRIDE = 0.01  # between two postures looked at [m]
_CLOSE = 0.002  # how exactly a posture must reach its place [m]
_STRAIGHT = 0.05  # smallest singular value of an arm that is still far enough from straight [m/rad]
_AVOIDANCE = 1.0  # k_0 per stride [rad²]
_LARGEST_TURN = 0.2  # of a joint per correction [rad]


class Reach:
    """The left arm's postures, and where they put the hand."""

    def __init__(self, robot: RobotModel, position: Array) -> None:
        """`position`: of the 45 joints at the beginning, shape (45,) [rad]."""
        self._position = position.copy()
        self._arm = robot.groups.arm(Side.LEFT)
        self._lower, self._upper = robot.lower[self._arm], robot.upper[self._arm]
        self._kinematics = HandKinematics(robot)
        self._still = np.zeros(robot.pin_model.nv)
        self._base = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])

    def place(self) -> Array:
        """Of the hand, in base_link, shape (3,) [m]."""
        return self._look()[0]

    def can_go(self, goal: Array) -> bool:
        """Goes there in a straight line; False where it cannot."""
        begin = self.place()
        strides = max(1, math.ceil(float(np.linalg.norm(goal - begin)) / _STRIDE))
        return all(self._reach(begin + (goal - begin) * n / strides) for n in range(1, strides + 1))

    def _look(self) -> tuple[Array, Array]:
        """Place of the hand, shape (3,), and its Jacobian as a stack of one, shape (1, 3, 7)."""
        motion = self._kinematics.motion(np.concatenate((self._base, self._position)), self._still)
        return motion.place[0], motion.jacobian[:1]

    def _reach(self, goal: Array) -> bool:
        for _ in range(10):
            place, jacobian = self._look()
            if float(np.linalg.svd(jacobian[0], compute_uv=False)[-1]) < _STRAIGHT:
                return False
            joints = self._position[self._arm]
            aside = limit_avoidance(joints, self._lower, self._upper, _AVOIDANCE)
            inverse = task_inverse(jacobian, 1e-3, 1e-3)
            turn = joint_velocity(inverse, (goal - place)[None], aside[None])[0]
            if float(np.linalg.norm(goal - place)) < _CLOSE:
                return bool(((joints > self._lower) & (joints < self._upper)).all())
            self._position[self._arm] = joints + np.clip(turn, -_LARGEST_TURN, _LARGEST_TURN)
        return False


def check_reach(
    robot: RobotModel, position: Array, points: Sequence[TargetPoint], names: Sequence[str]
) -> None:
    """Refuses a path that leaves the workspace.

    Args:
        robot: The model.
        position: Of the 45 joints at the beginning, shape (45,) [rad].
        points: Where the hand shall go, one after the other.
        names: What each point is called in a message.

    Raises:
        ConfigurationError: A point is out of reach.
    """
    reach = Reach(robot, position)
    for point, name in zip(points, names, strict=True):
        if not reach.can_go(point.place):
            begin = Reach(robot, position).place()
            raise ConfigurationError(
                f"{name} at {_text(point.place)} m in base_link: out of reach of the left arm; valid: where "
                f"it neither straightens nor meets a joint stop on its way from {_text(begin)} m"
            )


def _text(place: Array) -> str:
    return f"({', '.join(f'{value:.3f}' for value in place)})"
