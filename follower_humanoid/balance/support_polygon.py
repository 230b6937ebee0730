"""The support polygon: convex hull of what touches the ground, and how far inside it a point is."""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import Indices


@kernel_part
def turn(points: Array, a: int, b: int, c: int) -> float:
    """Positive where the way from point a by b to c turns left."""
    abx, aby = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    return float(abx * (points[c, 1] - points[a, 1]) - aby * (points[c, 0] - points[a, 0]))


@kernel_part
def in_order(points: Array) -> Array:
    """Points by x, then by y, each once: what the hull goes along."""
    ordered = points.copy()
    count = 0
    for n in range(len(points)):
        x, y = points[n, 0], points[n, 1]
        place = count
        while place > 0 and (ordered[place - 1, 0], ordered[place - 1, 1]) >= (x, y):
            place -= 1
        if place < count and ordered[place, 0] == x and ordered[place, 1] == y:
            continue
        for later in range(count, place, -1):
            ordered[later] = ordered[later - 1]
        ordered[place, 0], ordered[place, 1] = x, y
        count += 1
    return np.ascontiguousarray(ordered[:count])


@kernel("float64[:,::1](float64[:,:])")
def convex_hull(points: Array) -> Array:
    """Convex hull in the plane, counter-clockwise, by Andrew's monotone chain.

    Args:
        points: Shape (n, 2), n ≥ 1.

    Returns:
        Shape (m, 2), m ≤ n.
    """
    ordered = in_order(points)
    count = len(ordered)
    if count < 3:
        return ordered
    chain = np.empty(2 * count, dtype=np.int64)
    size = 0
    for point in range(count):  # below, from left to right
        while size >= 2 and turn(ordered, chain[size - 2], chain[size - 1], point) <= 0.0:
            size -= 1
        chain[size] = point
        size += 1
    below = size
    for point in range(count - 2, -1, -1):  # above, back again
        while size > below and turn(ordered, chain[size - 2], chain[size - 1], point) <= 0.0:
            size -= 1
        chain[size] = point
        size += 1
    return ordered[chain[: size - 1]]


@kernel("float64[:,::1](float64[:,:,::1], int64[::1], float64)")
def ground_hull(frames: Array, points: Indices, clearance: float) -> Array:
    """Convex hull over the ground of those frames that are on it.

    Args:
        frames: Poses as in `robot.pose_table`, shape (n, 4, 3).
        points: The frames in question.
        clearance: Largest height above ground [m].

    Returns:
        Vertices in world, shape (m, 3) [m]; m = 0 where none is on the ground.
    """
    places = np.empty((len(points), 2))
    count = 0
    for frame in points:
        if frames[frame, 3, 2] < clearance:
            places[count] = frames[frame, 3, :2]
            count += 1
    if count == 0:
        return np.zeros((0, 3))
    hull = convex_hull(places[:count])
    vertices = np.zeros((len(hull), 3))
    vertices[:, :2] = hull
    return vertices


@kernel("float64(float64[:,:], float64[::1])")
def polygon_margin(polygon: Array, point: Array) -> float:
    """Distance of a point to the nearest edge of a convex polygon, positive inside [m].

    Args:
        polygon: Vertices counter-clockwise, shape (n, ≥ 2) [m]; of two or one the line or point between them.
        point: Shape (2,) [m].
    """
    to_lines = nearest = math.inf  # to the lines through the edges, negative outside; to the edges
    for i in range(len(polygon)):
        a, b = polygon[i], polygon[(i + 1) % len(polygon)]
        edge_x, edge_y, away_x, away_y = b[0] - a[0], b[1] - a[1], point[0] - a[0], point[1] - a[1]
        length2 = max(edge_x**2 + edge_y**2, 1e-18)
        to_lines = min(to_lines, (edge_x * away_y - edge_y * away_x) / math.sqrt(length2))
        along = min(max((edge_x * away_x + edge_y * away_y) / length2, 0.0), 1.0)
        nearest = min(nearest, math.hypot(away_x - along * edge_x, away_y - along * edge_y))
    return to_lines if len(polygon) >= 3 and to_lines >= 0.0 else -nearest
