"""The robot in the scene: a handful of messages move all of its links."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from follower_humanoid.viewer.meshes import BELOW_KNEE, Copies, carried, copies
from follower_humanoid.viewer.skeleton import Skeleton

_GLASS = 0.5  # opacity of what is seen through


class Figure:
    """Visuals of the URDF, all boxes, all cylinders and all spheres each as copies of one mesh."""

    def __init__(self, scene: viser.SceneApi, path: str, skeleton: Skeleton) -> None:
        """Puts the robot there. Args: scene, name of its node there, and posture."""
        self._skeleton = skeleton
        kinds = copies(skeleton.urdf)
        self._links = tuple(dict.fromkeys(link for kind in kinds.values() for link in kind.links))
        row = {link: number for number, link in enumerate(self._links)}
        self._rows = [row[link] for kind in kinds.values() for link in kind.links]
        self._positions = np.vstack([kind.positions for kind in kinds.values()])
        self._rotations = np.vstack([kind.rotations for kind in kinds.values()])
        self._ends = np.cumsum([len(kind.links) for kind in kinds.values()])[:-1]
        self._handles = {name: self._add(scene, f"{path}/{name}", kind) for name, kind in kinds.items()}
        self.move()

    def move(self) -> None:
        """Takes the posture of the skeleton."""
        poses = [self._skeleton.pose_wxyz(link) for link in self._links]
        positions, wxyz = (np.array([pose[part] for pose in poses]) for part in (0, 1))
        places = carried(positions[self._rows], wxyz[self._rows], self._positions, self._rotations)
        parts = (np.split(place.astype(np.float32), self._ends) for place in places)
        for handle, xyz, quats in zip(self._handles.values(), *parts, strict=True):
            handle.batched_positions, handle.batched_wxyzs = xyz, quats

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
            batched_wxyzs=kind.rotations,
            batched_positions=kind.positions,
            batched_scales=kind.scales,
            batched_colors=kind.colors,
            lod="off",
        )
