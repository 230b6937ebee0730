"""What the links of a URDF look like."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import ConfigurationError

_GREY = (0.6, 0.6, 0.6)


@dataclass(frozen=True)
class Shape:
    """One visual of the URDF.

    Attributes:
        link: Name of the link it belongs to.
        kind: `box` (size = edges), `cylinder` (radius, length along z, 0) or `sphere` (radius, 0, 0).
        size: [m].
        position: In the link frame [m].
        rotation: Shape to link, shape (3, 3).
        color: Red, green, blue, 0…1.
    """

    link: str
    kind: str
    size: tuple[float, float, float]
    position: tuple[float, float, float]
    rotation: Array
    color: tuple[float, float, float]


def visual_shapes(urdf: str) -> list[Shape]:
    """The boxes, cylinders and spheres of a URDF; meshes are left out.

    Raises:
        ConfigurationError: Not well-formed.
    """
    try:
        robot = ElementTree.fromstring(urdf)
        palette = {
            material.get("name", ""): _color(material) for material in robot.iter("material") if len(material)
        }
        shapes = [
            shape
            for link in robot.iter("link")
            for visual in link.iter("visual")
            if (shape := _shape(link.get("name", ""), visual, palette)) is not None
        ]
    except (ElementTree.ParseError, ValueError) as error:
        raise ConfigurationError(f"the recorded URDF is malformed: {error}") from None
    return shapes


def _color(material: ElementTree.Element) -> tuple[float, float, float]:
    color = material.find("color")
    return _GREY if color is None else _three(color.get("rgba", "0.6 0.6 0.6 1"))


def _shape(
    link: str, visual: ElementTree.Element, palette: dict[str, tuple[float, float, float]]
) -> Shape | None:
    geometry = visual.find("geometry")
    if geometry is None or not len(geometry):
        return None
    form = geometry[0]
    if form.tag == "box":
        size = _three(form.get("size", "0 0 0"))
    elif form.tag == "cylinder":
        size = (float(form.get("radius", "0")), float(form.get("length", "0")), 0.0)
    elif form.tag == "sphere":
        size = (float(form.get("radius", "0")), 0.0, 0.0)
    else:
        return None
    origin = visual.find("origin")
    position, angles = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if origin is not None:
        position, angles = _three(origin.get("xyz", "0 0 0")), _three(origin.get("rpy", "0 0 0"))
    material = visual.find("material")
    name = "" if material is None else material.get("name", "")
    color = _color(material) if material is not None and len(material) else palette.get(name, _GREY)
    return Shape(link, form.tag, size, position, _rotation(*angles), color)


def _three(text: str) -> tuple[float, float, float]:
    x, y, z = (float(word) for word in text.split()[:3])
    return x, y, z


def _rotation(roll: float, pitch: float, yaw: float) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
