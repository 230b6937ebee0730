"""Zero moment point and support polygon, from what the feet measure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Wrench


@dataclass(frozen=True)
class ZmpConfig:
    """Force floors below which a foot or a ZMP does not count."""

    force_floor: float = parameter(50.0, "no ZMP below this vertical force", "N", 1, 500)
    carrying: float = parameter(20.0, "a foot with more than this carries", "N", 1, 500)
    clearance: float = parameter(
        0.003, "sole points higher than this are left out of the polygon", "m", 1e-4, 0.05
    )


@dataclass(frozen=True, slots=True)
class SolePlace:
    """A sole in world.

    Attributes:
        position: Sole origin, shape (3,) [m].
        rotation: Sole to world, shape (3, 3).
    """

    position: Array
    rotation: Array


def wrench_about_origin(wrench: Wrench, place: SolePlace) -> tuple[Array, Array]:
    """Force and moment about the world origin, both in world axes, shape (3,) each [N], [N·m]."""
    force = place.rotation @ wrench.force
    x, y, z = place.position
    moment = place.rotation @ wrench.torque
    moment = moment + np.array(
        [y * force[2] - z * force[1], z * force[0] - x * force[2], x * force[1] - y * force[0]]
    )
    return force, moment


def measured_zmp(
    left: Wrench, right: Wrench, left_place: SolePlace, right_place: SolePlace, force_floor: float
) -> Array | None:
    """The point of the ground about which the feet's wrench has no horizontal moment.

    p_x = −M_y/F_z, p_y = M_x/F_z with force and moment of both feet about the world origin, ground z = 0.

    Args:
        left, right: Ground on foot, at and in the sole frames.
        left_place, right_place: Soles in world.
        force_floor: Smallest vertical force [N].

    Returns:
        ZMP over the ground, shape (2,) [m]; None where the feet carry less than the floor.
    """
    force_left, moment_left = wrench_about_origin(left, left_place)
    force_right, moment_right = wrench_about_origin(right, right_place)
    vertical = force_left[2] + force_right[2]
    if vertical < force_floor:
        return None
    moment = moment_left + moment_right
    return np.array([-moment[1] / vertical, moment[0] / vertical])


def convex_hull(points: Array) -> Array:
    """Convex hull in the plane, counter-clockwise, by Andrew's monotone chain.

    Args:
        points: Shape (n, 2), n ≥ 1.

    Returns:
        Shape (m, 2), m ≤ n.
    """
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered)

    def half(sequence: list[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for point in sequence:
            while len(chain) >= 2 and _turn(chain[-2], chain[-1], point) <= 0.0:
                chain.pop()
            chain.append(point)
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))


def polygon_margin(polygon: Array, point: Array) -> float:
    """Distance of a point to the nearest edge of a convex polygon, positive inside [m].

    Args:
        polygon: Vertices counter-clockwise, shape (n, 2) [m].
        point: Shape (2,) [m].
    """
    if len(polygon) < 3:
        return -_distance_to_edges(polygon, point)
    edges = np.roll(polygon, -1, axis=0) - polygon
    normals = np.column_stack((-edges[:, 1], edges[:, 0])) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
    inside = float(np.min(np.sum(normals * (point - polygon), axis=1)))
    if inside >= 0.0:
        return inside
    return -_distance_to_edges(polygon, point)


def _distance_to_edges(polygon: Array, point: Array) -> float:
    """Distance of a point to the nearest point of the closed line through the vertices [m]."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    lengths2 = np.maximum(np.sum(edges**2, axis=1), 1e-18)
    along = np.clip(np.sum((point - polygon) * edges, axis=1) / lengths2, 0.0, 1.0)
    nearest = polygon + along[:, None] * edges
    return float(np.min(np.hypot(*(point - nearest).T)))


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Positive where a → b → c turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
