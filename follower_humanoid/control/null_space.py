"""Inverse of a task Jacobian that stays bounded near singularities, with its null-space projector.

Everything works on stacks: leading axes run over arms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from follower_humanoid.core.samples import Array


class TaskInverse(NamedTuple):
    """How joint motion answers a task, and what is left over.

    Attributes:
        inverse: J⁺, shape (..., n, m).
        null: N = I − J⁺J, shape (..., n, n).
    """

    inverse: Array
    null: Array


def task_inverse(jacobian: Array, threshold: float, damping: float) -> TaskInverse:
    """Right pseudo-inverse, damped only along directions that are close to singular.

    `J⁺ = Σ_i σ_i/(σ_i² + λ_i²) v_i u_iᵀ`, `λ_i² = λ² max(0, 1 − (σ_i/ε)²)`: away from singularities
    this is `Jᵀ(JJᵀ)⁻¹` and N is an orthogonal projector with `J N = 0`; where a direction is lost,
    its joint motion passes gradually from the task to the null space, so nothing is left unheld.

    Args:
        jacobian: J, shape (..., m, n) with m ≤ n.
        threshold: ε, singular value below which damping sets in.
        damping: λ, its amount at the singularity; gain is then at most 1/(2λ).

    Reference: Savić et al. 2016, eq. (6); damping as in Nakamura and Hanafusa 1986.
    """
    left, sigma, right = np.linalg.svd(jacobian, full_matrices=False)
    squared = sigma * sigma
    damped = squared + damping**2 * np.maximum(0.0, 1.0 - squared / threshold**2)
    columns = right.swapaxes(-1, -2) * (sigma / damped)[..., None, :]
    inverse = columns @ left.swapaxes(-1, -2)
    null: Array = inverse @ jacobian
    np.subtract(np.eye(jacobian.shape[-1]), null, out=null)
    return TaskInverse(inverse, null)


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
        task_velocity: v_ref, shape (..., m) [m/s].
        null_velocity: q̇_h, shape (..., n) [rad/s].

    Returns:
        Shape (..., n) [rad/s].

    Reference: Savić et al. 2016, eq. (6).
    """
    task, null = task_velocity[..., None], null_velocity[..., None]
    desired: Array = (inverse.inverse @ task + inverse.null @ null)[..., 0]
    return desired
