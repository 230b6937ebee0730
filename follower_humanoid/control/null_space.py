"""Inverse of a task Jacobian that stays bounded near singularities, with its null-space projector.

Everything works on stacks: the first axis runs over arms.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array

# Each sweep squares what is left off the diagonal; a 3 × 3 matrix is diagonal to rounding after five.
_SWEEPS = 10


class TaskInverse(NamedTuple):
    """How joint motion answers a task, and what is left over.

    Attributes:
        inverse: J⁺, shape (arms, n, m).
        null: N = I − J⁺J, shape (arms, n, n).
    """

    inverse: Array
    null: Array


@kernel_part
def _diagonalise(matrix: Array, vectors: Array) -> None:
    """Turns a symmetric matrix into its eigenvalues and `vectors` into its eigenvectors (columns).

    Cyclic Jacobi rotations, each of which makes one pair of off-diagonal entries zero.
    """
    size = matrix.shape[0]
    for row in range(size):
        vectors[row] = 0.0
        vectors[row, row] = 1.0
    for _ in range(_SWEEPS):
        turned = False
        for p in range(size - 1):
            for q in range(p + 1, size):
                if abs(matrix[p, q]) <= 1e-18 * (abs(matrix[p, p]) + abs(matrix[q, q])):
                    continue
                turned = True
                theta = 0.5 * (matrix[q, q] - matrix[p, p]) / matrix[p, q]
                tangent = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
                cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
                sine = tangent * cosine
                for row in range(size):
                    one, other = matrix[row, p], matrix[row, q]
                    matrix[row, p], matrix[row, q] = cosine * one - sine * other, sine * one + cosine * other
                for row in range(size):
                    one, other = matrix[p, row], matrix[q, row]
                    matrix[p, row], matrix[q, row] = cosine * one - sine * other, sine * one + cosine * other
                    one, other = vectors[row, p], vectors[row, q]
                    vectors[row, p] = cosine * one - sine * other
                    vectors[row, q] = sine * one + cosine * other
                matrix[p, q] = matrix[q, p] = 0.0
        if not turned:
            break


@kernel_part
def _damped_square(
    jacobian: Array, threshold: float, damping: float, squared: Array, left: Array, inverse: Array
) -> None:
    """Writes `Σ_i u_i u_iᵀ/(σ_i² + λ_i²)` of `task_inverse` into `inverse`; all of shape (m, m)."""
    size = jacobian.shape[0]
    for row in range(size):
        for column in range(size):
            squared[row, column] = inverse[row, column] = 0.0
            for joint in range(jacobian.shape[1]):
                squared[row, column] += jacobian[row, joint] * jacobian[column, joint]
    _diagonalise(squared, left)
    for n in range(size):
        sigma_squared = max(squared[n, n], 0.0)
        damped = sigma_squared + damping**2 * max(0.0, 1.0 - sigma_squared / threshold**2)
        for row in range(size):
            for column in range(size):
                inverse[row, column] += left[row, n] * left[column, n] / damped


def task_inverse(jacobian: Array, threshold: float, damping: float) -> TaskInverse:
    """Right pseudo-inverse, damped only along directions that are close to singular.

    `J⁺ = Σ_i σ_i/(σ_i² + λ_i²) v_i u_iᵀ = Jᵀ Σ_i u_i u_iᵀ/(σ_i² + λ_i²)`, with
    `λ_i² = λ² max(0, 1 − (σ_i/ε)²)` and u_i, σ_i² from `J Jᵀ`: away from singularities this is
    `Jᵀ(JJᵀ)⁻¹` and N is an orthogonal projector with `J N = 0`; where a direction is lost, its
    joint motion passes gradually from the task to the null space, so nothing is left unheld.

    Args:
        jacobian: J, shape (arms, m, n) with m ≤ n.
        threshold: ε, singular value below which damping sets in.
        damping: λ, its amount at the singularity. The largest gain, of σ/(σ² + λ²(1 − σ²/ε²)), is
            1/(2λ √(1 − λ²/ε²)) where λ ≤ ε/√2, and 1/ε beyond, where the gain only grows up to σ = ε.

    Reference: Savić et al. 2016, eq. (6); damping as in Nakamura and Hanafusa 1986.
    """
    arms, size, joints = jacobian.shape
    inverse, null = np.zeros((arms, joints, size)), np.zeros((arms, joints, joints))
    _invert(jacobian, threshold, damping, inverse, null)
    return TaskInverse(inverse, null)


@kernel("void(float64[:,:,::1], float64, float64, float64[:,:,::1], float64[:,:,::1])")
def _invert(jacobian: Array, threshold: float, damping: float, inverse: Array, null: Array) -> None:
    """Writes J⁺ and N of `task_inverse` into zeros of their shapes."""
    arms, size, joints = jacobian.shape
    squared, left, square = np.empty((size, size)), np.empty((size, size)), np.empty((size, size))
    for arm in range(arms):
        _damped_square(jacobian[arm], threshold, damping, squared, left, square)
        for joint in range(joints):
            null[arm, joint, joint] = 1.0
            for axis in range(size):
                for row in range(size):
                    inverse[arm, joint, axis] += jacobian[arm, row, joint] * square[row, axis]
                for other in range(joints):
                    null[arm, joint, other] -= inverse[arm, joint, axis] * jacobian[arm, axis, other]


def limit_avoidance(position: Array, lower: Array, upper: Array, gain: float) -> Array:
    """Joint velocity away from the ends of the ranges, for the null space of eq. (6).

    Gradient of `ω = −1/(2n) Σ ((q_i − q̄_i)/(q_i,max − q_i,min))²`, times k_0:
    `q̇_h,i = −(k_0/n) (q_i − q̄_i)/(q_i,max − q_i,min)²`, q̄ in the middle of the range.

    Args:
        position: q, shape (..., n) [rad].
        lower, upper: Ends of the ranges, shape (..., n) [rad].
        gain: k_0 [rad²/s].

    Returns:
        q̇_h, shape (..., n) [rad/s].

    Reference: Savić et al. 2016, eq. (7), with the square that ω needs.
    """
    width = upper - lower
    velocity: Array = (-gain / position.shape[-1]) * (position - 0.5 * (lower + upper)) / width**2
    return velocity


def joint_velocity(inverse: TaskInverse, task_velocity: Array, null_velocity: Array) -> Array:
    """`q̇_d = J⁺ v_ref + (I − J⁺J) q̇_h`.

    Args:
        inverse: J⁺ and its null projector.
        task_velocity: v_ref, shape (arms, m) [m/s].
        null_velocity: q̇_h, shape (arms, n) [rad/s].

    Returns:
        Shape (arms, n) [rad/s].

    Reference: Savić et al. 2016, eq. (6).
    """
    motion = np.zeros(null_velocity.shape)
    _add_task_and_rest(inverse.inverse, inverse.null, task_velocity, null_velocity, motion)
    return motion


@kernel("void(float64[:,:,::1], float64[:,:,::1], float64[:,::1], float64[:,::1], float64[:,::1])")
def _add_task_and_rest(inverse: Array, null: Array, task: Array, rest: Array, motion: Array) -> None:
    """Adds `J⁺ x + N y` per arm, shape (arms, n)."""
    arms, joints, size = inverse.shape
    for arm in range(arms):
        for joint in range(joints):
            for axis in range(size):
                motion[arm, joint] += inverse[arm, joint, axis] * task[arm, axis]
            for other in range(joints):
                motion[arm, joint] += null[arm, joint, other] * rest[arm, other]


class JointReference(NamedTuple):
    """What the arms' joints shall do for a task.

    Attributes:
        position: q_d, shape (arms, n) [rad].
        velocity: q̇_d, shape (arms, n) [rad/s].
    """

    position: Array
    velocity: Array


def joint_reference(
    jacobian: Array, threshold: float, damping: float, position: Array, lower: Array, upper: Array,
    shift: Array, task_velocity: Array, null_velocity: Array, inverse: TaskInverse,
) -> JointReference:  # fmt: skip
    """`task_inverse`, written into `inverse`, and with it `joint_velocity` and how far the joints go.

    Args:
        jacobian, threshold, damping: As for `task_inverse`.
        position: q, shape (arms, n) [rad].
        lower, upper: Ranges within which q_d is kept, shape (arms, n) [rad].
        shift: By which q_d moves the hands, to first order, shape (arms, m) [m].
        task_velocity, null_velocity: As for `joint_velocity`.
        inverse: J⁺ and its null projector, written to.
    """
    reference = JointReference(np.empty(position.shape), np.empty(position.shape))
    _joint_reference(
        jacobian, threshold, damping, position, lower, upper, shift, task_velocity, null_velocity,
        *inverse, *reference,
    )  # fmt: skip
    return reference


@kernel(
    "void(float64[:,:,::1], float64, float64, float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1],"
    " float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1], float64[:,::1])"
)
def _joint_reference(
    jacobian: Array, threshold: float, damping: float, position: Array, lower: Array, upper: Array,
    shift: Array, task_velocity: Array, null_velocity: Array,
    inverse: Array, null: Array, moved: Array, motion: Array,
) -> None:  # fmt: skip
    """Writes J⁺, N, q_d and q̇_d of `joint_reference`."""
    inverse[:] = null[:] = motion[:] = 0.0
    _invert(jacobian, threshold, damping, inverse, null)
    _add_task_and_rest(inverse, null, task_velocity, null_velocity, motion)
    arms, joints, size = inverse.shape
    for arm in range(arms):
        for joint in range(joints):
            moved[arm, joint] = position[arm, joint]
            for axis in range(size):
                moved[arm, joint] += inverse[arm, joint, axis] * shift[arm, axis]
            moved[arm, joint] = min(max(moved[arm, joint], lower[arm, joint]), upper[arm, joint])
