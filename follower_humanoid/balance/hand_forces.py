"""What the hand forces do to the pendulum (as in Murooka et al. 2021, RA-L: loco-manipulation).

With a wrench (f, μ) on the robot at h and the ground at z = 0 the pendulum obeys κ p = c − c̈/ω² + γ with

    κ   = 1 − Σ f_z/(m g)
    γ_x = Σ (h_z f_x − h_x f_z + μ_y)/(m g)
    γ_y = Σ (h_z f_y − h_y f_z − μ_x)/(m g)

so the CoM that rests above a ZMP p is c = κ p − γ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.robot.model import GRAVITY


@dataclass(frozen=True, slots=True)
class HandEffect:
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
    weight = mass * GRAVITY
    kappa, gamma_x, gamma_y = 1.0, 0.0, 0.0
    total_x, total_y, total_z = 0.0, 0.0, 0.0
    for wrench, point in wrenches:
        # Plain numbers: NumPy's calls would cost more than the arithmetic.
        (f_x, f_y, f_z), (mu_x, mu_y, _) = wrench.force.tolist(), wrench.torque.tolist()
        h_x, h_y, h_z = point.tolist()
        kappa -= f_z / weight
        gamma_x += (h_z * f_x - h_x * f_z + mu_y) / weight
        gamma_y += (h_z * f_y - h_y * f_z - mu_x) / weight
        total_x, total_y, total_z = total_x + f_x, total_y + f_y, total_z + f_z
    return HandEffect(kappa, np.array([gamma_x, gamma_y]), np.array([total_x, total_y, total_z]))
