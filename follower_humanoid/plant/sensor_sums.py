"""What the sensors gather from one physics step, compiled.

Poses are given as in `robot.pose_table`: rows 0 to 2 the axes of a frame in world, row 3 its origin.
"""

from __future__ import annotations

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import Indices


@kernel_part
def mean_acceleration(
    v_before: Array, v: Array, base_before: Array, base: Array, rotation: Array, gravity: Array, step: float,
    acceleration: Array, specific_force: Array,
) -> None:  # fmt: skip
    """Writes the mean of v̇ over a step, in the base's axes at its beginning; adds specific force.

    v̇ = (Rᵀ ẍ − ω × v,  Rᵀ Δω/h,  Δq̇/h), specific force Rᵀ (ẍ − g), with ẍ = Δẋ/h: what the body really
    did, Bullet's own contacts included.

    Args:
        v_before, v: Velocity vector at beginning and end, (51,).
        base_before, base: ẋ and ω of base_link in world, at beginning and end, (2, 3).
        rotation: R at the beginning, (3, 3).
        gravity: g in world, (3,).
        step: h.
        acceleration: Written, (51,).
        specific_force: Changed, (3,).
    """
    for n in range(6, v.shape[0]):
        acceleration[n] = (v[n] - v_before[n]) / step
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        linear = angular = 0.0
        for row in range(3):
            linear += rotation[row, axis] * (base[0, row] - base_before[0, row]) / step
            angular += rotation[row, axis] * (base[1, row] - base_before[1, row]) / step
        turning = v_before[3 + after] * v_before[last] - v_before[3 + last] * v_before[after]
        acceleration[axis], acceleration[3 + axis] = linear - turning, angular
        specific_force[axis] += linear
        for row in range(3):
            specific_force[axis] -= rotation[row, axis] * gravity[row]


@kernel_part
def add_joint_force(
    pose: Array, twists: Array, columns: Indices, acceleration: Array, bias: Array,
    mass: float, lever: Array, inertia: Array, total: Array,
) -> None:  # fmt: skip
    """Adds what a last link does to the joint that carries it: −(I J v̇ + f).

    With a, α the linear and angular part of J v̇ at the joint: (m (a + α × c), I_c α + c × first).

    Args:
        pose: Of the joint in world, (4, 3).
        twists: World Jacobian, (6, ≥ columns).
        columns: Those that move the joint.
        acceleration: v̇, (≥ columns,).
        bias: f: force through the joint, in its frame, that the link needs at v̇ = 0, (6,).
        mass, lever, inertia: m, c and I_c of the link, in the joint's frame.
        total: Changed, at and in the joint's frame, (6,).
    """
    ax = ay = az = turn_x = turn_y = turn_z = 0.0
    for column in columns:
        rate = acceleration[column]
        ax += twists[0, column] * rate
        ay += twists[1, column] * rate
        az += twists[2, column] * rate
        turn_x += twists[3, column] * rate
        turn_y += twists[4, column] * rate
        turn_z += twists[5, column] * rate
    # From the world's origin to the joint, then into its axes.
    ax += turn_y * pose[3, 2] - turn_z * pose[3, 1]
    ay += turn_z * pose[3, 0] - turn_x * pose[3, 2]
    az += turn_x * pose[3, 1] - turn_y * pose[3, 0]
    px = pose[0, 0] * turn_x + pose[0, 1] * turn_y + pose[0, 2] * turn_z
    py = pose[1, 0] * turn_x + pose[1, 1] * turn_y + pose[1, 2] * turn_z
    pz = pose[2, 0] * turn_x + pose[2, 1] * turn_y + pose[2, 2] * turn_z
    cx, cy, cz = lever[0], lever[1], lever[2]
    fx = mass * (pose[0, 0] * ax + pose[0, 1] * ay + pose[0, 2] * az + py * cz - pz * cy)
    fy = mass * (pose[1, 0] * ax + pose[1, 1] * ay + pose[1, 2] * az + pz * cx - px * cz)
    fz = mass * (pose[2, 0] * ax + pose[2, 1] * ay + pose[2, 2] * az + px * cy - py * cx)
    total[0] -= fx + bias[0]
    total[1] -= fy + bias[1]
    total[2] -= fz + bias[2]
    total[3] -= inertia[0, 0] * px + inertia[0, 1] * py + inertia[0, 2] * pz + cy * fz - cz * fy + bias[3]
    total[4] -= inertia[1, 0] * px + inertia[1, 1] * py + inertia[1, 2] * pz + cz * fx - cx * fz + bias[4]
    total[5] -= inertia[2, 0] * px + inertia[2, 1] * py + inertia[2, 2] * pz + cx * fy - cy * fx + bias[5]


@kernel(
    "void(float64[::1], float64[::1], float64[:,::1], float64[:,::1], float64[:,::1], float64[::1], float64, "
    "float64[:,:,::1], float64[::1,:], int64[::1], int64[:,::1], float64[::1], float64[::1], float64[::1], "
    "float64[:,::1], float64[:,:,::1], float64[::1], float64[::1], float64[:,::1])"
)
def add_step(
    v_before: Array, v: Array, base_before: Array, base: Array, rotation: Array, gravity: Array, step: float,
    poses: Array, twists: Array, joints: Indices, columns: Indices, left_bias: Array, right_bias: Array,
    masses: Array, levers: Array, inertias: Array,
    acceleration: Array, specific_force: Array, wrists: Array,
) -> None:  # fmt: skip
    """Adds what IMU and wrists feel during one physics step: `mean_acceleration`, then `add_joint_force`.

    Args:
        v_before, v, base_before, base, rotation, gravity, step: As there.
        poses: Of all joints in world, (≥ 1, 4, 3).
        twists: World Jacobian, (6, ≥ columns).
        joints, columns: The joint that carries each hand, (2,), and what moves it, (2, columns).
        left_bias, right_bias: Force through either joint at v̇ = 0, (6,).
        masses, levers, inertias: Of the hands, (2,), (2, 3), (2, 3, 3).
        acceleration: Written, (51,).
        specific_force: Changed, (3,).
        wrists: Changed, (2, 6).
    """
    mean_acceleration(
        v_before, v, base_before, base, rotation, gravity, step, acceleration, specific_force
    )
    for hand in range(2):
        add_joint_force(
            poses[joints[hand]], twists, columns[hand], acceleration, left_bias if hand == 0 else right_bias,
            masses[hand], levers[hand], inertias[hand], wrists[hand],
        )  # fmt: skip


@kernel_part
def seen_from(
    pose: Array, axes: Array, offset: Array, total: Array, count: float, force: Array, torque: Array
) -> None:
    """Writes the mean of wrenches about the world's origin, at and in a frame fixed to a joint.

    Args:
        pose: Of the joint in world, (4, 3).
        axes, offset: Rotation and origin of the frame in the joint's, (3, 3) and (3,).
        total: Sum of the wrenches in world, (6,).
        count: How many.
        force, torque: Written, (3,).
    """
    x = pose[3, 0] + pose[0, 0] * offset[0] + pose[1, 0] * offset[1] + pose[2, 0] * offset[2]
    y = pose[3, 1] + pose[0, 1] * offset[0] + pose[1, 1] * offset[1] + pose[2, 1] * offset[2]
    z = pose[3, 2] + pose[0, 2] * offset[0] + pose[1, 2] * offset[1] + pose[2, 2] * offset[2]
    fx, fy, fz = total[0] / count, total[1] / count, total[2] / count
    mx = total[3] / count - (y * fz - z * fy)
    my = total[4] / count - (z * fx - x * fz)
    mz = total[5] / count - (x * fy - y * fx)
    for axis in range(3):
        # The frame's axis in world.
        ax = pose[0, 0] * axes[0, axis] + pose[1, 0] * axes[1, axis] + pose[2, 0] * axes[2, axis]
        ay = pose[0, 1] * axes[0, axis] + pose[1, 1] * axes[1, axis] + pose[2, 1] * axes[2, axis]
        az = pose[0, 2] * axes[0, axis] + pose[1, 2] * axes[1, axis] + pose[2, 2] * axes[2, axis]
        force[axis] = ax * fx + ay * fy + az * fz
        torque[axis] = ax * mx + ay * my + az * mz


@kernel(
    "void(float64[:,:,::1], int64[::1], float64[:,:,::1], float64[:,::1], float64[:,::1], float64[:,::1], "
    "float64, float64[:,:,::1])"
)
def mean_wrenches(
    poses: Array, joints: Indices, axes: Array, offsets: Array, feet: Array, wrists: Array, count: float,
    means: Array,
) -> None:  # fmt: skip
    """Writes what the force sensors show: feet as in `seen_from`, wrists as they were summed.

    Args:
        poses: Of all joints in world, (≥ 1, 4, 3).
        joints, axes, offsets: Of the soles: joint that carries each, and its frame in the joint's, (2,),
            (2, 3, 3) and (2, 3).
        feet: Sums of the wrenches on the feet about the world's origin, in world, (2, 6).
        wrists: Sums at and in the wrists' joints, (2, 6).
        count: How many steps they are sums of.
        means: Written: forces, then torques of left and right foot, left and right wrist, (2, 4, 3).
    """
    for foot in range(2):
        seen_from(
            poses[joints[foot]], axes[foot], offsets[foot], feet[foot], count, means[0, foot], means[1, foot]
        )
        for n in range(6):
            means[n // 3, 2 + foot, n % 3] = wrists[foot, n] / count
