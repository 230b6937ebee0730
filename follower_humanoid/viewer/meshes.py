"""Triangle meshes for the robot's visuals: boxes and cylinders with rounded edges, in link frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.samples import Array
from follower_humanoid.pictures.shapes import Shape, visual_shapes

_AROUND, _UP = 20, 10  # facets of a ball; multiples of 4 and 2, so that no vertex lies on a coordinate plane
_ROUNDING = 0.32  # radius of a rounded edge, of the shortest edge

Faces = NDArray[np.int64]


@dataclass(frozen=True)
class LinkMesh:
    """All visuals of one colour of a link.

    Attributes:
        link: Name of the link.
        color: Red, green, blue, 0…255.
        vertices: In the link frame, shape (n, 3) [m].
        faces: Corners counter-clockwise seen from outside, shape (m, 3).
    """

    link: str
    color: tuple[int, int, int]
    vertices: Array
    faces: Faces


def link_meshes(urdf: str) -> list[LinkMesh]:
    """The visuals of a URDF, one mesh per link and colour.

    Raises:
        ConfigurationError: Not well-formed.
    """
    groups: dict[tuple[str, tuple[int, int, int]], list[tuple[Array, Faces]]] = {}
    for shape in visual_shapes(urdf):
        red, green, blue = (round(255 * part) for part in shape.color)
        groups.setdefault((shape.link, (red, green, blue)), []).append(_mesh(shape))
    return [LinkMesh(link, color, *_joined(parts)) for (link, color), parts in groups.items()]


def disc(radius: float, corners: int = 24) -> tuple[Array, Faces]:
    """A flat disc in the x–y plane, seen from above: vertices and faces."""
    angles = 2.0 * np.pi * np.arange(corners) / corners
    rim = radius * np.column_stack((np.cos(angles), np.sin(angles), np.zeros(corners)))
    around = np.arange(corners)
    faces = np.column_stack((np.full(corners, corners), around, (around + 1) % corners))
    return np.vstack((rim, np.zeros(3))), faces


def fan(corners: int) -> Faces:
    """Faces of a convex polygon whose vertices come in order."""
    second = np.arange(1, corners - 1)
    return np.column_stack((np.zeros_like(second), second, second + 1))


def _mesh(shape: Shape) -> tuple[Array, Faces]:
    points, faces = _ball()
    if shape.kind == "box":
        half = 0.5 * np.array(shape.size)
        radius = 2.0 * _ROUNDING * float(half.min())
        points = np.sign(points) * (half - radius) + radius * points
    elif shape.kind == "cylinder":
        radius, length, _ = shape.size
        edge = min(radius, 0.5 * length)
        points = np.column_stack(
            (radius * points[:, :2], np.sign(points[:, 2]) * (0.5 * length - edge) + edge * points[:, 2])
        )
    else:
        points = shape.size[0] * points
    return points @ shape.rotation.T + np.array(shape.position), faces


def _ball() -> tuple[Array, Faces]:
    """The unit ball; no vertex but the poles lies on a coordinate plane."""
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


def _joined(parts: Iterable[tuple[Array, Faces]]) -> tuple[Array, Faces]:
    vertices: list[Array] = []
    faces: list[Faces] = []
    count = 0
    for points, corners in parts:
        vertices.append(points)
        faces.append(corners + count)
        count += len(points)
    return np.vstack(vertices), np.vstack(faces)
