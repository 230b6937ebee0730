"""On the ground of the scene: where feet stood, where steps are planned, and where the pelvis has been."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import viser

from follower_humanoid.core.samples import SIDES, Array, Footstep, Footsteps
from follower_humanoid.pictures.palette import PCM, SIDE_COLORS, rgb
from follower_humanoid.viewer.moment import Trail, TrailKeeper
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.telling import tell_moved

# Heights over the ground, so that nothing flickers through what it lies on [m].
_TRAIL, _PRINT = 0.002, 0.004


class Footprints:
    """Footprints, thick where a foot stood and thin where a step is planned, and the trail."""

    def __init__(self, scene: viser.SceneApi, path: str, skeleton: Skeleton) -> None:
        """Nothing yet. Args: scene, name of its nodes there, and the robot as it stands."""
        self._outlines = {side: skeleton.sole_outline(side) for side in SIDES}
        looks = {"trail": (PCM, 0.012)}
        for side in SIDES:
            looks[f"taken_{side.value}"] = (SIDE_COLORS[side], 0.014)
            looks[f"planned_{side.value}"] = (SIDE_COLORS[side], 0.006)
        self._lines: dict[str, Any] = {
            name: scene.add_line_segments(
                f"{path}/{name}", np.zeros((1, 2, 3)), rgb(color), thickness=width, visible=False
            )
            for name, (color, width) in looks.items()
        }
        self._trail = Trail()
        self._footsteps = Footsteps(())

    def draw(self, trail: Trail, footsteps: Footsteps) -> None:
        """Shows what lies there now; what has not changed is left alone."""
        if not np.array_equal(trail.path, self._trail.path):
            self._draw_path(trail.path)
        if [*map(id, trail.prints)] != [*map(id, self._trail.prints)]:
            self._draw_soles("taken", trail.prints)
        if footsteps is not self._footsteps:
            self._draw_soles("planned", [step for step in footsteps.steps if not step.taken])
        self._trail, self._footsteps = trail, footsteps

    def _draw_path(self, points: Array) -> None:
        path = points.copy()
        path[:, 2] = _TRAIL
        segments = np.stack((path[:-1], path[1:]), axis=1)
        walked = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) < TrailKeeper.JUMP
        self._draw_lines("trail", segments[walked])

    def _draw_soles(self, name: str, steps: Sequence[Footstep]) -> None:
        for side in SIDES:
            own = [step for step in steps if step.side is side]
            self._draw_lines(f"{name}_{side.value}", outlines(self._outlines[side], own))

    def _draw_lines(self, name: str, segments: Array) -> None:
        self._lines[name].visible = bool(len(segments))
        if len(segments):
            tell_moved(self._lines[name], "points", segments.astype(np.float32))


def outlines(sole: Array, steps: Sequence[Footstep]) -> Array:
    """Edges of footprints on the ground, shape (m · len(steps), 2, 3) [m].

    Args:
        sole: Corners of the sole in its own frame, in order, shape (m, 3) [m].
        steps: Where it stood.
    """
    yaw = np.array([step.yaw for step in steps]).reshape(-1, 1)
    middle = np.array([step.position[:2] for step in steps]).reshape(-1, 2, 1)
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = sole[:, 0], sole[:, 1]
    along, across = c * x - s * y + middle[:, 0], s * x + c * y + middle[:, 1]
    corners = np.stack((along, across, np.full_like(along, _PRINT)), axis=2)
    return np.stack((corners, np.roll(corners, -1, axis=1)), axis=2).reshape(-1, 2, 3)
