"""The newest sample of some topics, decoded when somebody looks: an observer that costs next to nothing.

Nothing is spun. The middleware keeps one message per subscription and drops the ones before it; how often
somebody looks does not depend on how fast the graph runs. Nodes of a running graph show what they have
published last (`ros/exhibit.py`); what nobody shows (a replayed bag, a node of somebody's own, a remapped
topic) is heard by its name.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import UInt8MultiArray

from follower_humanoid.core.cdr import stamp_of
from follower_humanoid.graph.wiring import PRODUCER
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope, comes_by_itself, seen_topic
from follower_humanoid.ros.glance import Glance
from follower_humanoid.ros.validation import MessageError

NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_SHOWN_AFTER = 1.0  # wall time within which a node that shows its samples is found [s]
_CHOOSE_EVERY = 0.2  # wall time between two looks for such nodes [s]


class _Window:
    """What one node shows.

    Attributes:
        envelope: How it is packed.
        topics: What is wanted of it.
        subscription: Where it comes in.
        since: When it was last seen to be there, or begun to be looked for.
    """

    def __init__(self, node: Any, name: str, topics: tuple[str, ...]) -> None:
        self.topics = topics
        self.envelope = Envelope(PRODUCER[topics[0]])
        self._rows = [self.envelope.topics.index(topic) for topic in topics]
        self.subscription = node.create_subscription(
            UInt8MultiArray, seen_topic(name), _drop, NEWEST, raw=True
        )
        self.since = time.monotonic()

    def is_empty(self, now: float) -> bool:
        """Whether nobody shows anything there."""
        if self.subscription.get_publisher_count():
            self.since = now
        return now - self.since > _SHOWN_AFTER

    def open(self, data: bytes) -> tuple[int, Iterator[tuple[str, bytes]]]:
        """Stamp [ns], and what is wanted, as topics and messages.

        Raises:
            MessageError: Not an envelope of this node.
        """
        stamp, messages = self.envelope.open(data)
        return stamp, (
            (topic, messages[row])
            for topic, row in zip(self.topics, self._rows, strict=True)
            if messages[row]
        )


class Newest:
    """Subscriptions of a node that an executor need not know.

    Attributes:
        samples: What has come.
        stamp: Of the newest message of the topic that is the clock [ns].
    """

    def __init__(
        self, node: Any, topics: Iterable[str], robot: RobotModel, reject: Callable[[Exception], None]
    ) -> None:
        """Args: whose subscriptions, to what, and where complaints about messages go."""
        self._node, self._reject = node, reject
        self._codecs = {topic: Codec(topic, robot) for topic in topics}
        self._windows: list[_Window] = []
        self._by_name: dict[str, Any] = {}
        self.samples = Glance(self._codecs, reject)
        self._chosen, self._looks = -_CHOOSE_EVERY, 0
        self.stamp = -1

    @property
    def listening(self) -> bool:
        """Whether there are subscriptions."""
        return bool(self._windows or self._by_name)

    @property
    def subscriptions(self) -> Iterator[Any]:
        """All of them."""
        yield from (window.subscription for window in self._windows)
        yield from self._by_name.values()

    def listen(self) -> None:
        """Subscribes."""
        shown: dict[str, list[str]] = {}
        for topic in self._codecs:
            if comes_by_itself(self._node, topic):
                self._listen_by_name(topic)
            else:
                shown.setdefault(PRODUCER[topic].name, []).append(topic)
        self._windows = [_Window(self._node, name, tuple(topics)) for name, topics in shown.items()]

    def close(self) -> None:
        """Unsubscribes; what has been seen stays."""
        subscriptions = list(self.subscriptions)
        self._windows, self._by_name = [], {}
        for subscription in subscriptions:
            self._node.destroy_subscription(subscription)

    def look(self, clock: str) -> bool:
        """Takes in what has come; True where the topic `clock` had something new."""
        before = self.samples.get(clock)
        self._choose_ways(time.monotonic())
        self._looks += 1
        for window in self._windows:
            if self._looks % 2 and clock not in window.topics:  # these show something half as often
                continue
            data = _take(window.subscription)
            try:
                if data is not None:
                    self._take_in(window, data, clock)
            except MessageError as error:
                self._reject(error)
        for topic, subscription in self._by_name.items():
            data = _take(subscription)
            if data is not None:
                self.samples.put(topic, data)
                if topic == clock:
                    self.stamp = stamp_of(data)
        return self.samples.get(clock) is not before

    def forget(self) -> None:
        """Drops what is no longer new."""
        self.samples.forget()

    def _take_in(self, window: _Window, data: bytes, clock: str) -> None:
        stamp, messages = window.open(data)
        for topic, message in messages:
            self.samples.put(topic, message)
        if clock in window.topics:
            self.stamp = stamp

    def _choose_ways(self, now: float) -> None:
        """Looks now and then who shows anything."""
        if now - self._chosen > _CHOOSE_EVERY:
            self._chosen = now
            for window in self._windows:
                self._choose_way(window, window.is_empty(now))

    def _choose_way(self, window: _Window, empty: bool) -> None:
        """Hears topics by name while nobody shows them, and no longer."""
        for topic in window.topics:
            if empty and topic not in self._by_name:
                self._listen_by_name(topic)
            elif not empty and topic in self._by_name:
                self._node.destroy_subscription(self._by_name.pop(topic))

    def _listen_by_name(self, topic: str) -> None:
        self._by_name[topic] = self._node.create_subscription(
            self._codecs[topic].message_type, topic, _drop, NEWEST, raw=True
        )


def _take(subscription: Any) -> bytes | None:
    """The message in a subscription's queue, which holds one, if there is one."""
    with subscription.handle:
        taken = subscription.handle.take_message(subscription.msg_type, True)
    return None if taken is None else taken[0]


def _drop(_: bytes) -> None:
    """Never called: the queues are emptied by hand."""
