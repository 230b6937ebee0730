"""The DCM balance law: from where the DCM and the hands are to what the ground must do to each foot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import GRAVITY

REACHED = 0.002  # a ZMP this near is reached [m]
SAME = 1e-6  # points this near each other are the same [m]
TRIED_SHARES = 17  # over what the plan allows

Gains = tuple[float, float, float]  # values of `DcmConfig`, in its order
UsableSole = tuple[float, float, float, float, float]  # values of `SoleConfig`, in its order


@dataclass(frozen=True)
class DcmConfig:
    """Gains of the DCM law and of the CoM height."""

    proportional: float = parameter(3.0, "decay rate of a DCM error", "1/s", 0, 20)
    height_stiffness: float = parameter(60.0, "CoM height feedback", "1/s²", 0, 500)
    height_damping: float = parameter(16.0, "CoM vertical speed feedback", "1/s", 0, 100)


@dataclass(frozen=True)
class SoleConfig:
    """The part of a sole in which its own ZMP is kept, and friction."""

    back: float = parameter(-0.060, "rear edge of the usable sole", "m", -0.2, 0)
    front: float = parameter(0.140, "front edge of the usable sole", "m", 0, 0.3)
    side: float = parameter(0.046, "half width of the usable sole", "m", 0.005, 0.1)
    center: float = parameter(0.030, "middle of the sole ahead of the ankle", "m", -0.1, 0.15)
    friction: float = parameter(0.6, "largest tangential force as part of the normal force", "", 0.05, 2)


@kernel_part
def measured_dcm(com: Array, velocity: Array, kappa: float, gamma: Array, omega: float) -> Array:
    """ξ = (c + ċ/ω + γ)/κ: the DCM with what the hands do taken in, shape (2,) [m].

    Args:
        com, velocity: Measured CoM in world, shape (3,) each [m], [m/s].
        kappa, gamma: Of the hands, see `HandEffect`.
        omega: Natural frequency [1/s].
    """
    dcm = np.empty(2)
    for axis in range(2):
        dcm[axis] = (com[axis] + velocity[axis] / omega + gamma[axis]) / kappa
    return dcm


@kernel_part
def desired_zmp(dcm: Array, dcm_plan: Array, zmp_plan: Array, omega: float, gain: float) -> Array:
    """p = p_plan + (1 + k/ω)(ξ − ξ_plan): the DCM error decays as e^{−kt}; before any limit, shape (2,) [m].

    Args:
        dcm: Measured, in world, shape (2,) [m].
        dcm_plan, zmp_plan: In world, shape (≥ 2,) [m].
        omega: Natural frequency [1/s].
        gain: Decay rate k [1/s].
    """
    factor, zmp = 1.0 + gain / omega, np.empty(2)
    for axis in range(2):
        zmp[axis] = zmp_plan[axis] + factor * (dcm[axis] - dcm_plan[axis])
    return zmp


@kernel_part
def desired_force(
    mass: float, com: Array, velocity: Array, wanted_com: Array, wanted_velocity: Array, stiffness: float,
    zmp: Array, kappa: float, gamma: Array, hands: Array, turning: Array, gains: Gains,
) -> Array:  # fmt: skip
    """What the ground must do to the feet in total, in world, shape (3,) [N].

    F_xy = m ω²(c + γ − κ p − λ̇) − Σ f_hand,xy and F_z = m(g + k_p e_z + k_d ė_z) − Σ f_hand,z.

    Args:
        mass: m of the robot [kg].
        com, velocity: CoM in world, shape (3,) each [m], [m/s].
        wanted_com, wanted_velocity: Of the reference, likewise; only its height is followed here.
        stiffness: m ω² [N/m].
        zmp: p, desired before the attitude shift, in world, shape (2,) [m].
        kappa, gamma, hands: Effect of the hands and the sum of their forces, see `HandEffect`.
        turning: λ̇, what the swing leg's angular momentum does, shape (2,) [m].
        gains: Of which k_p [1/s²] and k_d [1/s] are for the height.
    """
    _, height_stiffness, height_damping = gains
    force = np.empty(3)
    for axis in range(2):
        lever = com[axis] + gamma[axis] - kappa * zmp[axis] - turning[axis]
        force[axis] = stiffness * lever - hands[axis]
    lift = height_stiffness * (wanted_com[2] - com[2])
    lift += height_damping * (wanted_velocity[2] - velocity[2])
    force[2] = max(mass * (GRAVITY + lift) - hands[2], 0.0)
    return force


@kernel_part
def ahead_of(sole: Array) -> tuple[float, float]:
    """Direction of a sole, shape (4, 3), over the ground, of length 1."""
    length = max(math.hypot(sole[0, 0], sole[0, 1]), 1e-9)
    return sole[0, 0] / length, sole[0, 1] / length


@kernel_part
def nearest_in_sole(
    x: float, y: float, sole: Array, c: float, s: float, usable: UsableSole
) -> tuple[float, float]:
    """The point of the usable sole, of direction c, s, that is nearest to x, y [m]; else as in `shared`."""
    back, front, side, _, _ = usable
    away_x, away_y = x - sole[3, 0], y - sole[3, 1]
    forward = min(max(c * away_x + s * away_y, back), front)
    left = min(max(c * away_y - s * away_x, -side), side)
    return sole[3, 0] + forward * c - left * s, sole[3, 1] + forward * s + left * c


@kernel_part
def shared(
    zmp: Array, left_sole: Array, right_sole: Array, most: tuple[float, float], usable: UsableSole,
    points: Array,
) -> float:  # fmt: skip
    """The left foot's share; writes the points of left and right foot and the ZMP they make.

    First by where the ZMP lies between the feet, the rest inside the soles.

    Args:
        zmp: Desired ZMP in world, shape (2,) [m].
        left_sole, right_sole: Axes and origin in world, shape (4, 3), as in `robot.pose_table`.
        most: Most that left and right foot may carry by plan, 0…1.
        usable: The part of either sole that is.
        points: Written, in world, shape (3, 2) [m].
    """
    (left_most, right_most), (_, _, _, center, _) = most, usable
    l_c, l_s = ahead_of(left_sole)
    left_x, left_y = left_sole[3, 0] + center * l_c, left_sole[3, 1] + center * l_s
    r_c, r_s = ahead_of(right_sole)
    right_x, right_y = right_sole[3, 0] + center * r_c, right_sole[3, 1] + center * r_s
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
        l_x, l_y = nearest_in_sole(left_x + rest_x, left_y + rest_y, left_sole, l_c, l_s, usable)
        r_x, r_y = nearest_in_sole(right_x + rest_x, right_y + rest_y, right_sole, r_c, r_s, usable)
        made_x, made_y = share * l_x + (1.0 - share) * r_x, share * l_y + (1.0 - share) * r_y
        away = math.hypot(made_x - zmp[0], made_y - zmp[1])
        as_near = abs(away - nearest) <= SAME and abs(share - first) < abs(best - first)
        if away < nearest - SAME or as_near:
            best, nearest = share, away
            points[0, 0], points[0, 1], points[1, 0], points[1, 1] = l_x, l_y, r_x, r_y
            points[2, 0], points[2, 1] = made_x, made_y
        if nearest < REACHED or high <= low:
            break
    return best


@kernel_part
def wrench_in_sole(
    share: float, point: Array, force: Array, yaw_moment: float, sole: Array, friction: float, wrench: Array
) -> None:
    """Writes a foot's part of the total force, at and in its sole frame.

    Args:
        share: Part of the force, 0…1.
        point: Where it acts on the ground in world, shape (2,) [m].
        force: Total force in world, shape (3,) [N].
        yaw_moment: Total moment about the vertical through the foot's point [N·m].
        sole: Its axes and origin in world, shape (4, 3).
        friction: Limit of tangential over normal force.
        wrench: Written, force and moment, shape (2, 3) [N], [N·m].
    """
    f_x, f_y, f_z = share * force[0], share * force[1], share * force[2]
    tangential, limit = math.hypot(f_x, f_y), friction * max(f_z, 0.0)
    if tangential > limit:
        f_x, f_y = f_x * (limit / tangential), f_y * (limit / tangential)
    x, y, z = point[0] - sole[3, 0], point[1] - sole[3, 1], -sole[3, 2]
    m_x, m_y, m_z = y * f_z - z * f_y, z * f_x - x * f_z, x * f_y - y * f_x + share * yaw_moment
    for i in range(3):
        wrench[0, i] = sole[i, 0] * f_x + sole[i, 1] * f_y + sole[i, 2] * f_z
        wrench[1, i] = sole[i, 0] * m_x + sole[i, 1] * m_y + sole[i, 2] * m_z


@kernel(
    "float64[:,::1](boolean, float64, float64[::1], float64[::1], float64, float64[::1], float64[::1],"
    " float64, float64[::1], float64[::1], float64, float64[::1], float64[::1],"
    " float64[::1], float64[::1], float64, float64[:,::1], float64[:,::1],"
    " UniTuple(float64, 2), UniTuple(float64, 3), UniTuple(float64, 5))"
)
def corrected(
    feedback: bool, mass: float, com: Array, velocity: Array,
    omega: float, wanted_com: Array, wanted_velocity: Array,
    stiffness: float, dcm_plan: Array, zmp_plan: Array,
    kappa: float, gamma: Array, hands: Array,
    turning: Array, shift: Array, yaw_moment: float,
    left_sole: Array, right_sole: Array, most: tuple[float, float], gains: Gains, usable: UsableSole,
) -> Array:  # fmt: skip
    """The whole law, one step after the other.

    No number stands next to another, where a swap would go unseen.

    Args:
        feedback: False leaves DCM and CoM height to themselves: the force is that of the plan.
        shift: Of the ZMP, for the attitude, shape (2,) [m].
        The others: As in the functions above.

    Returns:
        Rows of shape (3,): measured DCM and the ZMP that is made, on the ground in world [m]; force [N] and
        moment [N·m] on the left foot, then on the right, at and in its sole frame.
    """
    (gain, _, _), (_, _, _, _, friction) = gains, usable
    dcm, wanted = measured_dcm(com, velocity, kappa, gamma, omega), zmp_plan[:2]
    if feedback:
        wanted = desired_zmp(dcm, dcm_plan, zmp_plan, omega, gain)
    else:
        com, velocity = wanted_com, wanted_velocity
    points = np.empty((3, 2))
    shared(wanted, left_sole, right_sole, most, usable, points)
    force = desired_force(
        mass, com, velocity, wanted_com, wanted_velocity, stiffness,
        points[2], kappa, gamma, hands, turning, gains,
    )  # fmt: skip
    # Of the wanted ZMP, not of what soles leave of it: at their edge the DCM goes before the attitude.
    left = shared(wanted + shift, left_sole, right_sole, most, usable, points)
    result = np.zeros((6, 3))
    result[0, :2], result[1, :2] = dcm, points[2]
    wrench_in_sole(left, points[0], force, yaw_moment, left_sole, friction, result[2:4])
    wrench_in_sole(1.0 - left, points[1], force, yaw_moment, right_sole, friction, result[4:6])
    return result
