"""Transforms and the robot's description in a bag, whether anybody publishes them or not.

They are made here from joint states, odometry and URDF: Foxglove and RViz show the robot in every bag.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

from follower_humanoid.bag.cdr import CdrError, Cursor
from follower_humanoid.bag.layouts import WALKS
from follower_humanoid.core import samples
from follower_humanoid.core.cdr import CdrBytes, put_stamp, stamp_of
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.transforms import Edge, TransformTree

TF_TYPE = "tf2_msgs/msg/TFMessage"
STRING_TYPE = "std_msgs/msg/String"
PERIOD = 20_000_000
"""Time between two transforms of a frame [ns]."""


class Made(NamedTuple):
    """A message made here: relative or absolute name of its topic, type, whether it is latched, bytes."""

    topic: str
    type_name: str
    latched: bool
    data: bytes


class TransformMessage:
    """Serialised tf2_msgs/TFMessage for the same frames again and again."""

    def __init__(self, edges: tuple[Edge, ...]) -> None:
        """Args: parent and child frames, in order."""
        message = CdrBytes()
        message.length(len(edges))
        self._stamps: list[int] = []
        blocks: list[int] = []
        for parent, child in edges:
            self._stamps.append(message.stamp())
            message.text(parent)
            message.text(child)
            message.align(8)
            blocks.append(len(message.data))
            message.data += bytes(7 * 8)
        self._data = message.data
        self._views = [np.frombuffer(self._data, "<f8", 7, offset) for offset in blocks]

    def encode(self, stamp: int, poses: Array) -> bytes:
        """The message; stamp in [ns], poses of the children as position and quaternion, shape (n, 7)."""
        for view, pose in zip(self._views, poses, strict=True):
            view[:] = pose
        for offset in self._stamps:
            put_stamp(self._data, offset, stamp)
        return bytes(self._data)


def string_message(text: str) -> bytes:
    """A serialised std_msgs/String."""
    message = CdrBytes()
    message.text(text)
    return bytes(message.data)


TRANSFORMED = frozenset({"odom", "joint_states"})
"""Topics that say where the robot is."""


class TransformMaker:
    """Follows the robot's state and says where its frames are."""

    def __init__(self, urdf: str) -> None:
        """Args: text of the URDF.

        Raises:
            ConfigurationError: Malformed.
        """
        self._urdf = urdf
        self._tree = TransformTree(urdf)
        self._moving = TransformMessage(self._tree.moving)
        self._odometry: tuple[int, Array] | None = None
        self._joints: tuple[int, Array] | None = None
        self._due: int | None = None

    def latched(self) -> list[Made]:
        """What is told once: the robot and its fixed frames."""
        tree = self._tree
        tree.place(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(len(tree.joint_names)))
        fixed = TransformMessage(tree.fixed).encode(0, tree.poses(tree.fixed))
        return [
            Made("robot_description", STRING_TYPE, True, string_message(self._urdf)),
            Made("/tf_static", TF_TYPE, True, fixed),
        ]

    def take(self, topic: str, data: bytes) -> Made | None:
        """Takes a serialised `joint_states` or `odom`; returns the transforms where they are due."""
        try:
            if topic not in TRANSFORMED or not self._wanted(data):
                return None
            if topic == "odom":
                cursor = Cursor(data)
                WALKS[samples.Odometry](cursor)
                self._odometry = (
                    stamp_of(data, cursor.stamps[0]),
                    np.hstack([_numbers(data, cursor, name) for name in ("position", "quat_xyzw")]),
                )
            else:
                cursor = Cursor(data)
                _, names = WALKS[samples.Joints](cursor)
                values = dict(zip(names, _numbers(data, cursor, "position"), strict=True))
                order = [values[name] for name in self._tree.joint_names]
                self._joints = stamp_of(data, cursor.stamps[0]), np.array(order)
        except (CdrError, KeyError, ValueError, struct.error, IndexError):
            return None
        return self._made()

    def _wanted(self, data: bytes) -> bool:
        stamp = stamp_of(data)
        return self._due is None or not self._due - PERIOD < stamp < self._due

    def _made(self) -> Made | None:
        if self._odometry is None or self._joints is None or self._odometry[0] != self._joints[0]:
            return None
        (stamp, base), (_, joints) = self._odometry, self._joints
        self._joints = None
        self._due = stamp + PERIOD
        self._tree.place(base[:3], base[3:], joints)
        return Made("/tf", TF_TYPE, False, self._moving.encode(stamp, self._tree.poses(self._tree.moving)))


def _numbers(data: bytes, cursor: Cursor, name: str) -> Array:
    offset, count = cursor.numbers[name]
    return np.frombuffer(data, ">f8" if cursor.big_endian else "<f8", count, offset).astype(np.float64)
