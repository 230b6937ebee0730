"""Impedance of the hand, commanded as joint accelerations: corrected eq. (8) and its null-space term.

Sign convention of the package: error = desired − measured, so the paper's q̃ and x̃ are −e here.
Everything works on stacks: the first axis runs over arms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array


@dataclass(frozen=True)
class Impedance:
    """Wanted behaviour of the hand, eq. (3): `H_m ẍ̃ + D_m ẋ̃ + K_m x̃ = F`, per axis of the task.

    Attributes:
        inertia: H_m, shape (3,) [kg].
        damping: D_m, shape (3,) [N·s/m].
        stiffness: K_m, shape (3,) [N/m].
    """

    inertia: Array
    damping: Array
    stiffness: Array

    @staticmethod
    def with_damping_ratio(inertia: Array, stiffness: Array, ratio: float) -> Impedance:
        """`D_m = 2 ζ √(K_m H_m)`; ratio ζ = 1 is critical damping."""
        return Impedance(inertia, 2.0 * ratio * np.sqrt(stiffness * inertia), stiffness)

    def force(self, error: Array, error_rate: Array) -> Array:
        """What spring and damper do to the hand, `D_m ė + K_m e`.

        Args:
            error: e = −x̃, shape (..., 3) [m].
            error_rate: Shape (..., 3) [m/s].

        Returns:
            Shape (..., 3) [N].
        """
        total: Array = self.damping * error_rate + self.stiffness * error
        return total


@kernel("(float64[::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1])")
def impedance_acceleration(inertia: Array, jacobian: Array, inverse: Array, force: Array) -> Array:
    """Joint acceleration by which a force moves the hand as if it had the mass H_m.

    `J⁺ H_m⁻¹ J⁺ᵀ Jᵀ f`, to be added to q̈_d, with f = F + D_m ė + K_m e. Eq. (8) has
    D_m J q̃̇ and K_m J q̃ in the place of D_m ẋ̃ and K_m x̃ of eq. (3): the same to first order, but
    at the 0.1 m a leader pulls, J q̃ is centimetres off, and the vertical stiffness would make that
    a force that nobody applies. So the displacement itself goes in.

    Args:
        inertia: H_m, shape (3,) [kg].
        jacobian: J, shape (arms, 3, n).
        inverse: J⁺ of the same Jacobian, shape (arms, n, 3).
        force: f in the task's axes, shape (arms, 3) [N].

    Returns:
        Shape (arms, n) [rad/s²].

    Reference: Savić et al. 2016, eq. (8), sign corrected.
    """
    arms, joints, size = inverse.shape
    acceleration = np.zeros((arms, joints))
    for arm in range(arms):
        felt = np.zeros(size)
        for joint in range(joints):
            joint_force = 0.0
            for axis in range(size):
                joint_force += jacobian[arm, axis, joint] * force[arm, axis]
            for axis in range(size):
                felt[axis] += inverse[arm, joint, axis] * joint_force
        for joint in range(joints):
            for axis in range(size):
                acceleration[arm, joint] += inverse[arm, joint, axis] * felt[axis] / inertia[axis]
    return acceleration


@kernel("(float64[:,:,::1], float64[:,::1], float64[:,::1], float64, float64)")
def posture_acceleration(
    null: Array, velocity_error: Array, posture_error: Array, stiffness: float, damping: float
) -> Array:
    """`N (k_d ė + k_p (q_0 − q))`: keeps the self-motion of the arm still and near its posture.

    Args:
        null: N, null projector of the hand task, shape (arms, n, n).
        velocity_error: ė = q̇_d − q̇, shape (arms, n) [rad/s].
        posture_error: q_0 − q, shape (arms, n) [rad].
        stiffness: k_p [1/s²].
        damping: k_d [1/s].

    Returns:
        Shape (arms, n) [rad/s²]; it moves no hand.
    """
    acceleration = np.zeros(velocity_error.shape)
    arms, joints = velocity_error.shape
    for arm in range(arms):
        for other in range(joints):
            wanted = damping * velocity_error[arm, other] + stiffness * posture_error[arm, other]
            for joint in range(joints):
                acceleration[arm, joint] += null[arm, joint, other] * wanted
    return acceleration


@kernel("(float64[:,::1], float64[:,::1], float64, float64, float64)")
def range_force(error: Array, error_rate: Array, reach: float, stiffness: float, mass: float) -> Array:
    """Force that keeps a hand within a ball around its place: a soft wall, critically damped outwards.

    Args:
        error: Place minus hand, shape (arms, 3) [m].
        error_rate: Shape (arms, 3) [m/s].
        reach: Radius of the ball [m].
        stiffness: Of the wall [N/m].
        mass: Of the hand, which sets the damping [kg].

    Returns:
        Shape (arms, 3) [N]; zero inside the ball.
    """
    force = np.zeros(error.shape)
    damping = 2.0 * math.sqrt(stiffness * mass)
    for arm in range(error.shape[0]):
        distance = math.sqrt(error[arm, 0] ** 2 + error[arm, 1] ** 2 + error[arm, 2] ** 2)
        if distance <= reach:
            continue
        leaving = 0.0
        for axis in range(3):
            leaving += error_rate[arm, axis] * error[arm, axis] / distance
        inwards = stiffness * (distance - reach) + damping * max(leaving, 0.0)
        for axis in range(3):
            force[arm, axis] = inwards * error[arm, axis] / distance
    return force


@kernel("(float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1], float64, float64)")
def stop_avoidance(
    position: Array, velocity: Array, lower: Array, upper: Array, stiffness: float, damping: float
) -> Array:
    """Spring and damper that act only beyond `lower` and `upper`, before the hard stops are met.

    The damper brakes motion outwards only: on the way back it would pull into the stop.

    Args:
        position, velocity: Shape (arms, n) [rad], [rad/s].
        lower, upper: Where the springs begin, shape (arms, n) [rad].
        stiffness: [1/s²].
        damping: [1/s].

    Returns:
        Shape (arms, n) [rad/s²].
    """
    braking = np.zeros(position.shape)
    arms, joints = position.shape
    for arm in range(arms):
        for joint in range(joints):
            above = position[arm, joint] - upper[arm, joint]
            below = lower[arm, joint] - position[arm, joint]
            if above > 0.0:
                braking[arm, joint] -= stiffness * above + damping * max(velocity[arm, joint], 0.0)
            if below > 0.0:
                braking[arm, joint] += stiffness * below - damping * min(velocity[arm, joint], 0.0)
    return braking


def hand_force(
    inertia: Array, damping: Array, stiffness: Array, stretch: Array, stretch_rate: Array,
    error: Array, error_rate: Array, reach: float, reach_stiffness: float, felt: Array,
) -> Array:  # fmt: skip
    """Everything that shall move the hands' masses: `F + D_m ė + K_m e`, and the wall at the reach.

    Args:
        inertia, damping, stiffness: H_m [kg], D_m [N·s/m], K_m [N/m], shape (3,).
        stretch, stretch_rate: e and ė of the springs, shape (arms, 3) [m], [m/s].
        error, error_rate: Place minus hand, for the wall, shape (arms, 3) [m], [m/s].
        reach: Where the wall is [m].
        reach_stiffness: How stiff [N/m].
        felt: F, shape (arms, 3) [N].

    Returns:
        Shape (arms, 3) [N].
    """
    force = np.empty(stretch.shape)
    _hand_force(
        inertia, damping, stiffness, stretch, stretch_rate, error, error_rate, reach, reach_stiffness, felt,
        force,
    )  # fmt: skip
    return force


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[:,::1], float64[:,::1], float64[:,::1],"
    " float64[:,::1], float64, float64, float64[:,::1], float64[:,::1])"
)
def _hand_force(
    inertia: Array, damping: Array, stiffness: Array, stretch: Array, stretch_rate: Array,
    error: Array, error_rate: Array, reach: float, reach_stiffness: float, felt: Array, force: Array,
) -> None:  # fmt: skip
    """Writes the force of `hand_force`."""
    force[:] = range_force(error, error_rate, reach, reach_stiffness, inertia[0])
    for arm in range(stretch.shape[0]):
        for axis in range(3):
            force[arm, axis] += damping[axis] * stretch_rate[arm, axis]
            force[arm, axis] += stiffness[axis] * stretch[arm, axis] + felt[arm, axis]


def joint_acceleration(
    inertia: Array, jacobian: Array, inverse: Array, null: Array, force: Array,
    velocity_error: Array, posture_error: Array, posture_stiffness: float, posture_damping: float,
    position: Array, velocity: Array, lower: Array, upper: Array, stop_stiffness: float, stop_damping: float,
) -> Array:  # fmt: skip
    """Sum of `impedance_acceleration`, `posture_acceleration` and `stop_avoidance`; arguments as there."""
    total = np.empty(position.shape)
    _joint_acceleration(
        inertia, jacobian, inverse, null, force, velocity_error, posture_error, posture_stiffness,
        posture_damping, position, velocity, lower, upper, stop_stiffness, stop_damping, total,
    )  # fmt: skip
    return total


@kernel(
    "void(float64[::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1], float64[:,::1],"
    " float64[:,::1], float64, float64, float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1],"
    " float64, float64, float64[:,::1])"
)
def _joint_acceleration(
    inertia: Array, jacobian: Array, inverse: Array, null: Array, force: Array,
    velocity_error: Array, posture_error: Array, posture_stiffness: float, posture_damping: float,
    position: Array, velocity: Array, lower: Array, upper: Array, stop_stiffness: float, stop_damping: float,
    total: Array,
) -> None:  # fmt: skip
    """Writes the sum of `joint_acceleration`."""
    total[:] = impedance_acceleration(inertia, jacobian, inverse, force)
    total += posture_acceleration(null, velocity_error, posture_error, posture_stiffness, posture_damping)
    total += stop_avoidance(position, velocity, lower, upper, stop_stiffness, stop_damping)


def joints_within(position: Array, inverse: Array, shift: Array, lower: Array, upper: Array) -> Array:
    """Joint positions that move the hands by `shift`, to first order, kept within their ranges.

    Args:
        position: Now, shape (arms, n) [rad].
        inverse: J⁺, shape (arms, n, 3).
        shift: Shape (arms, 3) [m].
        lower, upper: Shape (arms, n) [rad].

    Returns:
        Shape (arms, n) [rad].
    """
    moved: Array = position.copy()
    _move_within(inverse, shift, lower, upper, moved)
    return moved


@kernel("void(float64[:,:,::1], float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1])")
def _move_within(inverse: Array, shift: Array, lower: Array, upper: Array, moved: Array) -> None:
    """Moves positions as `joints_within` says."""
    arms, joints, size = inverse.shape
    for arm in range(arms):
        for joint in range(joints):
            for axis in range(size):
                moved[arm, joint] += inverse[arm, joint, axis] * shift[arm, axis]
            moved[arm, joint] = min(max(moved[arm, joint], lower[arm, joint]), upper[arm, joint])
