"""What people at the viewer's page do to the robot, published like any other leader's wrenches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from follower_humanoid.core.samples import SIDES, Array, Side, Wrench
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.viewer.push import Push

_PUSH = "base/push"
_DEPTH = 10  # reliable: whoever listens understands it
_LAST_WORDS = 10  # as often it is told that a hand was let go, however long that takes on a busy machine


class Leading:
    """Publishers that exist only once they are needed: a leader that does nothing disturbs nobody."""

    def __init__(self, node: Any, robot: RobotModel) -> None:
        """Args: whose publishers, and the robot that is led."""
        self._node, self._robot = node, robot
        self._publishers: dict[str, tuple[Codec, Any]] = {}
        self._owed = dict.fromkeys(SIDES, 0)  # last words that are still to come
        self.push = Push()

    def pull(self, forces: Mapping[Side, Array | None], stamp: int) -> None:
        """Publishes the forces of hands that are held [N], and zero for a while once they are not."""
        for side in SIDES:
            force = forces.get(side)
            if force is not None:
                self._owed[side] = _LAST_WORDS
            elif self._owed[side] == 0:
                continue
            else:
                self._owed[side] -= 1
            self._publish(f"leader/{side.value}_hand/wrench", np.zeros(3) if force is None else force, stamp)

    def go_on_pushing(self, stamp: int) -> None:
        """Publishes what the push is now, while there is one."""
        if self.push.active:
            self._publish(_PUSH, self.push.force(stamp / 1e9), stamp)

    def let_go(self, stamp: int) -> None:
        """Tells that nobody holds on any more."""
        for topic in self._publishers:
            self._publish(topic, np.zeros(3), stamp)

    def _publish(self, topic: str, force: Array, stamp: int) -> None:
        if topic not in self._publishers:
            codec = Codec(topic, self._robot)
            self._publishers[topic] = codec, self._node.create_publisher(codec.message_type, topic, _DEPTH)
        codec, publisher = self._publishers[topic]
        publisher.publish(codec.encode(Wrench(force, np.zeros(3), "world"), max(stamp, 0)))
