"""A hand at one tick as an array of vectors in world, and what two of them say about the wrench on it.

Rows of a hand's state:

    0–2  axes of the wrist frame          5  angular momentum about the CoM
    3    origin of the wrist frame        6  CoM
    4    momentum                         7  gripper
"""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import Indices

SHAPE = (8, 3)


@kernel("void(float64[:,::1], float64[::1], float64[::1])")
def turn(axes: Array, vector: Array, turned: Array) -> None:
    """Writes R x, (3,), for axes (≥ 3, 3) whose rows are the columns of R."""
    for n in range(3):
        turned[n] = axes[0, n] * vector[0] + axes[1, n] * vector[1] + axes[2, n] * vector[2]


@kernel_part
def add_wrench(force: Array, torque: Array, arm: Array, total: Array) -> None:
    """Adds force and moment about the end of the arm, (f, τ + r × f), to a wrench, (6,)."""
    for n in range(3):
        after, last = (n + 1) % 3, (n + 2) % 3
        total[n] += force[n]
        total[3 + n] += torque[n] + arm[after] * force[last] - arm[last] * force[after]


@kernel_part
def hand_state(
    pose: Array, twist: Array, mass: float, center: Array, inertia: Array, wrist: Array, gripper: Array,
    state: Array,
) -> None:  # fmt: skip
    """Writes a hand's state after forward kinematics.

    Args:
        pose: Of the joint that carries the hand, in world, see `robot.pose_table`, (4, 3).
        twist: Of the hand, at and in the joint's frame, (6,).
        mass, center, inertia: m, CoM and inertia about it, in the joint's frame.
        wrist: Pose of the wrist frame in the joint's, (4, 3).
        gripper: Place of the gripper in the joint's frame, (3,).
        state: Written, (8, 3).
    """
    local = np.empty((2, 3))  # momentum and angular momentum in the joint's axes
    for n in range(3):
        after, last = (n + 1) % 3, (n + 2) % 3
        turning = twist[3 + after] * center[last] - twist[3 + last] * center[after]
        local[0, n] = mass * (twist[n] + turning)
        local[1, n] = inertia[n, 0] * twist[3] + inertia[n, 1] * twist[4] + inertia[n, 2] * twist[5]
    for row in range(4):
        turn(pose, wrist[row], state[row])
    turn(pose, local[0], state[4])
    turn(pose, local[1], state[5])
    turn(pose, center, state[6])
    turn(pose, gripper, state[7])
    for n in range(3):
        state[3, n] += pose[3, n]
        state[6, n] += pose[3, n]
        state[7, n] += pose[3, n]


@kernel_part
def add_share(
    state: Array, reference: Array, reading: Array, half_weight: float, rate: float, total: Array
) -> None:
    """Adds one tick's share of the external wrench: half the reading, half the weight, ± momentum.

    Args:
        state: Of the hand, (8, 3).
        reference: Point about which moments are taken, in world, (3,).
        reading: Hand on forearm at and in the wrist frame, (6,).
        half_weight: m g/2, which the external wrench must carry: upwards.
        rate: 1/Δt at the end of a tick, −1/Δt at its beginning.
        total: Changed, (6,).
    """
    force, torque, arm = np.empty(3), np.empty(3), np.empty(3)
    turn(state, reading[:3], force)
    turn(state, reading[3:], torque)
    for n in range(3):
        force[n] *= 0.5
        torque[n] *= 0.5
        arm[n] = state[3, n] - reference[n]
    add_wrench(force, torque, arm, total)
    for n in range(3):
        force[n] = rate * state[4, n]
        torque[n] = rate * state[5, n]
        arm[n] = state[6, n] - reference[n]
    force[2] += half_weight
    add_wrench(force, torque, arm, total)


@kernel_part
def external_wrench(
    before: Array, now: Array, reading: Array, weight: float, period: float, wrench: Array
) -> None:
    """Writes F_ext = m (c̈ − g) + F_s and the moment about the gripper's mean place, in world.

    Args:
        before, now: States at both ends of the tick, (8, 3).
        reading: F_s: mean over the tick of hand on forearm, at and in the wrist frame, (6,).
        weight: m g.
        period: Δt.
        wrench: Written, (6,).
    """
    reference = np.empty(3)
    for n in range(3):
        reference[n] = 0.5 * (before[7, n] + now[7, n])
        wrench[n] = wrench[3 + n] = 0.0
    add_share(before, reference, reading, 0.5 * weight, -1.0 / period, wrench)
    add_share(now, reference, reading, 0.5 * weight, 1.0 / period, wrench)


@kernel(
    "void(float64[:,:,::1], intp[::1], float64[::1], float64[::1], float64[::1], float64[:,::1], "
    "float64[:,:,::1], float64[:,:,::1], float64[:,::1], float64[:], float64[:], float64[:], float64[:], "
    "float64, float64, float64, boolean, float64[:,:,::1], float64[:,::1])"
)
def follow_hands(
    poses: Array, joints: Indices, left_twist: Array, right_twist: Array, masses: Array, centers: Array,
    inertias: Array, wrists: Array, grippers: Array,
    left_force: Array, left_torque: Array, right_force: Array, right_torque: Array,
    gravity: float, period: float, share: float, first: bool, states: Array, filtered: Array,
) -> None:  # fmt: skip
    """One tick of both hands, left first, after forward kinematics.

    Args:
        poses: Of all joints in world, (joints, 4, 3).
        joints: Which carry the hands, (2,).
        left_twist, right_twist: Of the hands, at and in the axes of their joints, (6,).
        masses, centers, inertias, wrists, grippers: As for `hand_state`, (2, …).
        left_force, left_torque, right_force, right_torque: Readings, at and in the wrist frames, (3,).
        gravity, period: g and Δt.
        share: Of the low-pass, see `filter_share`.
        first: There was no tick before: the hands rest, and the first wrench passes unfiltered.
        states: Of the hands at the last tick, (2, 8, 3); moves on to this one.
        filtered: Low-passed external wrenches, (2, 6); moves on.
    """
    now, reading, sample = np.empty(SHAPE), np.empty(6), np.empty(6)
    for hand in range(2):
        twist = left_twist if hand == 0 else right_twist
        reading[:3] = left_force if hand == 0 else right_force
        reading[3:] = left_torque if hand == 0 else right_torque
        hand_state(
            poses[joints[hand]], twist, masses[hand], centers[hand], inertias[hand], wrists[hand],
            grippers[hand], now,
        )  # fmt: skip
        before = now if first else states[hand]
        external_wrench(before, now, reading, masses[hand] * gravity, period, sample)
        for n in range(6):
            rise = share * (sample[n] - filtered[hand, n])
            filtered[hand, n] = sample[n] if first else filtered[hand, n] + rise
        states[hand] = now
