"""What a lock-stepped node hears, and by which way each topic comes to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from operator import itemgetter
from typing import TYPE_CHECKING, Any

from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, UInt8MultiArray

from follower_humanoid.core.cdr import HEADER, STAMP_SIZE, stamp_of, text_of
from follower_humanoid.core.topics import PEOPLE
from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import PRODUCER, SIMULATOR, is_optional, nodes_with
from follower_humanoid.ros.barrier import Barrier
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope, comes_by_itself, envelope_topic, hears_slow
from follower_humanoid.ros.envelope_reader import EnvelopeReader
from follower_humanoid.ros.lines import BORN_WITH
from follower_humanoid.ros.mailbox import Mailbox
from follower_humanoid.ros.outlet import ABSENT
from follower_humanoid.ros.qos import LOCKSTEP, UNREAD
from follower_humanoid.ros.validation import MessageError

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode


_Pick = Callable[[Mapping[str, Any]], Any]


def _picker(topics: tuple[str, ...]) -> _Pick:
    """What the lock is given of all that a node publishes: one sample, or those of a piece as a tuple."""
    return (lambda _: True) if topics == (CLOCK,) else itemgetter(*topics)


class Inlet:
    """Brings every input of a node into its lock.

    - From a node in the same process: the sample itself, by the bus.
    - From another process of this graph: as part of the producer's envelope, which comes by a line where both
      processes are of the same bringup.
    - From strangers in place of a node that was left out, and where a topic is remapped: by the public topic.

    Attributes:
        mailbox: The envelopes, where the node is alone in its process.
        copies: Topic → who wants to see the leader's message as it is.
    """

    def __init__(self, node: LockStepNode) -> None:
        """Args: who listens; its lock says to what."""
        self._node = node
        self._skips = node.wiring.period > 1  # a slow node leaves most messages unread
        self.mailbox = Mailbox(node.context)
        self.copies: dict[str, Callable[[bytes], None]] = {}
        by_bus: dict[str, list[str]] = {}
        by_envelope: dict[str, list[str]] = {}
        self._by_topic: list[str] = []
        for topic in node.lock.topics:
            producer = SIMULATOR if topic == CLOCK else PRODUCER[topic].name
            # People's topics: the lock waits for the leader's copy, which only the envelope holds.
            apart = topic not in PEOPLE and comes_by_itself(node, topic)
            if producer not in node.present or apart:
                self._by_topic.append(topic)
            elif node.bus is not None and producer in node.bus:
                by_bus.setdefault(producer, []).append(topic)
            else:
                by_envelope.setdefault(producer, []).append(topic)
        self._by_bus = {producer: tuple(topics) for producer, topics in by_bus.items()}
        self._by_envelope = {producer: tuple(topics) for producer, topics in by_envelope.items()}
        for topics in (*self._by_bus.values(), *self._by_envelope.values()):
            node.lock.put_together(topics)

    def open(self, codecs: Mapping[str, Codec], barrier: Barrier) -> None:
        """Subscribes."""
        node = self._node
        if node.bus is not None:
            for producer, topics in self._by_bus.items():
                node.bus.listen(node.wiring.name, producer, partial(self._accept, topics[0], _picker(topics)))
        table = nodes_with(node.present)
        for producer, topics in self._by_envelope.items():
            reader = EnvelopeReader(Envelope(table[producer]), {t: codecs[t] for t in topics if t != CLOCK})
            topic = envelope_topic(producer, hears_slow(node.wiring, table[producer]))
            deliver = partial(self._deliver, reader, topics)
            line = BORN_WITH.ear_of(node.wiring.name, producer)
            qos = LOCKSTEP if line is None else UNREAD
            subscription = node.make_subscription(UInt8MultiArray, topic, deliver, qos)
            receive = partial(self._receive_envelope, reader, topics)
            missing = partial(node.lock.waits_for, topics[0])
            if line is not None:
                self.mailbox.add_line(line, subscription, receive, missing)
                continue
            barrier.watch_source(subscription, producer)
            if node.bus is None:  # several nodes in one process must not wait for one another's messages
                self.mailbox.add(subscription, receive, missing)
        BORN_WITH.hear_only(node.wiring.name, self._by_envelope)
        for topic in self._by_topic:
            if topic == CLOCK:
                node.make_subscription(Clock, CLOCK, self._receive_clock)
                continue
            hear = partial(self._receive, topic, codecs[topic].decode)
            subscription = node.make_subscription(codecs[topic].message_type, topic, hear)
            if not is_optional(topic):
                barrier.watch_stranger(subscription, PRODUCER[topic].name)
        if self._by_topic:
            node.make_subscription(Header, ABSENT, self._receive_absent)

    def _accept(
        self, first: str, pick: _Pick, tick: int, samples: Mapping[str, Any], messages: Mapping[str, bytes]
    ) -> bool:
        """Takes in what a node of the same process has sent; returns whether the lock is ready now."""
        node = self._node
        if node.away:
            node.come_back(tick)
        if messages:
            for topic in self.copies.keys() & messages.keys():
                self.copies[topic](messages[topic])
        if self._skips and not node.lock.needs(first, tick):
            return False
        return node.lock.put(first, tick, pick(samples))

    def _deliver(self, reader: EnvelopeReader, topics: tuple[str, ...], data: bytes) -> None:
        if self._receive_envelope(reader, topics, data):
            self._node.run_ready_steps()

    def _receive_envelope(self, reader: EnvelopeReader, topics: tuple[str, ...], data: bytes) -> bool:
        """Takes in an envelope; returns whether the lock is ready now."""
        node = self._node
        try:
            stamp = reader.envelope.stamp(data)
            tick, rest = divmod(stamp, node.tick_ns)
            if rest:
                raise MessageError(reader.envelope.name, f"stamp {stamp} ns is no tick")
            # All of it or nothing: what lies beside something unusable is not to be relied on.
            samples = reader.read(data) if not self._skips or node.lock.needs(topics[0], tick) else None
        except MessageError as error:
            node.reject(error)
            return False
        node.come_back(tick)
        if self.copies and samples is not None:
            self._copy(reader, topics, data)
        return samples is not None and self._put(topics, tick, samples)

    def _copy(self, reader: EnvelopeReader, topics: tuple[str, ...], data: bytes) -> None:
        for topic in topics:
            if topic in self.copies and (message := reader.message(data, topic)):
                self.copies[topic](message)

    def _put(self, topics: tuple[str, ...], tick: int, samples: tuple[Any, ...]) -> bool:
        """Puts what came in one piece into the lock; returns whether it is ready now."""
        if topics[0] == CLOCK:
            return self._node.lock.put(CLOCK, tick, True)
        return self._node.lock.put(topics[0], tick, samples if len(topics) > 1 else samples[0])

    def _receive(self, topic: str, decode: Any, data: bytes) -> None:
        node = self._node
        tick, rest = divmod(stamp_of(data), node.tick_ns)
        on_tick = tick if rest == 0 else None
        if on_tick is not None and not node.lock.needs(topic, on_tick):
            return
        try:
            sample = decode(data)
        except MessageError as error:
            node.reject(error)
            if not any(m.topic == topic and m.tick == on_tick for m in node.lock.missing()):
                return
            sample = None  # who keeps the ticks is waited for: what cannot be used counts as none
        if node.lock.put(topic, on_tick, sample):
            node.run_ready_steps()

    def _receive_clock(self, data: bytes) -> None:
        tick = stamp_of(data) // self._node.tick_ns
        self._node.come_back(tick)
        lock = self._node.lock
        if lock.needs(CLOCK, tick) and lock.put(CLOCK, tick, True):
            self._node.run_ready_steps()

    def _receive_absent(self, data: bytes) -> None:
        topic = text_of(data, len(HEADER) + STAMP_SIZE)
        tick = stamp_of(data) // self._node.tick_ns
        if topic in self._by_topic and self._node.lock.put(topic, tick, None):
            self._node.run_ready_steps()
