"""A node that was left behind leaves the lock-step, and comes back into it where the others are by then.

That happens in real time only, where the simulator goes on without a node that is silent. On
`graph/leave` the node says which tick is the first without it; from there on nobody waits for what it
publishes. It goes on with a tick a little ahead of what it hears, so that none of its inputs can have
gone by, and says so too.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import String

from follower_humanoid.core.cdr import text_of
from follower_humanoid.ros.qos import LATCHED
from follower_humanoid.ros.validation import MessageError

LEAVE = "graph/leave"
AHEAD = 5  # ticks
_LEAVES = re.compile(r"(\w+) leaves at ([0-9]{1,18})")
_BACK = re.compile(r"(\w+) is back at ([0-9]{1,18})")


class Attendance:
    """Who has left, as one node knows it.

    Attributes:
        gone: Node → first tick without it; those that are back are not in it.
    """

    def __init__(
        self, node: Node, left: Callable[[str, int], None], reject: Callable[[Exception], None]
    ) -> None:
        """Begins to listen.

        Args:
            node: Who is told.
            left: What to do when another one has left: name, first tick without it.
            reject: Where complaints go.
        """
        self._name: str = node.get_name()
        self._left, self._reject = left, reject
        self.gone: dict[str, int] = {}
        self._publisher = node.create_publisher(String, LEAVE, LATCHED)
        node.create_subscription(String, LEAVE, self._heard, LATCHED, raw=True)

    def leave(self, tick: int) -> None:
        """Tells everyone, also those who start later."""
        self._publisher.publish(String(data=f"{self._name} leaves at {tick}"))

    def come_back(self, tick: int) -> None:
        """Tells everyone from which tick on this node publishes again."""
        self._publisher.publish(String(data=f"{self._name} is back at {tick}"))

    def _heard(self, data: bytes) -> None:
        text = text_of(data) or ""
        if found := _LEAVES.fullmatch(text):
            name, tick = found.group(1), int(found.group(2))
            if name != self._name:
                self.gone[name] = tick
                self._left(name, tick)
        elif found := _BACK.fullmatch(text):
            self.gone.pop(found.group(1), None)
        else:
            self._reject(MessageError(LEAVE, "nobody's word for leaving or coming back"))
