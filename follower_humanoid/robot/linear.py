"""Small linear systems, straight through LAPACK: the general solvers' checks cost more than the solution."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dposv

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError


def solve_positive(matrix: Array, right: Array) -> Array:
    """x with `matrix @ x = right` for a symmetric positive definite matrix, by Cholesky.

    Args:
        matrix: Shape (n, n); only its upper triangle is read.
        right: Shape (n,).

    Raises:
        PhysicsError: The matrix is not positive definite.
    """
    _, solution, info = dposv(matrix, right)
    if info != 0:
        raise PhysicsError(
            f"a matrix of {len(right)} rows that must be positive definite is not (row {info})"
        )
    return np.asarray(solution)
