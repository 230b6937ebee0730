"""The arithmetic of the soles, compiled: what `Soles` does with its points in one physics step.

Rows of all arrays are contact points. Of a point below ground, with the letters of eq. (11) in `soles`:

    rate    ẋ = J q̇
    trial   force at q̈ = 0 if the point presses and sticks: −k (x + h ẋ − x_a) − d ẋ
    slip    μ f_n along the spring: the friction of a point that presses and does not stick
    start   what of trial and slip acts
    change  J q̈
    force   start − c change, c on the axes that press or stick, else 0
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import Indices

Flags = NDArray[np.bool_]

# How far friction may be from the cone (share, and [N]) before a step is solved again.
CONE_SHARE, CONE_FORCE = 0.01, 0.2

# Height of the ground in world [m]: the plane that `world.Ground` describes.
GROUND = 0.0


@kernel("void(float64[:,:,::1], int64[::1], float64[:,::1], float64[:,::1])")
def place(poses: Array, joints: Indices, local: Array, points: Array) -> None:
    """Writes the points in world: x = p + R x_local.

    Args:
        poses: Of the joints in world, see `robot.pose_table`, (≥ 1, 4, 3).
        joints: Which one carries each point, (n,).
        local: Points in the joint's frame, (n, 3).
        points: Written, (n, 3).
    """
    for n in range(points.shape[0]):
        pose = poses[joints[n]]
        for axis in range(3):
            points[n, axis] = pose[3, axis] + (
                pose[0, axis] * local[n, 0] + pose[1, axis] * local[n, 1] + pose[2, axis] * local[n, 2]
            )


@kernel_part
def point_jacobian(point: Array, twists: Array, carried: Flags, jacobian: Array) -> None:
    """Writes the velocity of a point per velocity of each column: v + ω × x of the column's twist.

    Args:
        point: In world, (3,).
        twists: World Jacobian: twists at the world's origin, (6, ≥ columns).
        carried: True where a column moves the point, (columns,).
        jacobian: Written where carried, (3, columns).
    """
    x, y, z = point[0], point[1], point[2]
    for column in range(carried.shape[0]):
        if carried[column]:
            turn_x, turn_y, turn_z = twists[3, column], twists[4, column], twists[5, column]
            jacobian[0, column] = twists[0, column] + (turn_y * z - turn_z * y)
            jacobian[1, column] = twists[1, column] + (turn_z * x - turn_x * z)
            jacobian[2, column] = twists[2, column] + (turn_x * y - turn_y * x)


@kernel("void(float64[:,::1], float64[::1], float64[::1])")
def along(jacobian: Array, values: Array, product: Array) -> None:
    """Writes J x, (3,), for J of shape (3, columns) and x of shape (≥ columns,)."""
    for axis in range(3):
        total = 0.0
        for column in range(jacobian.shape[1]):
            total += jacobian[axis, column] * values[column]
        product[axis] = total


@kernel_part
def slide(friction: float, normal: float, spring_x: float, spring_y: float, slip: Array) -> None:
    """Writes the friction of a slipping point, (2,): μ f_n along its spring."""
    length = max(math.sqrt(spring_x * spring_x + spring_y * spring_y), 1e-12)
    share = friction * max(normal, 0.0) / length
    slip[0], slip[1] = spring_x * share, spring_y * share


@kernel(
    "boolean(float64[:,:,::1], int64[::1], float64[:,::1], float64[::1,:], boolean[:,::1], float64[::1], "
    "float64, float64, float64, float64[:,::1], boolean[::1], float64[:,::1], float64[:,:,::1], "
    "float64[:,::1], float64[:,::1], float64[:,::1], boolean[::1], boolean[::1])"
)
def begin(
    poses: Array, joints: Indices, local: Array, twists: Array, carries: Flags, velocity: Array,
    stiffness: float, loss: float, friction: float, points: Array, below: Flags, anchor: Array,
    jacobian: Array, rate: Array, trial: Array, slip: Array, pressing: Flags, sticking: Flags,
) -> bool:  # fmt: skip
    """Places the points; trial forces and states of those below ground; True if there are any.

    Args:
        poses, joints, local: See `place`.
        twists: World Jacobian, (6, ≥ columns).
        carries: True where a column moves a point, (n, columns).
        velocity: q̇, (≥ columns,).
        stiffness: k.
        loss: d + h k.
        friction: μ.
        points: Written: in world, (n, 3).
        below: In: which points were below ground before; out: which are, (n,).
        anchor: Renewed of the points that land, (n, 3).
        jacobian, rate, trial, slip: Written where below, (n, 3, columns), (n, 3), (n, 3), (n, 2).
        pressing, sticking: Written, (n,).
    """
    place(poses, joints, local, points)
    touching = False
    for n in range(points.shape[0]):
        pressing[n] = sticking[n] = False
        was_below, below[n] = below[n], points[n, 2] < GROUND
        if not below[n]:
            continue
        touching = True
        if not was_below:
            anchor[n] = points[n]
        point_jacobian(points[n], twists, carries[n], jacobian[n])
        along(jacobian[n], velocity, rate[n])
        for axis in range(3):
            stretch = points[n, axis] - (GROUND if axis == 2 else anchor[n, axis])
            trial[n, axis] = -loss * rate[n, axis] - stiffness * stretch
        x, y, normal = trial[n, 0], trial[n, 1], trial[n, 2]
        pressing[n] = normal > 0.0
        cone = friction * normal
        sticking[n] = pressing[n] and x * x + y * y <= cone * cone
        slide(friction, normal, x, y, slip[n])
    return touching


@kernel(
    "void(float64[:,:,::1], float64[:,::1], float64[:,::1], boolean[::1], boolean[::1], float64, "
    "float64[:,::1], float64[:,::1], float64[::1,:], float64[::1])"
)
def add_to(
    jacobian: Array, trial: Array, slip: Array, pressing: Flags, sticking: Flags, implicit: float,
    start: Array, gain: Array, matrix: Array, right_side: Array,
) -> None:  # fmt: skip
    """Adds Jᵀ c J to the upper triangle of the effective mass, and Jᵀ start to the forces.

    Args:
        jacobian, trial, slip, pressing, sticking: From `begin`, or as `finish` changed them.
        implicit: c = h² k + h d.
        start, gain: Written, (n, 3): forces at q̈ = 0, and c or 0.
        matrix: Effective mass, (≥ columns, ≥ columns).
        right_side: Generalised forces, (≥ columns,).
    """
    for n in range(pressing.shape[0]):
        for axis in range(3):
            start[n, axis] = gain[n, axis] = 0.0
            if not pressing[n]:
                continue
            row = jacobian[n, axis]
            if axis == 2 or sticking[n]:
                gain[n, axis], start[n, axis] = implicit, trial[n, axis]
                for column in range(row.shape[0]):
                    if row[column] != 0.0:
                        weight = implicit * row[column]
                        for upper in range(column + 1):
                            matrix[upper, column] += weight * row[upper]
            else:
                start[n, axis] = slip[n, axis]
            for column in range(row.shape[0]):
                right_side[column] += start[n, axis] * row[column]


@kernel(
    "boolean(float64[:,:,::1], float64[::1], float64[:,::1], float64[:,::1], float64[:,::1], float64, "
    "float64, float64[:,::1], float64[:,::1], float64[:,::1], boolean[::1], boolean[::1])"
)
def finish(
    jacobian: Array, acceleration: Array, trial: Array, start: Array, gain: Array, friction: float,
    implicit: float, change: Array, force: Array, slip: Array, pressing: Flags, sticking: Flags,
) -> bool:  # fmt: skip
    """Forces of a solution; False if a point left its assumed state, which is then changed.

    Pulling points are let go, points beyond the cone slip, slip forces are renewed; a slipping point
    whose friction fell below the cone is given another solution.

    Args:
        jacobian, trial: From `begin`.
        acceleration: q̈, (≥ columns,).
        start, gain: From `add_to`.
        friction: μ.
        implicit: c.
        change: Written where a point presses, (n, 3).
        force: Written: ground on foot in world, (n, 3).
        slip, pressing, sticking: Changed if the answer is False.
    """
    wrong = False
    for n in range(pressing.shape[0]):
        if not pressing[n]:
            force[n] = 0.0
            continue
        along(jacobian[n], acceleration, change[n])
        for axis in range(3):
            force[n, axis] = start[n, axis] - gain[n, axis] * change[n, axis]
        cone = friction * force[n, 2]
        pull = math.sqrt(force[n, 0] ** 2 + force[n, 1] ** 2)
        margin = CONE_SHARE * cone + CONE_FORCE
        wrong = wrong or force[n, 2] < 0.0 or pull > cone + margin
        wrong = wrong or (not sticking[n] and pull < cone - margin)
    if not wrong:
        return True
    for n in range(pressing.shape[0]):
        if pressing[n]:
            x, y, normal = force[n, 0], force[n, 1], force[n, 2]
            pressing[n] = normal >= 0.0
            sticking[n] = sticking[n] and pressing[n] and x * x + y * y <= (friction * normal) ** 2
            spring_x = trial[n, 0] - implicit * change[n, 0]
            spring_y = trial[n, 1] - implicit * change[n, 1]
            slide(friction, normal, spring_x, spring_y, slip[n])
    return False


@kernel("void(float64, float64[:,::1])")
def clip(friction: float, force: Array) -> None:
    """Brings forces, (n, 3), into the cone: no pulling, friction cut to μ f_n."""
    for n in range(force.shape[0]):
        force[n, 2] = max(force[n, 2], 0.0)
        limit = friction * force[n, 2]
        pull = math.sqrt(force[n, 0] ** 2 + force[n, 1] ** 2)
        if pull > limit:
            force[n, 0] *= limit / pull
            force[n, 1] *= limit / pull


@kernel(
    "void(float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1], boolean[::1], boolean[::1], "
    "float64, float64, float64[:,::1])"
)
def follow(
    points: Array, rate: Array, change: Array, force: Array, pressing: Flags, sticking: Flags,
    step: float, stiffness: float, anchor: Array,
) -> None:  # fmt: skip
    """Moves the anchors of slipping points to where the spring carries the friction force.

    Args:
        points, rate, change, force, pressing, sticking: Of the step that ends.
        step: h.
        stiffness: k.
        anchor: x and y changed where slipping, (n, 3).
    """
    for n in range(pressing.shape[0]):
        if pressing[n] and not sticking[n]:
            for axis in range(2):
                end = points[n, axis] + step * (rate[n, axis] + step * change[n, axis])
                anchor[n, axis] = end + force[n, axis] / stiffness


@kernel("void(float64[:,::1], float64[:,::1], float64[:,::1])")
def add_wrenches(points: Array, force: Array, feet: Array) -> None:
    """Adds force and moment about the world's origin of each foot's points.

    Args:
        points, force: In world, (n, 3), the same number of points on each foot.
        feet: Wrenches, one row per foot, (feet, 6).
    """
    per_foot = points.shape[0] // feet.shape[0]
    for n in range(points.shape[0]):
        foot = feet[n // per_foot]
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        fx, fy, fz = force[n, 0], force[n, 1], force[n, 2]
        foot[0] += fx
        foot[1] += fy
        foot[2] += fz
        foot[3] += y * fz - z * fy
        foot[4] += z * fx - x * fz
        foot[5] += x * fy - y * fx
