"""What the hand forces do to the pendulum (as in Murooka et al. 2021, RA-L: loco-manipulation).

With a wrench (f, μ) on the robot at h and the ground at z = 0 the pendulum obeys κ p = c − c̈/ω² + γ with

    κ   = 1 − Σ f_z/(m g)
    γ_x = Σ (h_z f_x − h_x f_z + μ_y)/(m g)
    γ_y = Σ (h_z f_y − h_y f_z − μ_x)/(m g)

so the CoM that rests above a ZMP p is c = κ p − γ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.robot.model import GRAVITY


class HandEffect(NamedTuple):
    """κ and γ of the hand wrenches, and their sum.

    Attributes:
        kappa: Pure number; 1 without vertical force.
        gamma: Shape (2,) [m].
        force: Total force of the hands' environment on the robot, in world, shape (3,) [N].
    """

    kappa: float
    gamma: Array
    force: Array

    def resting_com(self, zmp: Array) -> Array:
        """The CoM that rests above a ZMP, shape (2,) [m]."""
        return self.kappa * zmp - self.gamma


def hand_effect(wrenches: list[tuple[Wrench, Array]], mass: float) -> HandEffect:
    """κ and γ of the hands.

    Args:
        wrenches: Per hand the wrench on the robot in world axes and its point in world, shape (3,) [m].
        mass: Robot mass [kg].
    """
    kappa, gamma, force = 1.0, np.zeros(2), np.zeros(3)
    for wrench, point in wrenches:
        kappa -= _add_hand(wrench.force, wrench.torque, point, mass * GRAVITY, gamma, force)
    return HandEffect(kappa, gamma, force)


@kernel("float64(float64[::1], float64[::1], float64[::1], float64, float64[::1], float64[::1])")
def _add_hand(force: Array, torque: Array, point: Array, weight: float, gamma: Array, total: Array) -> float:
    """Adds what one hand does to γ and the total force; returns what it takes from κ.

    Args:
        force, torque: Wrench on the robot in world axes, shape (3,) each [N], [N·m].
        point: Where it acts in world, shape (3,) [m].
        weight: m g [N].
        gamma: Added to, shape (2,) [m].
        total: Added to, shape (3,) [N].
    """
    gamma[0] += (point[2] * force[0] - point[0] * force[2] + torque[1]) / weight
    gamma[1] += (point[2] * force[1] - point[1] * force[2] - torque[0]) / weight
    for axis in range(3):
        total[axis] += force[axis]
    return float(force[2] / weight)
