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
from follower_humanoid.ros.envelope_reader import EnvelopeReader
from follower_humanoid.ros.validation import MessageError

NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_SHOWN_AFTER = 1.0  # wall time within which a node that shows its samples is found [s]


class _Window:
    """What one node shows.

    Attributes:
        reader: Reads it.
        topics: What is wanted of it.
        subscription: Where it comes in.
        since: When it was last seen to be there, or begun to be looked for.
    """

    def __init__(self, node: Any, name: str, topics: tuple[str, ...], codecs: dict[str, Codec]) -> None:
        self.topics = topics
        wanted = {topic: codecs[topic] for topic in topics}
        self.reader = EnvelopeReader(Envelope(PRODUCER[topics[0]]), wanted)
        self.subscription = node.create_subscription(
            UInt8MultiArray, seen_topic(name), _drop, NEWEST, raw=True
        )
        self.since = time.monotonic()

    def is_empty(self, now: float) -> bool:
        """Whether nobody shows anything there."""
        if self.subscription.get_publisher_count():
            self.since = now
        return now - self.since > _SHOWN_AFTER


class Newest:
    """Subscriptions of a node that an executor need not know.

    Attributes:
        samples: Topic → newest sample; the same object until another message has come.
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
        self.samples: dict[str, Any] = {}
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
        self._windows = [
            _Window(self._node, name, tuple(topics), self._codecs) for name, topics in shown.items()
        ]

    def close(self) -> None:
        """Unsubscribes; what has been seen stays."""
        subscriptions = list(self.subscriptions)
        self._windows, self._by_name = [], {}
        for subscription in subscriptions:
            self._node.destroy_subscription(subscription)

    def look(self, clock: str) -> bool:
        """Takes in what has come; True where the topic `clock` had something new."""
        now, before = time.monotonic(), self.samples.get(clock)
        for window in self._windows:
            self._choose_way(window, window.is_empty(now))
            data = _take(window.subscription)
            try:
                if data is not None:
                    self._take_in(window, data, clock)
            except MessageError as error:
                self._reject(error)
        for topic, subscription in self._by_name.items():
            data = _take(subscription)
            try:
                if data is not None:
                    self.samples[topic] = self._codecs[topic].decode(data)
                    if topic == clock:
                        self.stamp = stamp_of(data)
            except MessageError as error:
                self._reject(error)
        return self.samples.get(clock) is not before

    def forget(self) -> None:
        """Drops what is no longer new."""
        self.samples = {}

    def _take_in(self, window: _Window, data: bytes, clock: str) -> None:
        stamp = window.reader.envelope.stamp(data)
        samples = window.reader.read(data)
        self.samples |= {t: s for t, s in zip(window.topics, samples, strict=True) if s is not None}
        if clock in window.topics:
            self.stamp = stamp

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
    """The newest message in a subscription's queue, if there is one."""
    newest: bytes | None = None
    handle, message_type = subscription.handle, subscription.msg_type
    with handle:
        while (taken := handle.take_message(message_type, True)) is not None:
            newest = taken[0]
    return newest


def _drop(_: bytes) -> None:
    """Never called: the queues are emptied by hand."""
