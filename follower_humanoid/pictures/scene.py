"""A run as data for the 3D animation: what the links look like, and where they are frame by frame."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.graph.record import Integers
from follower_humanoid.pictures.ground import footprints
from follower_humanoid.pictures.shapes import visual_shapes
from follower_humanoid.pictures.style import View

FRAMES_PER_SECOND = 25
_LARGEST = 4000  # frames; a longer run is shown with fewer a second


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
    landings = {side: [-1.0, *(step.landing for step in view.steps if step.side is side)] for side in SIDES}
    prints = []
    for side, outline in footprints(view):
        prints.append({"side": side.value, "from": landings[side].pop(0), "corners": outline.tolist()})
    return prints
