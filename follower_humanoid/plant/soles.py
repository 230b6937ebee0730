"""The six-point Kelvin–Voigt soles: Savić et al. 2016, eq. (11), with stick/slip friction.

Per point below ground, with x position, x_a anchor (set at touch-down), all at the step's end:

    f_n = max(0, k·depth − d ż⁺)        f_t = −k (x⁺ − x_a) − d ẋ⁺,  |f_t| ≤ μ f_n

Linearly implicit: with ẋ⁺ = ẋ + h J q̈ the force is f − c J q̈, c = h² k + h d, so that each pressing
(sticking) axis adds Jᵀ c J to the effective mass. A slipping point carries μ f_n along its spring.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant import sole_forces
from follower_humanoid.plant.world import Ground
from follower_humanoid.robot.model import BASE_DOF, RobotModel

PER_FOOT = 6
POINTS = 2 * PER_FOOT


@dataclass(frozen=True)
class SoleConfig:
    """Spring and damper of one contact point, the same along all axes."""

    stiffness: float = parameter(1.0e5, "stiffness of one contact point", "N/m", 1e3, 1e6)
    damping: float = parameter(1.0e3, "damping of one contact point", "N·s/m", 0.0, 1e5)


class Soles:
    """The contact points of both feet, left then right: four on each foot, two on its toe link.

    Attributes:
        points: Contact points in world, shape (12, 3) [m].
        force: Ground on foot at each point in the last step, in world, shape (12, 3) [N].
        touching: True while any point is below ground.
        joints: Pinocchio joint that carries each point, 12 ids.
    """

    def __init__(
        self, config: SoleConfig, robot: RobotModel, poses: Array, ground: Ground, step: float
    ) -> None:
        """Feet in the air.

        Args:
            config: Spring and damper.
            robot: Frames and joint groups.
            poses: Joint poses of the plant, as a `robot.pose_table` that follows them.
            ground: What they stand on.
            step: Physics step [s].
        """
        self._k, self._step = config.stiffness, step
        self._loss = config.damping + step * config.stiffness
        self._c = step * step * config.stiffness + step * config.damping
        self._friction = ground.friction
        names = [f"{side.prefix}_contact_{n}" for side in SIDES for n in range(1, PER_FOOT + 1)]
        frames = [robot.pin_model.frames[robot.frame_id(name)] for name in names]
        self.joints = [int(frame.parentJoint) for frame in frames]
        self._carriers = np.array(self.joints)
        self._local = np.array([frame.placement.translation for frame in frames])
        self._poses = poses
        self.points = np.zeros((POINTS, 3))
        self._carries = self._carried_by(robot)
        columns = self._carries.shape[1]
        self.force = np.zeros((POINTS, 3))
        self.touching = False
        self._below = np.zeros(POINTS, dtype=bool)
        self._anchor = np.zeros((POINTS, 3))
        # As `sole_forces` names them, renewed in every step.
        self._jacobian = np.zeros((POINTS, 3, columns))
        self._rate, self._trial, self._start, self._gain, self._change = np.zeros((5, POINTS, 3))
        self._slip = np.zeros((POINTS, 2))
        self._pressing, self._sticking = np.zeros((2, POINTS), dtype=bool)

    def _leg_columns(self, robot: RobotModel) -> int:
        """Columns that move the feet: base and legs, which come first in the model."""
        legs = np.concatenate([robot.groups.leg(side) for side in SIDES])
        if not np.array_equal(np.sort(legs), np.arange(len(legs))):
            raise ConfigurationError(f"URDF: the legs must be the first joints of {robot.joint_names}")
        return BASE_DOF + len(legs)

    def _carried_by(self, robot: RobotModel) -> sole_forces.Flags:
        """True where a column moves a point, shape (12, columns)."""
        carries = np.zeros((POINTS, self._leg_columns(robot)), dtype=bool)
        carries[:, :BASE_DOF] = True
        for point, joint in enumerate(self.joints):
            for support in robot.pin_model.supports[joint]:
                if support > 1:  # 0 is the universe, 1 the free-flyer
                    carries[point, BASE_DOF + support - 2] = True
        return carries

    def settle(self, normal: Array) -> None:
        """Static contact without friction force: anchors the points where they are.

        Args:
            normal: Vertical force that each point carries, shape (12,) [N].
        """
        sole_forces.place(self._poses, self._carriers, self._local, self.points)
        self._below[:] = self.points[:, 2] < sole_forces.GROUND
        self._anchor[:] = self.points
        self.force.fill(0.0)
        self.force[:, 2] = normal
        self.touching = bool(self._below.any())

    def begin(self, jacobian: Array, velocity: Array) -> bool:
        """Finds the touching points and their trial forces; True if there are any.

        Args:
            jacobian: World-frame joint Jacobian, shape (6, 51).
            velocity: Shape (51,).
        """
        self.touching = sole_forces.begin(
            self._poses, self._carriers, self._local, jacobian, self._carries, velocity,
            self._k, self._loss, self._friction, self.points, self._below,
            self._anchor, self._jacobian, self._rate, self._trial, self._slip, self._pressing, self._sticking,
        )  # fmt: skip
        if not self.touching:
            self.force.fill(0.0)
        return self.touching

    def add_to(self, matrix: Array, right_side: Array) -> None:
        """Adds the implicit contact to the effective mass (upper triangle) and to the forces."""
        sole_forces.add_to(
            self._jacobian, self._trial, self._slip, self._pressing, self._sticking, self._c,
            self._start, self._gain, matrix, right_side,
        )  # fmt: skip

    def finish(self, acceleration: Array) -> bool:
        """Forces of the solution; False if a point left its assumed state: solve again.

        Args:
            acceleration: Solution of the step, shape (51,).
        """
        return sole_forces.finish(
            self._jacobian, acceleration, self._trial, self._start, self._gain, self._friction,
            self._c, self._change, self.force, self._slip, self._pressing, self._sticking,
        )  # fmt: skip

    def commit(self, settled: bool) -> None:
        """Ends the step: the anchors of slipping points follow.

        Args:
            settled: False if solving again did not settle; what violates the cone is then clipped.
        """
        if not settled:
            sole_forces.clip(self._friction, self.force)
        sole_forces.follow(
            self.points, self._rate, self._change, self.force, self._pressing, self._sticking,
            self._step, self._k, self._anchor,
        )  # fmt: skip

    def add_wrenches_to(self, feet: Array) -> None:
        """Adds force and moment about the world origin, in world, of each foot, shape (2, 6)."""
        sole_forces.add_wrenches(self.points, self.force, feet)
