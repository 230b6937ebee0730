"""What the recorder listens to: the envelopes of the graph's nodes, everything else by its name.

Envelopes come by lines where recorder and node are of one bringup, else by a subscription. Neither is
spun: their queues are emptied on a visit. That costs less than callbacks, and a message then brings the
times at which it was sent and received.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.recorder import STATE, Arrival, Recorded, Recording, recorded_topics
from follower_humanoid.core.cdr import LARGEST_STAMP, clock_bytes
from follower_humanoid.core.topics import PEOPLE
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import SIMULATOR, nodes_with
from follower_humanoid.ros.envelope import Envelope, comes_by_itself, envelope_topic
from follower_humanoid.ros.lines import BORN_WITH, Ear
from follower_humanoid.ros.outgoing import SLOT
from follower_humanoid.ros.parcel import unpacked
from follower_humanoid.ros.qos import UNREAD
from follower_humanoid.ros.validation import MessageError

if TYPE_CHECKING:
    from follower_humanoid.ros.recorder_node import RecorderNode

# Four seconds of the fastest topic: a disk may hesitate that long.
_DEPTH = 2000
_RELIABLE, _BEST_EFFORT = (
    QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=_DEPTH, reliability=policy)
    for policy in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
)
# At least so many of the largest messages fit into a line; more waits where they come from.
_FULL = 13
_ENVELOPE = "std_msgs/msg/UInt8MultiArray"
# A node of this package has an envelope; whoever publishes without one for longer is a stranger [s].
_STRANGE_AFTER = 1.0


@dataclass
class _EnvelopeTap:
    """The envelopes of one node.

    Attributes:
        envelope: Opens them.
        parts: What each message in it is; None where it is not taken from here.
        clock: The clock, which the simulator's envelopes stand for.
        line: Where they come in; None where they come in by the subscription.
        subscription: Shows who hears whom.
        strange_since: When topics of the node were first seen without its envelope.
    """

    envelope: Envelope
    parts: tuple[Recorded | None, ...]
    clock: Recorded | None
    line: Ear | None
    subscription: Any
    strange_since: float | None = field(default=None)

    @property
    def topics(self) -> Iterator[Recorded]:
        """All that comes this way."""
        yield from (part for part in (*self.parts, self.clock) if part is not None)


class _LeaderCopies:
    """Messages that the leader sends in its envelope and by name: each is kept once, whichever comes first.

    People publish by the same names, best effort perhaps, so that what is heard there may be lost; the
    envelopes are not. A person's message is in none of them and is kept however often it comes.
    """

    def __init__(self) -> None:
        self._seen: dict[bool, dict[tuple[str, bytes], None]] = {False: {}, True: {}}

    def is_new(self, topic: str, data: bytes, sealed: bool) -> bool:
        """Whether a message has not come the other way; `sealed`: it came in an envelope."""
        key = (topic, data)
        if key in self._seen[not sealed]:
            del self._seen[not sealed][key]
            return False
        mine = self._seen[sealed]
        mine[key] = None
        if len(mine) > _DEPTH:
            del mine[next(iter(mine))]
        return True


class RecorderTaps:
    """The recorder's subscriptions."""

    def __init__(self, node: RecorderNode) -> None:
        """Args: who listens."""
        self._node = node
        self._by_name: dict[str, tuple[Recorded, Any]] = {}
        self._envelopes: dict[str, _EnvelopeTap] = {}  # by who sends them
        self._lines: list[Ear] = []
        self._copies = _LeaderCopies()

    def open(self, slot: int) -> None:
        """Subscribes.

        Args:
            slot: Of topics that are thinned out the bag keeps the first message in each such time [ns].
                Who sends to nobody else is told.
        """
        waiting = {topic.name: topic for topic in recorded_topics()}
        for name, wiring in nodes_with(self._node.present).items():
            envelope = Envelope(wiring)
            # Those of people the leader may send in its envelope only.
            mine = {t for t in envelope.topics if t in PEOPLE or not comes_by_itself(self._node, t)}
            if name not in self._node.present or not mine:
                continue
            parts = tuple(waiting[topic] if topic in mine else None for topic in envelope.topics)
            for heard in mine - PEOPLE:  # those of people are heard by name too
                del waiting[heard]
            with_clock = name == SIMULATOR and not comes_by_itself(self._node, CLOCK)
            clock = waiting.pop(CLOCK) if with_clock else None
            line = BORN_WITH.ear_of(RECORDER, name)
            if line is not None and line not in self._lines:
                line.say(SLOT.pack(slot))
                self._lines.append(line)
            qos = _RELIABLE if line is None else UNREAD
            subscription = self._subscribe(_ENVELOPE, envelope_topic(name), qos)
            self._envelopes[name] = _EnvelopeTap(envelope, parts, clock, line, subscription)
        BORN_WITH.hear_only(RECORDER, self._envelopes)
        for topic in waiting.values():
            self._listen(topic)

    def close(self) -> None:
        """Unsubscribes."""
        BORN_WITH.hear_only(RECORDER, ())
        for subscription in list(self.subscriptions):
            self._node.destroy_subscription(subscription)
        self._by_name.clear()
        self._envelopes.clear()
        self._lines.clear()

    @property
    def subscriptions(self) -> Iterator[Any]:
        """All of them, which no executor has to look after."""
        yield from (subscription for _, subscription in self._by_name.values())
        yield from (tap.subscription for tap in self._envelopes.values())

    def take(self, recording: Recording) -> bool:
        """Empties the queues; returns whether a line was full, so that there is likely to be more soon."""
        for topic, subscription in list(self._by_name.values()):
            for data, received, published in _queue(subscription):
                if topic.name not in PEOPLE or self._copies.is_new(topic.name, data, sealed=False):
                    recording.take(Arrival(topic, data, received, published))
        for tap in self._envelopes.values():
            if tap.line is None:
                for data, received, published in _queue(tap.subscription):
                    self._open(tap, data, (received, published), recording)
        full = False
        for line in self._lines:
            count = 0
            while (parcel := line.take()) is not None:
                count += 1
                for sender, data, at in unpacked(parcel):
                    if sender in self._envelopes:
                        self._open(self._envelopes[sender], data, (at, at), recording)
            full = full or count >= _FULL
        return full

    def _open(self, tap: _EnvelopeTap, data: bytes, times: tuple[int, int], recording: Recording) -> None:
        """Hands on what is in an envelope; `times` as of an arrival."""
        try:
            stamp, messages = tap.envelope.open(data)
            if not 0 <= stamp <= LARGEST_STAMP:
                raise MessageError(tap.envelope.name, f"stamp {stamp} ns is no time")
        except MessageError as error:
            self._node.reject(error)
            return
        if tap.clock is not None:
            recording.take(Arrival(tap.clock, clock_bytes(stamp), *times))
        for part, message in zip(tap.parts, messages, strict=True):
            if part is None or not message:
                continue
            if part.name not in PEOPLE or self._copies.is_new(part.name, message, sealed=True):
                recording.take(Arrival(part, message, *times))

    def hears_everyone(self) -> bool:
        """Whether every node of the graph has been found, by its envelope or by its topics."""
        return all(
            tap.subscription.get_publisher_count() or all(self._publishers(topic) for topic in tap.topics)
            for tap in self._envelopes.values()
        )

    def has_simulator(self) -> bool:
        """Whether anybody is there who sends states."""
        states = (tap for tap in self._envelopes.values() if any(topic.name == STATE for topic in tap.topics))
        by_envelope = any(tap.subscription.get_publisher_count() for tap in states)
        return by_envelope or self._publishers_of(STATE) > 0

    def look_for_strangers(self) -> None:
        """Listens by name to those who took the place of a node and send no envelopes."""
        for tap in self._envelopes.values():
            published = [topic for topic in tap.topics if self._node.count_publishers(topic.name)]
            if tap.subscription.get_publisher_count() or not published:
                tap.strange_since = None
                continue
            tap.strange_since = tap.strange_since or time.monotonic()
            if time.monotonic() - tap.strange_since > _STRANGE_AFTER:
                for topic in published:
                    self._listen(topic)

    def announce(self, topic: Recorded) -> tuple[str, list[dict[str, Any]]]:
        """Full name of a topic, and the QoS that its publishers offer."""
        name = str(self._node.resolve_topic_name(topic.name))
        profiles = [info.qos_profile for info in self._node.get_publishers_info_by_topic(name)]
        offered = [offered_qos(p.reliability.name.lower(), p.durability.name.lower()) for p in profiles]
        return name, offered or [offered_qos()]

    def _publishers(self, topic: Recorded) -> int:
        return self._publishers_of(topic.name)

    def _publishers_of(self, name: str) -> int:
        return int(self._by_name[name][1].get_publisher_count()) if name in self._by_name else 0

    def _listen(self, topic: Recorded) -> None:
        if topic.name not in self._by_name:
            # Reliable for what our own nodes send; best effort hears every publisher.
            qos = _RELIABLE if topic.lockstepped else _BEST_EFFORT
            subscription = self._subscribe(topic.type_name, topic.name, qos)
            self._by_name[topic.name] = topic, subscription

    def _subscribe(self, type_name: str, topic: str, qos: QoSProfile) -> Any:
        package, _, name = type_name.partition("/msg/")
        message_type = getattr(importlib.import_module(f"{package}.msg"), name)
        return self._node.create_subscription(message_type, topic, lambda _: None, qos, raw=True)


def _queue(subscription: Any) -> Iterator[tuple[bytes, int, int]]:
    """What waits there: bytes, and the times of receipt and sending since the epoch [ns]."""
    handle, message_type = subscription.handle, subscription.msg_type
    with handle:
        while (taken := handle.take_message(message_type, True)) is not None:
            data, info = taken
            yield data, info["received_timestamp"], info["source_timestamp"]
