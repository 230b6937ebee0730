"""A run as data for the 3D animation: what the links look like, and where they are frame by frame."""

from __future__ import annotations

import base64
import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import Any

import numpy as np

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Integers
from follower_humanoid.pictures.ground import footprints
from follower_humanoid.pictures.style import View

FRAMES_PER_SECOND = 25
_LARGEST = 4000  # frames; a longer run is shown with fewer a second
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


def scene(view: View) -> dict[str, Any]:
    """Everything the player draws of one run, fit for JSON."""
    rate = min(FRAMES_PER_SECOND, _LARGEST / max(view.run.duration, 1.0))
    ticks = view.every(1.0 / rate)
    shapes = visual_shapes(view.body.urdf)
    links = list(dict.fromkeys(shape.link for shape in shapes))
    poses = np.stack([view.body.pose_quat(link, ticks) for link in links], axis=1)
    return {
        "label": view.label,
        "start": float(ticks[0] * view.run.tick),
        "step": float((ticks[1] - ticks[0]) * view.run.tick) if len(ticks) > 1 else 1.0,
        "frames": len(ticks),
        "links": len(links),
        "shapes": [
            {
                "link": links.index(shape.link),
                "kind": shape.kind,
                "size": shape.size,
                "position": shape.position,
                "rotation": shape.rotation.ravel().tolist(),
                "color": [round(255 * part) for part in shape.color],
            }
            for shape in shapes
        ],
        "poses": _packed(poses),
        "base": _packed(view.run["odom"].held("position", ticks)),
        "zmp": _ground_points(view, "zmp", ticks),
        "com": _ground_points(view, "com", ticks),
        "forces": _packed(_hand_forces(view, ticks)),
        "prints": _prints(view),
    }


def _packed(values: Array) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")


def _ground_points(view: View, topic: str, ticks: Integers) -> str:
    points = (
        view.run[topic].held("xyz", ticks)[:, :2] if topic in view.run else np.full((len(ticks), 2), np.nan)
    )
    return _packed(points)


def _hand_forces(view: View, ticks: Integers) -> Array:
    """Per frame and hand: gripper in world [m] and the force that acted [N], shape (T, 2, 6)."""
    values = np.full((len(ticks), 2, 6), np.nan)
    for column, side in enumerate(SIDES):
        topic = f"{side.value}_hand/applied"
        if topic in view.run:
            values[:, column, :3] = view.body.pose(f"{side.prefix}_gripper", ticks).position
            values[:, column, 3:] = view.run[topic].held("force", ticks)
    return values


def _prints(view: View) -> list[dict[str, Any]]:
    """Outlines of the soles, each with the time from which it is there."""
    landings = {side: [-1.0, *(step.landed for step in view.steps if step.side is side)] for side in SIDES}
    prints = []
    for side, outline in footprints(view):
        prints.append({"side": side.value, "from": landings[side].pop(0), "corners": outline.tolist()})
    return prints
