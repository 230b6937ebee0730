"""The frames of the URDF as a tree of transforms: what ROS calls tf."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import ConfigurationError

WORLD = "world"
Edge: TypeAlias = tuple[str, str]
"""Parent and child frame."""


class TransformTree:
    """Where every frame is in its parent.

    Attributes:
        moving: Edges that change, `world` to the base first.
        fixed: Edges that never do.
    """

    def __init__(self, urdf: str) -> None:
        """Args: text of the URDF.

        Raises:
            ConfigurationError: Malformed.
        """
        try:
            joints = list(ElementTree.fromstring(urdf).iter("joint"))
            self._model = pin.buildModelFromXML(urdf, pin.JointModelFreeFlyer())
        except (ElementTree.ParseError, ValueError, RuntimeError) as error:
            raise ConfigurationError(f"the URDF is malformed: {' '.join(str(error).split())}") from None
        edges = {_edge(joint): joint.get("type") == "fixed" for joint in joints}
        children = {child for _, child in edges}
        base = next(parent for parent, _ in edges if parent not in children)
        self.moving = ((WORLD, base), *(edge for edge, fixed in edges.items() if not fixed))
        self.fixed = tuple(edge for edge, fixed in edges.items() if fixed)
        self._data = self._model.createData()
        # Looked up once: a frame is found by its name among all.
        self._ids = {edge: self._frame_ids(*edge) for edge in (*self.moving, *self.fixed)}
        self.joint_names = tuple(self._model.names)[2:]

    def place(self, position: Array, quat_xyzw: Array, joints: Array) -> None:
        """Takes a posture.

        Args:
            position: Of the base in world, shape (3,) [m].
            quat_xyzw: Base to world, shape (4,).
            joints: In the order of `joint_names`, shape (n,) [rad].
        """
        q = np.concatenate((position, quat_xyzw, joints))
        pin.framesForwardKinematics(self._model, self._data, q)

    def poses(self, edges: tuple[Edge, ...]) -> Array:
        """Child in parent of the posture: position [m] and quaternion (x, y, z, w), shape (n, 7)."""
        return np.array([pin.SE3ToXYZQUAT(self._pose(*self._ids[edge])) for edge in edges])

    def _frame_ids(self, parent: str, child: str) -> tuple[int | None, int]:
        return None if parent == WORLD else self._model.getFrameId(parent), self._model.getFrameId(child)

    def _pose(self, parent: int | None, child: int) -> pin.SE3:
        placement = self._data.oMf[child]
        return placement if parent is None else self._data.oMf[parent].actInv(placement)


def _edge(joint: ElementTree.Element) -> Edge:
    parent, child = joint.find("parent"), joint.find("child")
    if parent is None or child is None:
        raise ConfigurationError("the URDF is malformed: a joint without parent or child")
    return parent.get("link", ""), child.get("link", "")
