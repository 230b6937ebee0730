"""What RViz and Foxglove show of a running robot: markers, and transforms where tf2_msgs is installed."""

from __future__ import annotations

from typing import Any

import numpy as np
from visualization_msgs.msg import MarkerArray

from follower_humanoid.bag.transforms import TransformMessage
from follower_humanoid.robot.transforms import TransformTree
from follower_humanoid.ros.markers import Markers
from follower_humanoid.ros.qos import LATCHED
from follower_humanoid.viewer.moment import Moment
from follower_humanoid.viewer.skeleton import Skeleton

_DEPTH = 10


class Displays:
    """Publishers that do something only while somebody listens.

    Attributes:
        wanted: Whether anybody does.
    """

    def __init__(self, node: Any, urdf: str) -> None:
        """Args: whose publishers, and the text of the URDF."""
        self._markers = Markers(Skeleton(urdf))
        self._tree = TransformTree(urdf)
        self._marked = node.create_publisher(MarkerArray, "markers", _DEPTH)
        self._moved: Any = None
        kind = _transform_type()
        if kind is not None:
            self._moving = TransformMessage(self._tree.moving)
            self._moved = node.create_publisher(kind, "/tf", _DEPTH)
            self._still = node.create_publisher(kind, "/tf_static", LATCHED)
            zero = np.zeros(len(self._tree.joint_names))
            self._tree.place(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), zero)
            fixed = self._tree.poses(self._tree.fixed)
            self._still.publish(TransformMessage(self._tree.fixed).encode(0, fixed))

    @property
    def wanted(self) -> bool:
        """Whether anybody listens."""
        publishers = [self._marked, *([self._moved] if self._moved is not None else [])]
        return any(publisher.get_subscription_count() for publisher in publishers)

    def show(self, moment: Moment) -> None:
        """Publishes a moment to those who listen."""
        if not moment.has_robot:
            return
        if self._marked.get_subscription_count():
            self._marked.publish(self._markers.of(moment))
        if self._moved is not None and self._moved.get_subscription_count():
            base = moment["odom"]
            self._tree.place(base.position, base.quat_xyzw, moment["joint_states"].position)
            poses = self._tree.poses(self._tree.moving)
            self._moved.publish(self._moving.encode(round(moment.time * 1e9), poses))


def _transform_type() -> Any:
    """The message type of transforms; None where tf2_msgs is not installed."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return None
    return TFMessage
