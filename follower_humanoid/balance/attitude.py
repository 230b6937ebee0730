"""Keeps the pelvis upright and on its heading through what the feet do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import GRAVITY

Vector = Sequence[float]
"""Three plain numbers: NumPy's calls would cost more than the arithmetic."""


@dataclass(frozen=True)
class AttitudeConfig:
    """Gains and limits of the attitude feedback."""

    stiffness: float = parameter(120.0, "pelvis attitude feedback", "1/s²", 0, 1000)
    damping: float = parameter(22.0, "pelvis rate feedback", "1/s", 0, 200)
    inertia: float = parameter(8.0, "inertia that the feedback turns", "kg·m²", 0.1, 50)
    zmp_limit: float = parameter(0.03, "largest ZMP shift for the attitude", "m", 0, 0.1)
    yaw_limit: float = parameter(25.0, "largest yaw moment asked of the feet", "N·m", 0, 100)


def attitude_shift(error: Vector, angular_velocity: Vector, mass: float, config: AttitudeConfig) -> Array:
    """The shift of the ZMP that turns the pelvis upright.

    ΔM = I(k_p e − k_d ω) needs the ground force at p + (−ΔM_y, ΔM_x)/(m g).

    Args:
        error: Rotation vector from measured to desired pelvis attitude, in world [rad].
        angular_velocity: Pelvis minus desired, in world [rad/s].
        mass: Robot mass [kg].
        config: Gains.

    Returns:
        Shape (2,) [m].
    """
    (e_x, e_y, _), (w_x, w_y, _) = error, angular_velocity
    lever, limit = config.inertia / (mass * GRAVITY), config.zmp_limit
    shift_x = -lever * (config.stiffness * e_y - config.damping * w_y)
    shift_y = lever * (config.stiffness * e_x - config.damping * w_x)
    return np.array([min(max(shift_x, -limit), limit), min(max(shift_y, -limit), limit)])


def yaw_moment(
    error: Vector, angular_velocity: Vector, momentum_rate: float, config: AttitudeConfig
) -> float:
    """What the feet must add about the vertical so that the pelvis does not turn with the swing leg.

    M_z = L̇_ref,z + I(k_p e_z − k_d ω_z), within what friction under the soles can do.

    Args:
        error, angular_velocity: As in `attitude_shift`.
        momentum_rate: L̇_z of the reference motion about its CoM [N·m].
        config: Gains.

    Returns:
        [N·m]
    """
    feedback = config.stiffness * error[2] - config.damping * angular_velocity[2]
    moment = momentum_rate + config.inertia * feedback
    return min(max(moment, -config.yaw_limit), config.yaw_limit)
