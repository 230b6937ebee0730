"""Impedance of the hand, commanded as joint accelerations: corrected eq. (8) and its null-space term.

Sign convention of the package: error = desired − measured, so the paper's q̃ and x̃ are −e here.
Everything works on stacks: the first axis runs over arms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
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


@kernel_part
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


@kernel_part
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


@kernel_part
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


@kernel(
    "float64[:,::1](float64[:,::1], float64[::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1],"
    " float64[:,::1], float64[:,::1], float64[:,::1], float64, float64, float64[:,::1], float64[:,::1],"
    " float64[:,::1], float64[:,::1], float64, float64)"
)
def joint_acceleration(
    feedforward: Array, inertia: Array, jacobian: Array, inverse: Array, null: Array, force: Array,
    desired_velocity: Array, posture_error: Array, posture_stiffness: float, posture_damping: float,
    position: Array, velocity: Array, lower: Array, upper: Array, stop_stiffness: float, stop_damping: float,
) -> Array:  # fmt: skip
    """q̈_d + `impedance_acceleration` + `posture_acceleration` + `stop_avoidance`, shape (arms, n) [rad/s²].

    Args:
        feedforward: q̈_d, shape (arms, n) [rad/s²].
        desired_velocity: q̇_d, shape (arms, n) [rad/s].
        others: As there.
    """
    total = impedance_acceleration(inertia, jacobian, inverse, force)
    velocity_error = desired_velocity - velocity
    total += posture_acceleration(null, velocity_error, posture_error, posture_stiffness, posture_damping)
    total += stop_avoidance(position, velocity, lower, upper, stop_stiffness, stop_damping)
    total += feedforward
    return total
