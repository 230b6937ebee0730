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
    kappa, gamma, total = 1.0, np.zeros(2), np.zeros(3)
    for wrench, h in wrenches:
        f, mu = wrench.force, wrench.torque
        kappa -= float(f[2]) / weight
        gamma = (
            gamma + np.array([h[2] * f[0] - h[0] * f[2] + mu[1], h[2] * f[1] - h[1] * f[2] - mu[0]]) / weight
        )
        total = total + f
    return HandEffect(kappa, gamma, total)
