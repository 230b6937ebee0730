"""Feedback linearisation on the floating base: corrected eqs. (14)–(16).

    M q̈ + n = Sᵀ τ + J_footᵀ w + J_handᵀ f,   τ_motor = τ + A q̈ (rotor inertia A on actuated rows only)

The six base rows have no motor. With the ground doing what balance asks for, they give the base
acceleration that goes with the joint accelerations; the actuated rows then give the torques.
"""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError
from follower_humanoid.robot.model import BASE_DOF


@kernel("void(float64[:,:], float64[::1])")
def _solve_base_rows(mass_matrix: Array, x: Array) -> None:
    """Makes x the solution of `M_bb solution = x`, by `M_bb = Uᵀ U` of its upper triangle."""
    upper = np.zeros((BASE_DOF, BASE_DOF))
    for row in range(BASE_DOF):
        for column in range(row, BASE_DOF):
            rest = mass_matrix[row, column]
            for above in range(row):
                rest -= upper[above, row] * upper[above, column]
            if column > row:
                upper[row, column] = rest / upper[row, row]
            elif rest > 0.0:
                upper[row, row] = math.sqrt(rest)
            else:
                raise PhysicsError("the mass matrix of the base is not positive definite")
    for row in range(BASE_DOF):
        for above in range(row):
            x[row] -= upper[above, row] * x[above]
        x[row] /= upper[row, row]
    for row in range(BASE_DOF - 1, -1, -1):
        for column in range(row + 1, BASE_DOF):
            x[row] -= upper[row, column] * x[column]
        x[row] /= upper[row, row]


@kernel("(float64[:,:], float64[::1], float64[::1], float64[::1], float64[::1])")
def motor_torque(
    mass_matrix: Array, bias: Array, external: Array, acceleration: Array, rotor_inertia: Array
) -> tuple[Array, Array]:
    """Torques of the motors for desired joint accelerations.

    Args:
        mass_matrix: M, shape (51, 51); only its upper triangle is read.
        bias: n = C q̇ + G, shape (51,).
        external: Generalised force of feet and hands, shape (51,).
        acceleration: a of the actuated joints, shape (45,) [rad/s²].
        rotor_inertia: A, shape (45,) [kg·m²].

    Returns:
        (τ + A a, shape (45,) [N·m]; base acceleration, shape (6,)).

    Raises:
        PhysicsError: M is not positive definite.
    """
    forces = bias - external  # becomes M (0, a) + n − external
    for column in range(BASE_DOF, forces.size):
        a = acceleration[column - BASE_DOF]
        forces[column] += mass_matrix[column, column] * a
        for row in range(BASE_DOF):
            forces[row] += mass_matrix[row, column] * a
        for row in range(BASE_DOF, column):
            forces[row] += mass_matrix[row, column] * a
            forces[column] += mass_matrix[row, column] * acceleration[row - BASE_DOF]
    base = -forces[:BASE_DOF]
    _solve_base_rows(mass_matrix, base)
    torque = rotor_inertia * acceleration
    for joint in range(torque.size):
        torque[joint] += forces[BASE_DOF + joint]
        for row in range(BASE_DOF):
            torque[joint] += mass_matrix[row, BASE_DOF + joint] * base[row]
    return torque, base
