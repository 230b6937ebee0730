"""Shares a desired ground force between the feet, each within what its sole can do."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from follower_humanoid.balance.zmp import SolePlace
from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, ContactPlan, Wrench

OUT_OF_REACH = 0.002  # a ZMP this near is reached [m]
SAME = 1e-6  # points this near each other are the same [m]
TRIED_SHARES = 17
Soles = tuple[SolePlace, SolePlace]
"""Left and right sole in world."""


@dataclass(frozen=True)
class SoleConfig:
    """The part of a sole in which its own ZMP is kept, and friction."""

    back: float = parameter(-0.060, "rear edge of the usable sole", "m", -0.2, 0)
    front: float = parameter(0.140, "front edge of the usable sole", "m", 0, 0.3)
    side: float = parameter(0.046, "half width of the usable sole", "m", 0.005, 0.1)
    center: float = parameter(0.030, "middle of the sole ahead of the ankle", "m", -0.1, 0.15)
    friction: float = parameter(0.6, "largest tangential force as part of the normal force", "", 0.05, 2)


class FootWrenches(NamedTuple):
    """What the ground should do to each foot, at and in its sole frame, and the ZMP that this makes.

    Attributes:
        left, right: Wrenches.
        zmp: In world, shape (2,) [m].
    """

    left: Wrench
    right: Wrench
    zmp: Array


@kernel("UniTuple(float64, 2)(float64[:,:])")
def ahead_of(rotation: Array) -> tuple[float, float]:
    """Direction of a sole over the ground, of length 1."""
    length = max(math.hypot(rotation[0, 0], rotation[1, 0]), 1e-9)
    return rotation[0, 0] / length, rotation[1, 0] / length


@kernel("UniTuple(float64, 2)(float64, float64, float64[::1], float64, float64, float64, float64, float64)")
def nearest_in_sole(
    x: float, y: float, position: Array, c: float, s: float, back: float, front: float, side: float
) -> tuple[float, float]:
    """The point of the usable sole, of direction c, s, that is nearest to x, y [m]; else as in `shared`."""
    away_x, away_y = x - position[0], y - position[1]
    forward = min(max(c * away_x + s * away_y, back), front)
    left = min(max(c * away_y - s * away_x, -side), side)
    return position[0] + forward * c - left * s, position[1] + forward * s + left * c


@kernel(
    "float64(float64[::1], float64[::1], float64[:,:], float64[::1], float64[:,:],"
    " float64, float64, float64, float64, float64, float64, float64[:,::1])"
)
def shared(
    zmp: Array, left_position: Array, left_rotation: Array, right_position: Array, right_rotation: Array,
    left_most: float, right_most: float, center: float, back: float, front: float, side: float,
    points: Array,
) -> float:  # fmt: skip
    """The left foot's share; writes the points of left and right foot and the ZMP they make.

    See `share_force`.

    Args:
        zmp: Desired ZMP in world, shape (2,) [m].
        left_position, left_rotation, right_position, right_rotation: Soles in world.
        left_most, right_most: Most that either foot may carry by plan, 0…1.
        center: Middle of the sole ahead of the ankle [m].
        back, front, side: Usable sole [m].
        points: Written, in world, shape (3, 2) [m].
    """
    l_c, l_s = ahead_of(left_rotation)
    left_x, left_y = left_position[0] + center * l_c, left_position[1] + center * l_s
    r_c, r_s = ahead_of(right_rotation)
    right_x, right_y = right_position[0] + center * r_c, right_position[1] + center * r_s
    line_x, line_y = left_x - right_x, left_y - right_y
    length2 = line_x**2 + line_y**2
    left = 0.5
    if length2 > 1e-6:
        left = ((zmp[0] - right_x) * line_x + (zmp[1] - right_y) * line_y) / length2
    # Loads change hands only as fast as the plan lets them.
    low, high = min(1.0 - right_most, left_most), max(1.0 - right_most, left_most)
    first = min(max(left, low), high)
    best, nearest = first, math.inf
    # Feet apart along and across: the nearest point that the soles reach may need another share.
    for i in range(-1, TRIED_SHARES):
        share = first if i < 0 else low + (high - low) * i / (TRIED_SHARES - 1)
        rest_x = zmp[0] - (share * left_x + (1.0 - share) * right_x)
        rest_y = zmp[1] - (share * left_y + (1.0 - share) * right_y)
        l_x, l_y = nearest_in_sole(
            left_x + rest_x, left_y + rest_y, left_position, l_c, l_s, back, front, side
        )
        r_x, r_y = nearest_in_sole(
            right_x + rest_x, right_y + rest_y, right_position, r_c, r_s, back, front, side
        )
        made_x, made_y = share * l_x + (1.0 - share) * r_x, share * l_y + (1.0 - share) * r_y
        away = math.hypot(made_x - zmp[0], made_y - zmp[1])
        as_near = abs(away - nearest) <= SAME and abs(share - first) < abs(best - first)
        if away < nearest - SAME or as_near:
            best, nearest = share, away
            points[0, 0], points[0, 1], points[1, 0], points[1, 1] = l_x, l_y, r_x, r_y
            points[2, 0], points[2, 1] = made_x, made_y
        if nearest < OUT_OF_REACH or high <= low:
            break
    return best


def reachable_zmp(zmp: Array, soles: Soles, plan: ContactPlan, config: SoleConfig) -> Array:
    """What the soles leave of a desired ZMP; arguments as in `share_force`.

    Returns:
        In world, shape (2,) [m].
    """
    left, right = soles
    points = np.empty((3, 2))
    shared(
        zmp, left.position, left.rotation, right.position, right.rotation,
        plan.left, plan.right, config.center, config.back, config.front, config.side, points,
    )  # fmt: skip
    reachable: Array = points[2]
    return reachable


@kernel(
    "void(float64, float64[::1], float64[::1], float64, float64[::1], float64[:,:], float64, float64[:,::1])"
)
def wrench_in_sole(
    share: float, point: Array, force: Array, yaw_moment: float,
    position: Array, rotation: Array, friction: float, wrench: Array,
) -> None:  # fmt: skip
    """Writes a foot's part of the total force, at and in its sole frame.

    Args:
        share: Part of the force, 0…1.
        point: Where it acts on the ground in world, shape (2,) [m].
        force: Total force in world, shape (3,) [N].
        yaw_moment: Total moment about the vertical through the foot's point [N·m].
        position, rotation: The sole in world, shape (3,) [m] and (3, 3).
        friction: Limit of tangential over normal force.
        wrench: Written, force and moment, shape (2, 3) [N], [N·m].
    """
    f_x, f_y, f_z = share * force[0], share * force[1], share * force[2]
    tangential, limit = math.hypot(f_x, f_y), friction * max(f_z, 0.0)
    if tangential > limit:
        f_x, f_y = f_x * (limit / tangential), f_y * (limit / tangential)
    x, y, z = point[0] - position[0], point[1] - position[1], -position[2]
    m_x, m_y, m_z = y * f_z - z * f_y, z * f_x - x * f_z, x * f_y - y * f_x + share * yaw_moment
    for i in range(3):
        wrench[0, i] = rotation[0, i] * f_x + rotation[1, i] * f_y + rotation[2, i] * f_z
        wrench[1, i] = rotation[0, i] * m_x + rotation[1, i] * m_y + rotation[2, i] * m_z


@kernel(
    "void(float64[::1], float64[::1], float64, float64[::1], float64[:,:], float64[::1], float64[:,:],"
    " float64, float64, float64, float64, float64, float64, float64, float64[:,::1], float64[:,:,::1])"
)
def shared_wrenches(
    zmp: Array, force: Array, yaw_moment: float,
    left_position: Array, left_rotation: Array, right_position: Array, right_rotation: Array,
    left_most: float, right_most: float, center: float, back: float, front: float, side: float,
    friction: float, points: Array, wrenches: Array,
) -> None:  # fmt: skip
    """Writes the points of `shared` and the wrenches of left and right foot, shape (2, 2, 3)."""
    left = shared(
        zmp, left_position, left_rotation, right_position, right_rotation,
        left_most, right_most, center, back, front, side, points,
    )  # fmt: skip
    wrench_in_sole(left, points[0], force, yaw_moment, left_position, left_rotation, friction, wrenches[0])
    wrench_in_sole(
        1.0 - left, points[1], force, yaw_moment, right_position, right_rotation, friction, wrenches[1]
    )


def share_force(
    zmp: Array, force: Array, yaw_moment: float, soles: Soles, plan: ContactPlan, config: SoleConfig
) -> FootWrenches:
    """Shares a force at a ZMP: first by where it lies between the feet, the rest inside the soles.

    Args:
        zmp: Desired ZMP in world, shape (2,) [m].
        force: Total force in world, shape (3,) [N].
        yaw_moment: Total moment about the vertical through the ZMP [N·m].
        soles: Left and right sole in world.
        plan: Most that either foot may carry by plan.
        config: Usable sole and friction.
    """
    left, right = soles
    points, wrenches = np.empty((3, 2)), np.empty((2, 2, 3))
    shared_wrenches(
        zmp, force, yaw_moment, left.position, left.rotation, right.position, right.rotation,
        plan.left, plan.right, config.center, config.back, config.front, config.side, config.friction,
        points, wrenches,
    )  # fmt: skip
    of_left, of_right = wrenches
    return FootWrenches(Wrench(of_left[0], of_left[1]), Wrench(of_right[0], of_right[1]), points[2])
