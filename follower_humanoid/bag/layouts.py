"""How each kind of sample lies in its message: numbers for the batch decoder, irregular ones one by one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from follower_humanoid.bag.cdr import Cursor, Walk
from follower_humanoid.core import samples
from follower_humanoid.core.samples import Array, Footstep, Footsteps, Polygon, PrimitiveStates, Side
from follower_humanoid.core.topics import CLOSING_STEP

Words = tuple[tuple[str, ...], ...]


def _joint_state(cursor: Cursor) -> Words:
    _, frame = cursor.header()
    names = cursor.texts()
    for name in ("position", "velocity", "effort"):
        cursor.double_sequence(name)
    return (frame,), names


def _odometry(cursor: Cursor) -> Words:
    _, frame = cursor.header()
    child = cursor.text()
    cursor.doubles("position", 3)
    cursor.doubles("quat_xyzw", 4)
    cursor.doubles("pose_covariance", 36)
    cursor.doubles("linear_velocity", 3)
    cursor.doubles("angular_velocity", 3)
    cursor.doubles("twist_covariance", 36)
    return (frame,), (child,)


def _imu(cursor: Cursor) -> Words:
    _, frame = cursor.header()
    for name, count in (
        ("quat_xyzw", 4),
        ("quat_covariance", 9),
        ("angular_velocity", 3),
        ("angular_covariance", 9),
        ("linear_acceleration", 3),
        ("linear_covariance", 9),
    ):
        cursor.doubles(name, count)
    return ((frame,),)


def _wrench(cursor: Cursor) -> Words:
    _, frame = cursor.header()
    cursor.doubles("force", 3)
    cursor.doubles("torque", 3)
    return ((frame,),)


def _point(cursor: Cursor) -> Words:
    _, frame = cursor.header()
    cursor.doubles("xyz", 3)
    return ((frame,),)


WALKS: dict[type, Walk] = {
    samples.Joints: _joint_state,
    samples.Gait: _joint_state,
    samples.ContactPlan: _joint_state,
    samples.Odometry: _odometry,
    samples.Inertial: _imu,
    samples.Wrench: _wrench,
    samples.Point: _point,
}


def _polygon(cursor: Cursor) -> tuple[int, Polygon]:
    stamp, _ = cursor.header()
    vertices = cursor.floats(3 * cursor.length()).reshape(-1, 3)
    return stamp, Polygon(vertices)


def _primitives(cursor: Cursor) -> tuple[int, PrimitiveStates]:
    stamp, _ = cursor.header()
    names = cursor.texts()
    return stamp, PrimitiveStates(names, tuple(cursor.double_sequence("position").tolist()))


def _footsteps(cursor: Cursor) -> tuple[int | None, Footsteps]:
    count = cursor.length()
    stamp: int | None = None
    steps = []
    for _ in range(count):
        marker_stamp, step = _marker(cursor)
        stamp = marker_stamp if stamp is None else stamp
        if step is not None:
            steps.append(step)
    return stamp, Footsteps(tuple(steps))


def _marker(cursor: Cursor) -> tuple[int, Footstep | None]:
    stamp, _ = cursor.header()
    namespace = cursor.text()
    cursor.integer()  # id
    cursor.integer()  # type
    action = cursor.integer()
    position = cursor.doubles("position", 3)
    quat_xyzw = cursor.doubles("quat_xyzw", 4)
    cursor.skip(3, 8)  # scale
    opacity = float(cursor.floats(4)[3])
    cursor.skip(2, 4)  # lifetime
    cursor.skip(1)  # frame_locked
    cursor.skip(3 * cursor.length(), 8)  # points
    cursor.skip(4 * cursor.length(), 4)  # colours
    cursor.text()  # texture_resource
    cursor.header()  # texture
    cursor.text()
    cursor.skip(cursor.length())
    cursor.skip(2 * cursor.length(), 4)  # uv_coordinates
    text = cursor.text()
    cursor.text()  # mesh_resource
    cursor.text()  # mesh_file
    cursor.skip(cursor.length())
    cursor.skip(1)  # mesh_use_embedded_materials
    if action != 0:
        return stamp, None
    return stamp, _footstep(namespace, text, position, quat_xyzw, opacity)


def _footstep(side: str, text: str, position: Array, quat_xyzw: Array, opacity: float) -> Footstep | None:
    """The step that a marker shows: pale while it is planned, labelled where it only closes the feet."""
    if side not in (Side.LEFT.value, Side.RIGHT.value):
        return None
    x, y, z, w = quat_xyzw
    yaw = float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    return Footstep(Side(side), position, yaw, taken=opacity > 0.5, counted=text != CLOSING_STEP)


IRREGULAR: dict[type, Callable[[Cursor], tuple[int | None, Any]]] = {
    samples.Polygon: _polygon,
    samples.PrimitiveStates: _primitives,
    samples.Footsteps: _footsteps,
}
