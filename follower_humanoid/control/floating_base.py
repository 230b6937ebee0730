"""Feedback linearisation on the floating base: corrected eqs. (14)–(16).

    M q̈ + n = Sᵀ τ + J_footᵀ w + J_handᵀ f,   τ_motor = τ + A q̈ (rotor inertia A on actuated rows only)

The six base rows have no motor. With the ground doing what balance asks for, they give the base
acceleration that goes with the joint accelerations; the actuated rows then give the torques.
"""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError
from follower_humanoid.robot.model import BASE_DOF, Indices


@kernel_part
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


def motor_torque(
    mass_matrix: Array, bias: Array, external: Array, joints: Indices, acceleration: Array,
    rotor_inertia: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Torques of the motors for desired accelerations of some joints, while the others have none.

    Args:
        mass_matrix: M, shape (51, 51), Fortran order; only its upper triangle is read.
        bias: n = C q̇ + G, shape (51,).
        external: Generalised force of feet and hands, shape (51,).
        joints: Which of the actuated joints, shape (n,).
        acceleration: Their a, shape (n,) [rad/s²].
        rotor_inertia: Their A, shape (n,) [kg·m²].

    Returns:
        (τ + A a, shape (n,) [N·m]; base acceleration, shape (6,)).

    Raises:
        PhysicsError: M is not positive definite.
    """
    torque, base = np.empty(len(joints)), np.empty(BASE_DOF)
    _motor_torque(mass_matrix, bias, external, joints, acceleration, rotor_inertia, torque, base)
    return torque, base


@kernel(
    "void(float64[::1,:], float64[::1], float64[::1], intp[::1], float64[::1], float64[::1], float64[::1],"
    " float64[::1])"
)
def _motor_torque(
    mass_matrix: Array, bias: Array, external: Array, joints: Indices, acceleration: Array,
    rotor_inertia: Array, torque: Array, base: Array,
) -> None:  # fmt: skip
    """Writes what `motor_torque` returns."""
    forces = bias - external  # becomes M (0, a) + n − external, in the rows that are used
    for n in range(joints.size):
        column, a = BASE_DOF + joints[n], acceleration[n]
        forces[column] += mass_matrix[column, column] * a
        for row in range(BASE_DOF):
            forces[row] += mass_matrix[row, column] * a
        for before in range(n):
            row = BASE_DOF + joints[before]
            shared = mass_matrix[min(row, column), max(row, column)]
            forces[row] += shared * a
            forces[column] += shared * acceleration[before]
    for row in range(BASE_DOF):
        base[row] = -forces[row]
    _solve_base_rows(mass_matrix, base)
    for n in range(joints.size):
        column = BASE_DOF + joints[n]
        torque[n] = rotor_inertia[n] * acceleration[n] + forces[column]
        for row in range(BASE_DOF):
            torque[n] += mass_matrix[row, column] * base[row]
