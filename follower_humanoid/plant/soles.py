"""The six-point Kelvin–Voigt soles: Savić et al. 2016, eq. (11), with stick/slip friction.

Per point below ground, with x position, x_a anchor (set at touch-down), all at the step's end:

    f_n = max(0, k·depth − d ż⁺)        f_t = −k (x⁺ − x_a) − d ẋ⁺,  |f_t| ≤ μ f_n

Linearly implicit: with ẋ⁺ = ẋ + h J q̈ the force is f − c J q̈, c = h² k + h d, so that each pressing
(sticking) axis adds Jᵀ c J to the effective mass. A slipping point carries μ f_n along its spring.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant.world import Ground
from follower_humanoid.robot.model import BASE_DOF, RobotModel

PER_FOOT = 6
POINTS = 2 * PER_FOOT
# How far friction may be from the cone (share, and [N]) before a step is solved again.
CONE_SHARE, CONE_FORCE = 0.01, 0.2


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

    def __init__(self, config: SoleConfig, robot: RobotModel, data: Any, ground: Ground, step: float) -> None:
        """Feet in the air.

        Args:
            config: Spring and damper.
            robot: Frames and joint groups.
            data: The plant's Pinocchio data, whose joint poses are followed.
            ground: What they stand on.
            step: Physics step [s].
        """
        self._k, self._d, self._step = config.stiffness, config.damping, step
        self._c = step * step * config.stiffness + step * config.damping
        self._ground = ground
        names = [f"{side.prefix}_contact_{n}" for side in SIDES for n in range(1, PER_FOOT + 1)]
        frames = [robot.pin_model.frames[robot.frame_id(name)] for name in names]
        self.joints = [int(frame.parentJoint) for frame in frames]
        local = np.array([frame.placement.translation for frame in frames])
        self._bodies = []
        for joint in dict.fromkeys(self.joints):
            rows = np.flatnonzero(np.array(self.joints) == joint)
            pose = data.oMi[joint]
            # Views of Pinocchio's memory: they follow the kinematics.
            span = slice(rows[0], rows[-1] + 1)
            self._bodies.append((span, local[rows], pose.rotation.T, pose.translation))
        self._size = self._leg_columns(robot)
        self._carries = self._carried_by(robot)
        self._upper = np.triu(np.ones((self._size, self._size)))
        self._twist_to_points = np.tile(np.hstack((np.eye(3), np.zeros((3, 3)))), (POINTS, 1))
        self._jacobian = np.zeros((3 * POINTS, self._size))
        self._axes = np.zeros((POINTS, 3))
        self._slip_force = np.zeros((POINTS, 2))
        self.points = np.zeros((POINTS, 3))
        self.force = np.zeros((POINTS, 3))
        self.touching = False
        self._below = np.zeros(POINTS, dtype=bool)
        self._anchor = np.zeros((POINTS, 3))

    def _leg_columns(self, robot: RobotModel) -> int:
        """Columns that move the feet: base and legs, which come first in the model."""
        legs = np.concatenate([robot.groups.leg(side) for side in SIDES])
        if not np.array_equal(np.sort(legs), np.arange(len(legs))):
            raise ConfigurationError(f"URDF: the legs must be the first joints of {robot.joint_names}")
        return BASE_DOF + len(legs)

    def _carried_by(self, robot: RobotModel) -> Array:
        """1 where a column moves a point, else 0, shape (36, columns)."""
        carries = np.zeros((POINTS, self._size))
        carries[:, :BASE_DOF] = 1.0
        for point, joint in enumerate(self.joints):
            for support in robot.pin_model.supports[joint]:
                if support > 1:  # 0 is the universe, 1 the free-flyer
                    carries[point, BASE_DOF + support - 2] = 1.0
        return np.repeat(carries, 3, axis=0)

    def _locate(self) -> None:
        for rows, local, turn, place in self._bodies:
            points = self.points[rows]
            np.matmul(local, turn, out=points)
            points += place

    def settle(self, normal: Array) -> None:
        """Static contact without friction force: anchors the points where they are.

        Args:
            normal: Vertical force that each point carries, shape (12,) [N].
        """
        self._locate()
        self._below = self._ground.depth(self.points) > 0.0
        self._anchor[:] = self.points
        self.force = np.column_stack((np.zeros((POINTS, 2)), normal))
        self._turn_points()
        self.touching = bool(self._below.any())

    def begin(self, jacobian: Array, velocity: Array) -> bool:
        """Finds the touching points and their trial forces; True if there are any.

        Args:
            jacobian: World-frame joint Jacobian, shape (6, 51).
            velocity: Shape (51,).
        """
        self._locate()
        depth = self._ground.depth(self.points)
        below = depth > 0.0
        self.touching = bool(np.count_nonzero(below))
        if not self.touching:
            self._below = below
            self.force = np.zeros((POINTS, 3))
            return False
        landed = below & ~self._below
        if np.count_nonzero(landed):
            self._anchor[landed] = self.points[landed]
        self._below = below
        self._turn_points()
        np.matmul(self._twist_to_points, jacobian[:, : self._size], out=self._jacobian)
        self._jacobian *= self._carries
        self._rate = (self._jacobian @ velocity[: self._size]).reshape(POINTS, 3)
        stretch = self.points - self._anchor
        np.negative(depth, out=stretch[:, 2])
        stretch *= self._k
        self._trial = self._rate * -(self._d + self._step * self._k)
        self._trial -= stretch
        normal = self._trial[:, 2]
        self._pressing = below & (normal > 0.0)
        cone = self._ground.friction * normal
        self._sticking = self._pressing & (_squares(self._trial) <= cone * cone)
        self._slip(self._trial, normal)
        return True

    def _turn_points(self) -> None:
        """Map from a twist at the world origin to point velocities, v + ω × p, shape (36, 6)."""
        x, y, z = self.points.T
        turn = self._twist_to_points
        turn[0::3, 4], turn[1::3, 5], turn[2::3, 3] = z, x, y
        np.negative(y, out=turn[0::3, 5])
        np.negative(z, out=turn[1::3, 3])
        np.negative(x, out=turn[2::3, 4])

    def _slip(self, spring: Array, normal: Array) -> None:
        """Friction of slipping points: μ f_n along the spring, shapes (12, 3) and (12,)."""
        self._slipping = self._pressing & ~self._sticking
        self._any_slipping = bool(np.count_nonzero(self._slipping))
        if self._any_slipping:
            spring = spring[self._slipping, :2]
            limit = self._ground.friction * np.maximum(normal[self._slipping], 0.0)
            pull = np.maximum(np.sqrt(_squares(spring)), 1e-12)
            self._slip_force[self._slipping] = spring * (limit / pull)[:, None]

    def add_to(self, matrix: Array, right_side: Array) -> None:
        """Adds the implicit contact to the effective mass (upper triangle) and to the forces."""
        axes, size = self._axes, self._size
        axes[:, 0] = axes[:, 1] = self._sticking
        axes[:, 2] = self._pressing
        self._start = self._trial * axes
        if self._any_slipping:
            self._start[self._slipping, :2] = self._slip_force[self._slipping]
        self._gain = axes * self._c
        block = self._jacobian.T @ (self._jacobian * self._gain.reshape(-1, 1))
        block *= self._upper
        matrix[:size, :size] += block
        right_side[:size] += self._start.reshape(-1) @ self._jacobian

    def finish(self, acceleration: Array) -> bool:
        """Forces of the solution; False if a point left its assumed state: solve again.

        Args:
            acceleration: Solution of the step, shape (51,).
        """
        self._change = (self._jacobian @ acceleration[: self._size]).reshape(POINTS, 3)
        force = self._start - self._gain * self._change
        self.force = force
        normal = force[:, 2]
        cone = self._ground.friction * normal
        pull = np.sqrt(_squares(force))
        margin = CONE_SHARE * cone + CONE_FORCE
        wrong = (normal < 0.0) | (pull > cone + margin)
        if self._any_slipping:
            wrong |= self._slipping & (pull < cone - margin)
        if not np.count_nonzero(wrong):
            return True
        self._reconsider(force)
        return False

    def _reconsider(self, force: Array) -> None:
        """Lets go of pulling points, lets points beyond the cone slip, renews the slip forces."""
        normal = force[:, 2]
        cone = self._ground.friction * normal
        self._pressing = self._pressing & (normal >= 0.0)
        self._sticking = self._sticking & self._pressing & (_squares(force) <= cone * cone)
        self._slip(self._trial - self._c * self._change, normal)

    def commit(self, settled: bool) -> None:
        """Ends the step: the anchors of slipping points follow.

        Args:
            settled: False if solving again did not settle; what violates the cone is then clipped.
        """
        force = self.force
        if not settled:
            np.maximum(force[:, 2], 0.0, out=force[:, 2])
            limit = self._ground.friction * force[:, 2]
            pull = np.sqrt(_squares(force))
            beyond = pull > limit
            force[beyond, :2] *= (limit[beyond] / pull[beyond])[:, None]
        if not self._any_slipping:
            return
        # The anchor goes where the spring carries the friction force.
        end = self.points + self._step * (self._rate + self._step * self._change)
        carried = end + force / self._k
        self._anchor[self._slipping, :2] = carried[self._slipping, :2]

    def wrenches_about_origin(self) -> Array:
        """Force and moment about the world origin, in world, of each foot: shape (2, 6)."""
        wrenches = np.empty((len(SIDES), 6))
        flat, rows = self.force.reshape(-1), 3 * PER_FOOT
        np.matmul(flat[:rows], self._twist_to_points[:rows], out=wrenches[0])
        np.matmul(flat[rows:], self._twist_to_points[rows:], out=wrenches[1])
        return wrenches


def _squares(force: Array) -> Array:
    """Squared horizontal magnitude, shape (n, 2 or 3) → (n,)."""
    x, y = force[:, 0], force[:, 1]
    squares: Array = x * x + y * y
    return squares
