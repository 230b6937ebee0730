"""The six-point Kelvin–Voigt sole: Savić et al. 2016, eq. (11), with stick/slip friction.

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
from follower_humanoid.core.samples import Array, Side
from follower_humanoid.plant.world import Ground
from follower_humanoid.robot.model import BASE_DOF, RobotModel

POINTS = 6


@dataclass(frozen=True)
class SoleConfig:
    """Spring and damper of one contact point, the same along all axes."""

    stiffness: float = parameter(1.0e5, "stiffness of one contact point", "N/m", 1e3, 1e6)
    damping: float = parameter(1.0e3, "damping of one contact point", "N·s/m", 0.0, 1e5)


class Sole:
    """The contact points of one foot: four on the foot, two on the toe link.

    Attributes:
        points: Contact points in world, shape (6, 3) [m].
        force: Ground on foot at each point in the last step, in world, shape (6, 3) [N].
        touching: True while any point is below ground.
        joints: Pinocchio joint that carries each point, shape (6,).
    """

    def __init__(self, config: SoleConfig, robot: RobotModel, side: Side, ground: Ground, step: float) -> None:
        """A foot in the air; `step` is the physics step [s]."""
        self._k, self._d, self._step = config.stiffness, config.damping, step
        self._c = step * step * config.stiffness + step * config.damping
        self._ground = ground
        frames = [robot.pin_model.frames[robot.frame_id(f"{side.prefix}_contact_{n}")] for n in range(1, 7)]
        self.joints = np.array([frame.parentJoint for frame in frames])
        local = np.array([frame.placement.translation for frame in frames])
        self._bodies = [
            (int(joint), np.flatnonzero(self.joints == joint), local[self.joints == joint])
            for joint in dict.fromkeys(self.joints)
        ]
        leg = robot.groups.leg(side)
        # A leg is a chain without branches: its columns lie side by side.
        self._leg = slice(BASE_DOF + int(leg[0]), BASE_DOF + int(leg[-1]) + 1)
        size = BASE_DOF + len(leg)
        supports = [set(robot.pin_model.supports[int(joint)]) for joint in self.joints]
        self._carries = np.ones((3 * POINTS, size))
        for column, joint in enumerate(leg):
            for point, support in enumerate(supports):
                if int(joint) + 2 not in support:
                    self._carries[3 * point : 3 * point + 3, BASE_DOF + column] = 0.0
        self._upper = np.triu(np.ones((size, size)))
        self._columns = np.zeros((6, size))
        self._velocity = np.zeros(size)
        self._twist_to_points = np.tile(np.hstack((np.eye(3), np.zeros((3, 3)))), (POINTS, 1))
        self.points = np.zeros((POINTS, 3))
        self.force = np.zeros((POINTS, 3))
        self.touching = False
        self._below = np.zeros(POINTS, dtype=bool)
        self._anchor = np.zeros((POINTS, 3))

    def locate(self, data: Any) -> Array:
        """Moves the points to the poses in Pinocchio's `data`; returns them, shape (6, 3) [m]."""
        for joint, rows, local in self._bodies:
            pose = data.oMi[joint]
            self.points[rows] = local @ pose.rotation.T + pose.translation
        return self.points

    def settle(self, data: Any, normal: Array) -> None:
        """Static contact without friction force: anchors the points where they are.

        Args:
            data: Pinocchio data at the current configuration.
            normal: Vertical force that each point carries, shape (6,) [N].
        """
        self.locate(data)
        self._below = self._ground.depth(self.points) > 0.0
        self._anchor[:] = self.points
        self.force = np.column_stack((np.zeros((POINTS, 2)), normal))
        self.touching = bool(self._below.any())

    def begin(self, data: Any, jacobian: Array, velocity: Array) -> bool:
        """Finds the touching points and their trial forces; True if there are any.

        Args:
            data: Pinocchio data at the current configuration.
            jacobian: World-frame joint Jacobian, shape (6, 51).
            velocity: Shape (51,).
        """
        depth = self._ground.depth(self.locate(data))
        below = depth > 0.0
        self.touching = bool(below.any())
        if not self.touching:
            self._below[:] = False
            self.force.fill(0.0)
            return False
        landed = below & ~self._below
        if landed.any():
            self._anchor[landed] = self.points[landed]
        self._below = below
        self._point_jacobian(jacobian)
        self._velocity[:BASE_DOF] = velocity[:BASE_DOF]
        self._velocity[BASE_DOF:] = velocity[self._leg]
        self._rate = (self._jacobian @ self._velocity).reshape(POINTS, 3)
        stretch = self.points - self._anchor
        stretch[:, 2] = -depth
        self._trial = -self._k * stretch - (self._d + self._step * self._k) * self._rate
        normal = self._trial[:, 2]
        self._pressing = below & (normal > 0.0)
        cone = self._ground.friction * normal
        pull = np.sqrt(self._trial[:, 0] ** 2 + self._trial[:, 1] ** 2)
        self._sticking = self._pressing & (pull <= cone)
        self._slip_force = np.zeros((POINTS, 2))
        self._slip(self._trial, normal)
        return True

    def _point_jacobian(self, jacobian: Array) -> None:
        """Jacobian of the stacked points, shape (18, 13): v + ω × p from the world-frame columns."""
        x, y, z = self.points.T
        turn = self._twist_to_points
        turn[0::3, 4], turn[0::3, 5] = z, -y
        turn[1::3, 3], turn[1::3, 5] = -z, x
        turn[2::3, 3], turn[2::3, 4] = y, -x
        self._columns[:, :BASE_DOF] = jacobian[:, :BASE_DOF]
        self._columns[:, BASE_DOF:] = jacobian[:, self._leg]
        self._jacobian = turn @ self._columns
        self._jacobian *= self._carries

    def _slip(self, spring: Array, normal: Array) -> None:
        """Friction of slipping points: μ f_n along the spring, shape (6, 3) and (6,)."""
        slipping = self._pressing & ~self._sticking
        if slipping.any():
            pull = np.sqrt(spring[:, 0] ** 2 + spring[:, 1] ** 2)
            factor = self._ground.friction * np.maximum(normal, 0.0)[slipping] / pull[slipping]
            self._slip_force[slipping] = spring[slipping, :2] * factor[:, None]

    def add_to(self, matrix: Array, right_side: Array) -> None:
        """Adds the implicit contact to the effective mass (upper triangle) and to the forces."""
        axes = np.empty((POINTS, 3))
        axes[:, :2] = self._sticking[:, None]
        axes[:, 2] = self._pressing
        self._axes = axes
        self._start = self._trial * axes
        slipping = self._pressing & ~self._sticking
        if slipping.any():
            self._start[slipping, :2] = self._slip_force[slipping]
        block = self._jacobian.T @ (self._jacobian * (self._c * axes.reshape(-1, 1)))
        block *= self._upper
        matrix[:BASE_DOF, :BASE_DOF] += block[:BASE_DOF, :BASE_DOF]
        matrix[:BASE_DOF, self._leg] += block[:BASE_DOF, BASE_DOF:]
        matrix[self._leg, self._leg] += block[BASE_DOF:, BASE_DOF:]
        push = self._jacobian.T @ self._start.reshape(-1)
        right_side[:BASE_DOF] += push[:BASE_DOF]
        right_side[self._leg] += push[BASE_DOF:]

    def finish(self, acceleration: Array) -> bool:
        """Forces of the solution; False if a point left its assumed state: solve again.

        Args:
            acceleration: Solution of the step, shape (51,).
        """
        self._velocity[:BASE_DOF] = acceleration[:BASE_DOF]
        self._velocity[BASE_DOF:] = acceleration[self._leg]
        gain = (self._jacobian @ self._velocity).reshape(POINTS, 3)
        spring = self._trial - self._c * gain
        force = self._start - self._c * gain * self._axes
        normal = force[:, 2]
        pull = np.sqrt(force[:, 0] ** 2 + force[:, 1] ** 2)
        cone = self._ground.friction * normal
        lifting = self._pressing & (normal < 0.0)
        breaking = self._sticking & (pull > cone * (1.0 + 1e-9))
        sliding = self._pressing & ~self._sticking
        drifted = sliding & (np.abs(pull - cone) > 1e-3 * cone + 1e-6)
        settled = not (lifting.any() or breaking.any() or drifted.any())
        if not settled:
            self._pressing = self._pressing & ~lifting
            self._sticking = self._sticking & ~lifting & ~breaking
            self._slip(spring, normal)
        # What is left of a violation when solving again did not settle it is clipped.
        np.maximum(normal, 0.0, out=normal)
        if not settled or sliding.any():
            factor = np.where(pull > cone, np.maximum(cone, 0.0) / np.maximum(pull, 1e-12), 1.0)
            force[:, :2] *= factor[:, None]
        self.force = force
        if sliding.any():
            # The anchor follows a slipping point so that the spring carries the clipped force.
            end = self.points + self._step * (self._rate + self._step * gain)
            self._next_anchor = end + force / self._k
            self._moved = sliding
        else:
            self._moved = sliding
        return settled

    def commit(self) -> None:
        """Ends the step: anchors of slipping points move on."""
        if self._moved.any():
            self._anchor[self._moved, :2] = self._next_anchor[self._moved, :2]

    def wrench_about_origin(self) -> Array:
        """Sum of the point forces and their moment about the world origin, shape (6,)."""
        total = np.empty(6)
        force, point = self.force, self.points
        total[:3] = force.sum(axis=0)
        total[3] = point[:, 1] @ force[:, 2] - point[:, 2] @ force[:, 1]
        total[4] = point[:, 2] @ force[:, 0] - point[:, 0] @ force[:, 2]
        total[5] = point[:, 0] @ force[:, 1] - point[:, 1] @ force[:, 0]
        return total
