"""The newest message of some topics, decoded when somebody looks: an observer that costs next to nothing.

Nothing is spun. The middleware keeps one message per topic and drops the ones before it; how often somebody
looks does not depend on how fast the graph runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from follower_humanoid.core.cdr import stamp_of
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.validation import MessageError

NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class Newest:
    """Subscriptions of a node that an executor need not know.

    Attributes:
        samples: Topic → newest sample; the same object until another message has come.
        stamp: Of the newest message that has a stamp at its head [ns].
    """

    def __init__(
        self, node: Any, topics: Iterable[str], robot: RobotModel, reject: Callable[[Exception], None]
    ) -> None:
        """Args: whose subscriptions, to what, and where complaints about messages go."""
        self._node, self._reject = node, reject
        self._codecs = {topic: Codec(topic, robot) for topic in topics}
        self.subscriptions: dict[str, Any] = {}
        self.samples: dict[str, Any] = {}
        self.stamp = -1

    @property
    def listening(self) -> bool:
        """Whether there are subscriptions."""
        return bool(self.subscriptions)

    def listen(self) -> None:
        """Subscribes."""
        for topic, codec in self._codecs.items():
            self.subscriptions[topic] = self._node.create_subscription(
                codec.message_type, topic, _drop, NEWEST, raw=True
            )

    def close(self) -> None:
        """Unsubscribes; what has been seen stays."""
        subscriptions, self.subscriptions = self.subscriptions, {}
        for subscription in subscriptions.values():
            self._node.destroy_subscription(subscription)

    def look(self, clock: str) -> bool:
        """Takes in what has come; True where the topic `clock` had something new."""
        moved = False
        for topic, subscription in self.subscriptions.items():
            data = _take(subscription)
            if data is None:
                continue
            try:
                self.samples[topic] = self._codecs[topic].decode(data)
            except MessageError as error:
                self._reject(error)
                continue
            if topic == clock:
                moved, self.stamp = True, stamp_of(data)
        return moved

    def forget(self) -> None:
        """Drops what is no longer new."""
        self.samples = {}


def _take(subscription: Any) -> bytes | None:
    """The newest message in a subscription's queue, if there is one."""
    newest: bytes | None = None
    handle, message_type = subscription.handle, subscription.msg_type
    with handle:
        while (taken := handle.take_message(message_type, True)) is not None:
            newest = taken[0]
    return newest


def _drop(_: bytes) -> None:
    """Never called: the queues are emptied by hand."""
