"""The robot in the scene: a handful of messages move all of its links."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from follower_humanoid.viewer.carried import carry
from follower_humanoid.viewer.meshes import BELOW_KNEE, Copies, copies
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.telling import tell

_GLASS = 0.5  # opacity of what is seen through


class Figure:
    """Visuals of the URDF, all boxes, all cylinders and all spheres each as copies of one mesh."""

    def __init__(self, scene: viser.SceneApi, path: str, skeleton: Skeleton) -> None:
        """Puts the robot there. Args: scene, name of its node there, and posture."""
        self._skeleton = skeleton
        kinds = copies(skeleton.urdf)
        self._handles = {name: self._add(scene, f"{path}/{name}", kind) for name, kind in kinds.items()}
        self._kinds = [
            (handle, np.array([skeleton.index(link) for link in kind.links]), kind.poses)
            for handle, kind in zip(self._handles.values(), kinds.values(), strict=True)
        ]
        self.move()

    def move(self) -> None:
        """Takes the posture of the skeleton."""
        frames = self._skeleton.frames
        for handle, rows, poses in self._kinds:
            # The handle's own arrays are what pages were told last.
            if carry(frames, rows, poses, handle.batched_positions, handle.batched_wxyzs):
                tell(handle, "batched_positions", "batched_wxyzs")

    def show_through(self, glass: bool) -> None:
        """Whether lower legs and feet are of glass, so that what they hide is seen."""
        for name, handle in self._handles.items():
            if name.endswith(BELOW_KNEE):
                handle.opacity = _GLASS if glass else None

    @staticmethod
    def _add(scene: viser.SceneApi, path: str, kind: Copies) -> Any:
        return scene.add_batched_meshes_simple(
            path,
            *kind.mesh,
            batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (len(kind.links), 1)),
            batched_positions=np.zeros((len(kind.links), 3)),
            batched_scales=kind.scales,
            batched_colors=kind.colors,
            lod="off",
        )
