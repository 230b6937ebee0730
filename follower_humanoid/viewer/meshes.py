"""Shapes of the scene as triangles: the robot's visuals are scaled copies of three of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.samples import Array
from follower_humanoid.pictures.shapes import Shape, visual_shapes

_AROUND, _UP = 20, 10  # facets of a ball; multiples of 4 and 2, so that no vertex lies on a coordinate plane
BELOW_KNEE = "_below_knee"
"""Ends the names of copies of lower legs and feet, which may be seen through."""
_LOWER_LEG = ("_shank", "_ankle_pitch_link", "_ankle", "_toe")
_ROUNDING = 0.16  # of a rounded edge, part of the box's edges or the cylinder's length

Mesh = tuple[Array, NDArray[np.int64]]
"""Vertices, shape (n, 3), and faces, shape (m, 3): corners counter-clockwise seen from outside."""


@dataclass(frozen=True)
class Copies:
    """All visuals of one kind.

    Attributes:
        mesh: What is copied, with edges or a diameter and length of 1.
        links: Link of each copy.
        poses: In the link frame: axes x, y, z, then the origin [m], shape (n, 4, 3).
        scales: Along the axes of the copy, shape (n, 3) [m].
        colors: Red, green, blue, proportional to light, 0…255, shape (n, 3).
    """

    mesh: Mesh
    links: tuple[str, ...]
    poses: Array
    scales: Array
    colors: NDArray[np.uint8]


def copies(urdf: str) -> dict[str, Copies]:
    """The visuals of a URDF by kind, those of lower legs and feet apart.

    Raises:
        ConfigurationError: Not well-formed.
    """
    by_kind: dict[str, list[Shape]] = {}
    for shape in visual_shapes(urdf):
        part = BELOW_KNEE if shape.link.endswith(_LOWER_LEG) else ""
        by_kind.setdefault(shape.kind + part, []).append(shape)
    return {name: _copies(shapes) for name, shapes in by_kind.items()}


def _copies(shapes: list[Shape]) -> Copies:
    kind = shapes[0].kind
    points, faces = ball()
    if kind == "box":
        points = np.sign(points) * (0.5 - _ROUNDING) + _ROUNDING * points
    elif kind == "cylinder":
        upright = np.sign(points[:, 2]) * (0.5 - _ROUNDING) + _ROUNDING * points[:, 2]
        points = np.column_stack((0.5 * points[:, :2], upright))
    else:
        points = 0.5 * points
    return Copies(
        mesh=(points, faces),
        links=tuple(shape.link for shape in shapes),
        poses=np.array([[*np.asarray(shape.rotation).T, shape.position] for shape in shapes]),
        scales=np.array([_edges(shape) for shape in shapes]),
        colors=light(np.array([shape.color for shape in shapes])),
    )


def light(color: Array) -> NDArray[np.uint8]:
    """Light, 0…255, of colours as screens are told them (sRGB, 0…1): copies and arrows are coloured by it."""
    linear = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    return np.round(255 * linear).astype(np.uint8)


def _edges(shape: Shape) -> tuple[float, float, float]:
    """Size of a shape along its axes [m]."""
    first, second, _ = shape.size
    if shape.kind == "cylinder":
        return 2 * first, 2 * first, second
    return (2 * first, 2 * first, 2 * first) if shape.kind == "sphere" else shape.size


def disc(radius: float, corners: int = 24) -> Mesh:
    """A flat disc in the x–y plane, seen from above; radius in [m]."""
    angles = 2.0 * np.pi * np.arange(corners) / corners
    rim = radius * np.column_stack((np.cos(angles), np.sin(angles), np.zeros(corners)))
    around = np.arange(corners)
    faces = np.column_stack((np.full(corners, corners), around, (around + 1) % corners))
    return np.vstack((rim, np.zeros(3))), faces


def rim(radius: float, corners: int = 24) -> Array:
    """Edges of such a disc, shape (corners, 2, 3) [m]."""
    edge = disc(radius, corners)[0][:-1]
    return np.stack((edge, np.roll(edge, -1, axis=0)), axis=1)


def fan(corners: int) -> NDArray[np.int64]:
    """Faces of a convex polygon whose vertices come in order."""
    second = np.arange(1, corners - 1)
    return np.column_stack((np.zeros_like(second), second, second + 1))


def ball() -> Mesh:
    """The ball of radius 1; no vertex but the poles lies on a coordinate plane."""
    polar = np.pi * (np.arange(_UP) + 0.5) / _UP
    around = 2.0 * np.pi * (np.arange(_AROUND) + 0.5) / _AROUND
    ring = np.column_stack((np.cos(around), np.sin(around)))
    rows = [np.column_stack((np.sin(p) * ring, np.full(_AROUND, np.cos(p)))) for p in polar]
    points = np.vstack((*rows, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]))
    top, bottom = len(points) - 2, len(points) - 1
    this, following = np.arange(_AROUND), (np.arange(_AROUND) + 1) % _AROUND
    faces = [np.column_stack((np.full(_AROUND, top), this, following))]
    for row in range(_UP - 1):
        above, below = row * _AROUND, (row + 1) * _AROUND
        faces.append(np.column_stack((above + this, below + this, below + following)))
        faces.append(np.column_stack((above + this, below + following, above + following)))
    last = (_UP - 1) * _AROUND
    faces.append(np.column_stack((np.full(_AROUND, bottom), last + following, last + this)))
    return points, np.vstack(faces)
