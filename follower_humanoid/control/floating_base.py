"""Feedback linearisation on the floating base: corrected eqs. (14)–(16).

    M q̈ + n = Sᵀ τ + J_footᵀ w + J_handᵀ f,   τ_motor = τ + A q̈ (rotor inertia A on actuated rows only)

The six base rows have no motor. With the ground doing what balance asks for, they give the base
acceleration that goes with the joint accelerations; the actuated rows then give the torques.
"""

from __future__ import annotations

from follower_humanoid.core.samples import Array
from follower_humanoid.robot.linear import solve_positive
from follower_humanoid.robot.model import BASE_DOF


def motor_torque(
    mass_matrix: Array, bias: Array, external: Array, acceleration: Array, rotor_inertia: Array
) -> tuple[Array, Array]:
    """Torques of the motors for desired joint accelerations.

    Args:
        mass_matrix: M, shape (51, 51).
        bias: n = C q̇ + G, shape (51,).
        external: Generalised force of feet and hands, shape (51,).
        acceleration: a of the actuated joints, shape (45,) [rad/s²].
        rotor_inertia: A, shape (45,) [kg·m²].

    Returns:
        (τ + A a, shape (45,) [N·m]; base acceleration, shape (6,)).
    """
    b = slice(0, BASE_DOF)
    a = slice(BASE_DOF, None)
    right = external[b] - bias[b] - mass_matrix[b, a] @ acceleration
    base = solve_positive(mass_matrix[b, b], right)
    torque = mass_matrix[a, b] @ base + mass_matrix[a, a] @ acceleration + bias[a] - external[a]
    return torque + rotor_inertia * acceleration, base
