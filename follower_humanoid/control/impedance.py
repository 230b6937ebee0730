"""Impedance of the hand, commanded as joint accelerations: corrected eq. (8) and its null-space term.

Sign convention of the package: error = desired − measured, so the paper's q̃ and x̃ are −e here.
Everything works on stacks: leading axes run over arms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.control.null_space import TaskInverse
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


def impedance_acceleration(inertia: Array, jacobian: Array, inverse: TaskInverse, force: Array) -> Array:
    """Joint acceleration by which a force moves the hand as if it had the mass H_m.

    `J⁺ H_m⁻¹ J⁺ᵀ Jᵀ f`, to be added to q̈_d, with f = F + D_m ė + K_m e. Eq. (8) has
    D_m J q̃̇ and K_m J q̃ in the place of D_m ẋ̃ and K_m x̃ of eq. (3): the same to first order, but
    at the 0.1 m a leader pulls, J q̃ is centimetres off, and the vertical stiffness would make that
    a force that nobody applies. So the displacement itself goes in.

    Args:
        inertia: H_m, shape (3,) [kg].
        jacobian: J, shape (..., 3, n).
        inverse: J⁺ of the same Jacobian.
        force: f in the task's axes, shape (..., 3) [N].

    Returns:
        Shape (..., n) [rad/s²].

    Reference: Savić et al. 2016, eq. (8), sign corrected.
    """
    joint_forces = _apply(jacobian.swapaxes(-1, -2), force)
    felt = _apply(inverse.inverse.swapaxes(-1, -2), joint_forces)
    return _apply(inverse.inverse, felt / inertia)


def posture_acceleration(
    inverse: TaskInverse, velocity_error: Array, posture_error: Array, stiffness: float, damping: float
) -> Array:
    """`N (k_d ė + k_p (q_0 − q))`: keeps the self-motion of the arm still and near its posture.

    Args:
        inverse: Null projector of the hand task.
        velocity_error: ė = q̇_d − q̇, shape (..., n) [rad/s].
        posture_error: q_0 − q, shape (..., n) [rad].
        stiffness: k_p [1/s²].
        damping: k_d [1/s].

    Returns:
        Shape (..., n) [rad/s²]; it moves no hand.
    """
    return _apply(inverse.null, damping * velocity_error + stiffness * posture_error)


def range_force(error: Array, error_rate: Array, reach: float, stiffness: float, mass: float) -> Array:
    """Force that keeps a hand within a ball around its place: a soft wall, critically damped outwards.

    Args:
        error: Place minus hand, shape (..., 3) [m].
        error_rate: Shape (..., 3) [m/s].
        reach: Radius of the ball [m].
        stiffness: Of the wall [N/m].
        mass: Of the hand, which sets the damping [kg].

    Returns:
        Shape (..., 3) [N]; zero inside the ball.
    """
    distance = np.sqrt((error * error).sum(axis=-1, keepdims=True))
    inwards = error / np.maximum(distance, reach)
    depth = np.maximum(distance - reach, 0.0)
    leaving = np.maximum((error_rate * inwards).sum(axis=-1, keepdims=True), 0.0)
    damping = np.where(depth > 0.0, 2.0 * np.sqrt(stiffness * mass), 0.0)
    force: Array = (stiffness * depth + damping * leaving) * inwards
    return force


def stop_avoidance(
    position: Array, velocity: Array, lower: Array, upper: Array, stiffness: float, damping: float
) -> Array:
    """Spring and damper that act only beyond `lower` and `upper`, before the hard stops are met.

    The damper brakes motion outwards only: on the way back it would pull into the stop.

    Args:
        position, velocity: Shape (..., n) [rad], [rad/s].
        lower, upper: Where the springs begin, shape (..., n) [rad].
        stiffness: [1/s²].
        damping: [1/s].

    Returns:
        Shape (..., n) [rad/s²].
    """
    below, above = np.maximum(lower - position, 0.0), np.maximum(position - upper, 0.0)
    outwards = np.where(above > 0.0, np.maximum(velocity, 0.0), 0.0)
    outwards += np.where(below > 0.0, np.minimum(velocity, 0.0), 0.0)
    braking: Array = stiffness * (below - above) - damping * outwards
    return braking


def _apply(matrix: Array, vector: Array) -> Array:
    """Matrix times vector for stacks."""
    product: Array = (matrix @ vector[..., None])[..., 0]
    return product
