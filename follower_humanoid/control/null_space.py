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
