"""Numbers taken from a run: ZMP, margins, forces, joints; each from what was recorded alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.balance.support_polygon import convex_hull, polygon_margin
from follower_humanoid.bench.kinematics import Motion
from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.graph.record import Run, Series
from follower_humanoid.robot.model import GRAVITY, RobotModel

FORCE_FLOOR = 50.0  # no ZMP below this vertical force [N]
CARRYING = 20.0  # a foot with more than this carries [N]
CLEARANCE = 0.003  # sole points higher than this are in the air [m]


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float("nan")


def moving_mean(values: Array, width: int) -> Array:
    """Mean over a centred window of `width` rows, where it fits, shape (T − width + 1, n)."""
    total = np.cumsum(np.vstack((np.zeros(values.shape[1]), values)), axis=0)
    return np.asarray((total[width:] - total[:-width]) / width)


def zmp_margins(run: Run, motion: Motion) -> Array:
    """Distance of every measured ZMP to the edge of the support polygon, both made here from foot
    forces and sole points, shape (T,) [m]; NaN where the feet carry less than 50 N.
    """
    feet = [run[f"{side.value}_foot/wrench"] for side in SIDES]
    n = min(len(motion.times), *(len(foot) for foot in feet))
    zmp = ground_zmp(run, motion)[:n]
    margins = np.full(n, np.nan)
    for i in np.flatnonzero(np.isfinite(zmp[:, 0])):
        points = []
        for k, foot in enumerate(feet):
            if foot.force[i, 2] > CARRYING:
                sole = motion.contacts[i, 6 * k : 6 * k + 6]
                points.append(sole[sole[:, 2] < CLEARANCE, :2])
        ground = np.vstack(points) if points else np.zeros((0, 2))
        if len(ground):
            margins[i] = polygon_margin(convex_hull(ground), zmp[i])
    return margins


def ground_zmp(run: Run, motion: Motion) -> Array:
    """ZMP in world from foot wrenches and sole poses alone, shape (T, 2) [m]; NaN below 50 N."""
    n = len(motion.times)
    force, moment = np.zeros((n, 3)), np.zeros((n, 3))
    for side in SIDES:
        f, m = foot_in_world(run, motion, side)
        force += f
        moment += m + np.cross(motion.sole[side], f)
    vertical = np.where(force[:, 2] > FORCE_FLOOR, force[:, 2], np.nan)
    return np.column_stack((-moment[:, 1] / vertical, moment[:, 0] / vertical))


def foot_in_world(run: Run, motion: Motion, side: Side) -> tuple[Array, Array]:
    """Ground on foot in axes of world, about the sole origin, shape (T, 3) each [N], [N·m]."""
    foot, turned = run[f"{side.value}_foot/wrench"], motion.sole_rotation[side]
    n = len(motion.times)
    force = np.einsum("tij,tj->ti", turned, foot.force[:n])
    return force, np.einsum("tij,tj->ti", turned, foot.torque[:n])


def at_ticks(series: Series, name: str, ticks: NDArray[np.int64]) -> Array:
    """A field at exactly the given ticks, NaN where there was no sample, shape (T, ...)."""
    rows = np.searchsorted(series.ticks, ticks)
    rows = np.minimum(rows, len(series.ticks) - 1)
    values = series.fields[name][rows].astype(float)
    values[series.ticks[rows] != ticks] = np.nan
    return values


def zmp_error(run: Run, motion: Motion, reference: str, delay: int) -> tuple[float, float]:
    """RMS of reference − measured ZMP along and across the heading [m].

    Args:
        run: The run.
        motion: Its motion, every tick.
        reference: Topic of the wanted ZMP.
        delay: Ticks until the wanted ZMP is acted upon.
    """
    ticks = run["joint_states"].ticks[: len(motion.times)]
    wanted = at_ticks(run[reference], "xyz", ticks - delay)[:, :2]
    error = wanted - ground_zmp(run, motion)
    valid = np.isfinite(error).all(axis=1)
    c, s = np.cos(motion.pelvis_yaw[valid]), np.sin(motion.pelvis_yaw[valid])
    along = c * error[valid, 0] + s * error[valid, 1]
    across = -s * error[valid, 0] + c * error[valid, 1]
    return rms(along), rms(across)


def first_load_shift(run: Run, shift: float = 100.0) -> float:
    """When the feet's loads first differ by `shift` [N] more than at the start [s]; inf if never.

    Balance answers the pull itself at once with half of that; a step begins with more.
    """
    left, right = (run[f"{side.value}_foot/wrench"].force[:, 2] for side in SIDES)
    n = min(len(left), len(right))
    difference = left[:n] - right[:n]
    moved = np.flatnonzero(np.abs(difference - difference[0]) > shift)
    return float(run["left_foot/wrench"].times[moved[0]]) if len(moved) else float("inf")


def peak_voltage(run: Run) -> float:
    """Largest voltage magnitude of any command [V]."""
    return float(max(np.max(np.abs(run[f"{part}/command"].effort)) for part in ("legs", "arms")))


def stop_distance(run: Run, robot: RobotModel) -> tuple[float, str]:
    """Smallest distance of any joint from an end of its range [rad], and which joint."""
    position = run["joint_states"].position
    room = np.minimum(position - robot.lower, robot.upper - position).min(axis=0)
    worst = int(np.argmin(room))
    return float(room[worst]), robot.joint_names[worst]


def wrench_error(run: Run, side: Side, lag: int, smooth: Callable[[Array], Array] | None = None) -> Array:
    """RMS per axis of sensed − applied hand force while the run lasts, shape (3,) [N].

    Args:
        run: The run.
        side: Which hand.
        lag: Ticks from the tick in which a force acted to its sensed value.
        smooth: Filter applied to the error, as the reader of the sensed force would.
    """
    sensed = run[f"{side.value}_hand/wrench"]
    applied = at_ticks(run[f"{side.value}_hand/applied"], "force", sensed.ticks - lag)
    error = sensed.fields["force"] - applied
    error = error[np.isfinite(error).all(axis=1)]
    if smooth is not None:
        error = smooth(error)
    return np.asarray(np.sqrt(np.mean(error**2, axis=0)))


def newton_residual(run: Run, motion: Motion, robot: RobotModel, window: float = 0.25) -> tuple[float, float]:
    """What is left of m(c̈ − g) = feet + applied [N], and of the moments about the CoM [N·m], RMS.

    Forces published at tick k are what acted during the tick that ended at k; momentum differences
    over the same ticks must equal them. Both sides are averaged over the window.
    """
    dt = float(motion.times[1] - motion.times[0])
    n = len(motion.times)
    force, moment = np.zeros((n, 3)), np.zeros((n, 3))
    force[:, 2] = -robot.mass * GRAVITY
    for side in SIDES:
        f, m = foot_in_world(run, motion, side)
        force += f
        moment += m + np.cross(motion.sole[side] - motion.com, f)
    places = {f"{side.value}_hand": motion.gripper[side] for side in SIDES}
    places["base"] = run["odom"].position[:n]
    for name, place in places.items():
        applied = run[f"{name}/applied"]
        force += applied.force[:n]
        moment += applied.torque[:n] + np.cross(place - motion.com, applied.force[:n])
    rate = np.diff(motion.momentum, axis=0) / dt
    width = max(1, round(window / dt))
    left = moving_mean(rate[:, :3] - force[1:], width)
    right = moving_mean(rate[:, 3:] - moment[1:], width)
    return rms(np.linalg.norm(left, axis=1)), rms(np.linalg.norm(right, axis=1))
