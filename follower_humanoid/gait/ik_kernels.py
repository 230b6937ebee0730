"""Inner loops of the differential IK: what each task asks for, and the velocities that do it.

Poses are given as in `robot.pose_table`: rows 0 to 2 the axes of a frame in world, row 3 its origin.
"""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError
from follower_humanoid.robot.model import BASE_DOF, Indices

TASKS = 18  # equations, and unknowns


@kernel("Tuple((float64, float64, float64))(float64[:,:], float64[:,::1])")
def turn_to(wanted: Array, now: Array) -> tuple[float, float, float]:
    """log(R_d Rᵀ): the rotation vector in world from an attitude to a wanted one [rad].

    sin θ·u = ½ Σ a_i × d_i and 1 + 2 cos θ = Σ a_i·d_i over the axes a_i of R and d_i of R_d. At a half
    turn, where no direction is better than the other, the answer is of no use and its length at most π.

    Args:
        wanted: Rotation to world R_d, shape (3, 3).
        now: Axes of R (and more), shape (≥ 3, 3).
    """
    x = y = z = trace = 0.0
    for i in range(3):
        x += 0.5 * (now[i, 1] * wanted[2, i] - now[i, 2] * wanted[1, i])
        y += 0.5 * (now[i, 2] * wanted[0, i] - now[i, 0] * wanted[2, i])
        z += 0.5 * (now[i, 0] * wanted[1, i] - now[i, 1] * wanted[0, i])
        trace += now[i, 0] * wanted[0, i] + now[i, 1] * wanted[1, i] + now[i, 2] * wanted[2, i]
    sine = math.sqrt(x * x + y * y + z * z)
    # θ/sin θ is 1 to rounding for small turns.
    scale = math.atan2(sine, 0.5 * (trace - 1.0)) / sine if sine > 1e-9 else 1.0
    return scale * x, scale * y, scale * z


@kernel_part
def foot_rates(
    position: Array, rotation: Array, linear: Array, angular: Array,
    now: Array, gain: float, fastest: float, rates: Array,
) -> None:  # fmt: skip
    """Twist of a sole in world: ẋ_d + clip(k (x_d − x)) and ω_d + k log(R_d Rᵀ).

    Args:
        position, rotation, linear, angular: Desired motion, see `FootTask`.
        now: Sole of the reference, shape (4, 3).
        gain: k [1/s].
        fastest: Largest correction speed per axis [m/s].
        rates: Written to, shape (6,).
    """
    turn = turn_to(rotation, now)
    for i in range(3):
        pull = gain * (position[i] - now[3, i])
        rates[i] = linear[i] + min(max(pull, -fastest), fastest)
        rates[3 + i] = angular[i] + gain * turn[i]


@kernel_part
def body_rates(
    com: Array, com_velocity: Array, height: float, height_velocity: float, rotation: Array, angular: Array,
    com_now: Array, now: Array, com_gain: float, pelvis_gain: float, rates: Array,
) -> None:  # fmt: skip
    """Velocities of CoM (x, y), pelvis height and pelvis attitude: desired ones plus gain times error.

    Args:
        com, com_velocity, height, height_velocity, rotation, angular: Desired motion, see `BodyTask`.
        com_now: CoM of the reference, shape (3,) [m].
        now: `base_link` of the reference, shape (4, 3).
        com_gain, pelvis_gain: [1/s].
        rates: Written to, shape (6,).
    """
    for i in range(2):
        rates[i] = com_velocity[i] + com_gain * (com[i] - com_now[i])
    rates[2] = height_velocity + pelvis_gain * (height - now[3, 2])
    turn = turn_to(rotation, now)
    for i in range(3):
        rates[3 + i] = angular[i] + pelvis_gain * turn[i]


@kernel(
    "void(float64[::1], float64[:,:], float64[::1], float64[::1],"
    " float64[::1], float64[:,:], float64[::1], float64[::1],"
    " float64[::1], float64[::1], float64, float64, float64[:,:], float64[::1],"
    " float64[:,::1], float64[:,::1], float64[::1], float64[:,::1],"
    " float64, float64, float64, float64, float64[::1])"
)
def task_rates(
    left_position: Array, left_rotation: Array, left_linear: Array, left_angular: Array,
    right_position: Array, right_rotation: Array, right_linear: Array, right_angular: Array,
    com: Array, com_velocity: Array, height: float, height_velocity: float, rotation: Array, angular: Array,
    left_now: Array, right_now: Array, com_now: Array, base_now: Array,
    foot_gain: float, fastest: float, com_gain: float, pelvis_gain: float, rates: Array,
) -> None:  # fmt: skip
    """Writes the rates of all tasks, shape (18,): left sole, right sole, then CoM and pelvis.

    Arguments as in `foot_rates` and `body_rates`, in the order of `FootTask` and `BodyTask`.
    """
    foot_rates(
        left_position, left_rotation, left_linear, left_angular, left_now, foot_gain, fastest, rates[:6]
    )
    foot_rates(
        right_position, right_rotation, right_linear, right_angular, right_now, foot_gain, fastest,
        rates[6:12],
    )  # fmt: skip
    body_rates(
        com, com_velocity, height, height_velocity, rotation, angular, com_now, base_now,
        com_gain, pelvis_gain, rates[12:],
    )  # fmt: skip


@kernel_part
def add_sole(
    jacobian: Array, origin: Array, moving: Indices, number: Indices,
    v: Array, row: int, columns: Array, rates: Array,
) -> None:  # fmt: skip
    """Six equations for the twist of a sole, in axes of world at its origin: ẋ = ẋ_0 + ω × x.

    Args:
        jacobian: Joint twists in world at its origin, linear over angular, shape (6, 51).
        origin: Of the sole, shape (3,) [m].
        moving: Indices into v of what moves the sole.
        number: Number of each entry of v among the unknowns, −1 for what is given, shape (51,).
        v: Given velocities, shape (51,).
        row: First equation.
        columns: Effect of each unknown on each equation, shape (18, 18), written to.
        rates: Right-hand side, less what the given velocities do.
    """
    for joint in moving:
        wx, wy, wz = jacobian[3, joint], jacobian[4, joint], jacobian[5, joint]
        x = jacobian[0, joint] + wy * origin[2] - wz * origin[1]
        y = jacobian[1, joint] + wz * origin[0] - wx * origin[2]
        z = jacobian[2, joint] + wx * origin[1] - wy * origin[0]
        for i, effect in enumerate((x, y, z, wx, wy, wz)):
            if number[joint] >= 0:
                columns[number[joint], row + i] = effect
            else:
                rates[row + i] -= effect * v[joint]


@kernel_part
def damped_normal(columns: Array, damping: float) -> Array:
    """J Jᵀ + λ²I, its lower triangle; many entries of J are zero.

    Args:
        columns: Columns of J as rows, shape (unknowns, equations).
        damping: λ.
    """
    size = columns.shape[1]
    normal = np.zeros((size, size))
    for column in columns:
        for i in range(size):
            if column[i] != 0.0:
                for j in range(i + 1):
                    normal[i, j] += column[i] * column[j]
    for i in range(size):
        normal[i, i] += damping * damping
    return normal


@kernel_part
def solve_cholesky(matrix: Array, x: Array) -> None:
    """x with `matrix @ x = r` for a positive definite matrix, by Cholesky; overwrites both.

    Args:
        matrix: Shape (n, n); its lower triangle becomes the factor.
        x: r, shape (n,), becomes the solution.
    """
    size = len(x)
    for i in range(size):
        for j in range(i):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
            matrix[i, i] -= matrix[i, j] * matrix[i, j]
            x[i] -= matrix[i, j] * x[j]
        if not matrix[i, i] > 0.0:
            raise PhysicsError("the differential IK was asked for something that is not a number")
        matrix[i, i] = math.sqrt(matrix[i, i])
        x[i] /= matrix[i, i]
    for i in range(size - 1, -1, -1):
        x[i] /= matrix[i, i]
        for j in range(i):
            x[j] -= matrix[i, j] * x[i]


@kernel(
    "void(float64[::1,:], float64[::1,:], float64, float64[:,::1], float64[:,::1], float64[:,::1],"
    " int64[::1], int64[::1], int64[::1], float64[::1], float64[::1], float64, float64[::1])"
)
def solve_velocities(
    jacobian: Array, momentum_matrix: Array, mass: float, left: Array, right: Array, base: Array,
    left_joints: Indices, right_joints: Indices, unknowns: Indices, given: Array, rates: Array,
    damping: float, v: Array,
) -> None:  # fmt: skip
    """Writes q̇ = Jᵀ(JJᵀ + λ²I)⁻¹ r for the unknowns, the other velocities as given.

    Args:
        jacobian: Joint twists in world at its origin, linear over angular, shape (6, 51).
        momentum_matrix: Centroidal momentum matrix, linear over angular, shape (6, 51): its linear rows are
            m times the Jacobian of the CoM.
        mass: m [kg].
        left, right, base: Soles and `base_link`, shape (4, 3).
        left_joints, right_joints: Indices into v of what moves each sole.
        unknowns: Indices into v: base first, shape (18,).
        given: Velocities of all joints, shape (45,) [rad/s].
        rates: Rates r of left and right sole, CoM and pelvis, shape (18,).
        damping: λ.
        v: Written, shape (51,).
    """
    v[BASE_DOF:] = given
    number = np.full(len(v), -1)
    for n in range(TASKS):
        number[unknowns[n]] = n
        v[unknowns[n]] = 0.0
    columns = np.zeros((TASKS, TASKS))
    rest = rates.copy()
    add_sole(jacobian, left[3], left_joints, number, v, 0, columns, rest)
    add_sole(jacobian, right[3], right_joints, number, v, 6, columns, rest)
    for joint in range(len(v)):
        for i in range(2):
            effect = momentum_matrix[i, joint] / mass
            if number[joint] >= 0:
                columns[number[joint], 12 + i] = effect
            else:
                rest[12 + i] -= effect * v[joint]
    # The twist of the base is in base_link axes.
    for axis in range(3):
        columns[axis, 14] = base[axis, 2]
        for i in range(3):
            columns[3 + axis, 15 + i] = base[axis, i]
    solve_cholesky(damped_normal(columns, damping), rest)
    for n in range(TASKS):
        total = 0.0
        for i in range(TASKS):
            total += columns[n, i] * rest[i]
        v[unknowns[n]] = total
