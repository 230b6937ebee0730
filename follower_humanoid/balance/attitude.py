"""Keeps the pelvis upright and on its heading through what the feet do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array


@dataclass(frozen=True)
class AttitudeConfig:
    """Gains and limits of the attitude feedback."""

    stiffness: float = parameter(120.0, "pelvis attitude feedback", "1/s²", 0, 1000)
    damping: float = parameter(22.0, "pelvis rate feedback", "1/s", 0, 200)
    inertia: float = parameter(8.0, "inertia that the feedback turns", "kg·m²", 0.1, 50)
    zmp_limit: float = parameter(0.03, "largest ZMP shift for the attitude", "m", 0, 0.1)
    yaw_limit: float = parameter(25.0, "largest yaw moment asked of the feet", "N·m", 0, 100)


@kernel(
    "Tuple((float64[::1], float64))(UniTuple(float64, 3), float64[::1], float64[::1], float64[::1],"
    " float64, UniTuple(float64, 5))"
)
def attitude_feedback(
    error: tuple[float, float, float], spin: Array, wanted_spin: Array, momentum_rate: Array,
    weight: float, gains: tuple[float, float, float, float, float],
) -> tuple[Array, float]:  # fmt: skip
    """The shift of the ZMP that turns the pelvis upright and the yaw moment that keeps its heading.

    ΔM = I(k_p e − k_d Δω) needs the ground force at p + (−ΔM_y, ΔM_x)/(m g), and about the vertical
    M_z = L̇_ref,z + ΔM_z, so that the pelvis does not turn with the swing leg.

    Args:
        error: e, rotation vector from measured to desired pelvis attitude, in world [rad].
        spin, wanted_spin: Angular velocity of the pelvis and the desired one; Δω is their difference, in
            world, shape (3,) each [rad/s].
        momentum_rate: L̇ of the reference motion about its CoM, shape (3,) [N·m].
        weight: m g [N].
        gains: Values of `AttitudeConfig`, in its order.

    Returns:
        The shift, shape (2,) [m], and the moment [N·m], within their limits.
    """
    stiffness, damping, inertia, zmp_limit, yaw_limit = gains
    rate_x, rate_y, rate_z = spin[0] - wanted_spin[0], spin[1] - wanted_spin[1], spin[2] - wanted_spin[2]
    lever, shift = inertia / weight, np.empty(2)
    shift[0] = -lever * (stiffness * error[1] - damping * rate_y)
    shift[1] = lever * (stiffness * error[0] - damping * rate_x)
    for axis in range(2):
        shift[axis] = min(max(shift[axis], -zmp_limit), zmp_limit)
    moment = momentum_rate[2] + inertia * (stiffness * error[2] - damping * rate_z)
    return shift, min(max(moment, -yaw_limit), yaw_limit)
