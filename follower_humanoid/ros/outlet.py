"""What a lock-stepped node sends in a tick, each way as far as somebody listens there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from std_msgs.msg import Header, UInt8MultiArray

from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.core.topics import PEOPLE
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import NODES, SIMULATOR, NodeWiring, is_same_tick, nodes_with
from follower_humanoid.ros.barrier import Barrier, expected_readers
from follower_humanoid.ros.cdr import CdrWriter
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope, envelope_topic, hears_slow
from follower_humanoid.ros.envelope_writer import EnvelopeWriter
from follower_humanoid.ros.exhibit import Exhibit
from follower_humanoid.ros.listeners import Listeners
from follower_humanoid.ros.outgoing import Outgoing

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode

ABSENT = "graph/absent"
LOOK_EVERY = 25  # messages, of the simulator ticks, between two looks for new listeners
_READ_BY_NODES = frozenset(topic for node in NODES.values() for topic in node.inputs.values())


class _Nothing:
    """Outputs of a node that has nothing to say."""

    def __getattr__(self, name: str) -> None:
        return None


NOTHING = _Nothing()


def _used_by_slow_nodes(producer: NodeWiring, nodes: Iterable[NodeWiring]) -> Iterator[tuple[int, int]]:
    """Which ticks slow nodes use: lag and period; tick k where k + lag is a multiple of the period."""
    for reader in nodes:
        if not hears_slow(reader, producer):
            continue
        if producer.name == SIMULATOR:  # its clock
            yield 0, reader.period
        for topic in reader.inputs.values():
            if topic in producer.outputs.values():
                yield 0 if is_same_tick(topic) else producer.period, reader.period


class Outlet:
    """Sends a node's outputs: to its own process, to other processes of the graph, and to the public.

    A public topic without subscribers costs nothing: its message is not even made.
    """

    def __init__(self, node: LockStepNode, codecs: Mapping[str, Codec]) -> None:
        """Makes the publishers. Args: who sends, and a codec per topic."""
        self._node = node
        self._fields = tuple(node.wiring.outputs.items())
        self._codecs = codecs
        self._envelope = Envelope(node.wiring)
        self._writer = EnvelopeWriter(self._envelope, codecs)
        self._public = {
            topic: node.make_publisher(codecs[topic].message_type, topic) for topic in self._envelope.topics
        }
        self._sealed = node.make_publisher(UInt8MultiArray, envelope_topic(node.wiring.name))
        self._slow_ticks = set(_used_by_slow_nodes(node.wiring, nodes_with(node.present).values()))
        self._slow: Any = None
        if self._slow_ticks:
            self._slow = node.make_publisher(UInt8MultiArray, envelope_topic(node.wiring.name, slow=True))
        self._absent = node.make_publisher(Header, ABSENT)
        self._lines = Outgoing(node.wiring, nodes_with(node.present))
        self._exhibit = Exhibit(node, self._writer)
        self._sent = 0
        self._heard: dict[str, Any] = {}
        self._absent_heard = False
        # Where a node was left out somebody may take its place at any moment: it is not looked for first.
        readers = {name for topic in self._envelope.topics for name in expected_readers(topic, NODES)}
        hearers = self._lines.hearers if readers <= set(node.present) else frozenset
        self._sealed_listeners = Listeners(node, self._sealed, hearers)
        self._slow_listeners = None if self._slow is None else Listeners(node, self._slow, hearers)
        # What people publish simulator and recorder hear by its name too, and need only from others.
        self._listeners = {
            topic: Listeners(node, publisher, self._kin if topic in PEOPLE else frozenset)
            for topic, publisher in self._public.items()
        }

    def watch(self, barrier: Barrier, more_ways: Mapping[str, Sequence[Any]]) -> None:
        """Tells the barrier who must be found before the first message.

        Args:
            barrier: Of the node.
            more_ways: Reader → publishers which it may listen to instead of the envelope.
        """
        node, apart = self._node, self._node.graph.heard_by_topic
        ways = {reader: list(publishers) for reader, publishers in more_ways.items()}
        for topic, publisher in self._public.items():
            readers = expected_readers(topic, node.present)
            if topic in PEOPLE:  # by name the simulator always listens, and there as to anybody
                barrier.watch(publisher, readers)
                ways.update({reader: [] for reader in readers - {RECORDER}})
            elif topic in apart:
                barrier.watch(publisher, readers & {RECORDER})
            else:  # one that takes this node for a stranger goes by names
                for reader in readers:
                    needed = [] if reader == RECORDER else [self._absent]
                    ways.setdefault(reader, needed).append(publisher)
        barrier.watch(self._absent, ())
        table = nodes_with(node.present)
        others = {reader: p for reader, p in ways.items() if not node.shares_process(reader)}
        slow = {reader for reader in others if reader in table and hears_slow(table[reader], node.wiring)}
        barrier.watch_either(self._sealed, {r: p for r, p in others.items() if r not in slow})
        if slow:
            barrier.watch_either(self._slow, {r: p for r, p in others.items() if r in slow})

    def look(self) -> None:
        """Finds out who listens."""
        self._heard = {t: p for t, p in self._public.items() if self._listeners[t].look()}
        self._sealed_listeners.look()
        if self._slow_listeners is not None:
            self._slow_listeners.look()
        self._absent_heard = self._absent.get_subscription_count() > 0
        self._exhibit.look()
        self._lines.look()

    def send(self, outputs: Any, tick: int) -> None:
        """Sends every output that is there, and says of the others that they are not."""
        if self._sent % LOOK_EVERY == 0:
            self.look()
        self._sent += 1
        node = self._node
        stamp = tick * node.tick_ns
        samples = {topic: getattr(outputs, name) for name, topic in self._fields}
        slow_heard = self._slow_listeners is not None and self._slow_listeners.others
        of_slow = (slow_heard or self._lines.reach_slow) and self._is_used_by_slow(tick)
        sealed = self._sealed_listeners.others
        messages: dict[str, bytes] = {}
        whole = sealed or of_slow or self._lines.reach_quick
        if whole or self._lines.recorded:  # first what others wait for
            kept = samples if whole or self._heard else self._lines.kept(samples, stamp)
            data, places = self._writer.seal(kept, stamp)
            self._lines.send(data, of_slow)
            if sealed:
                self._sealed.publish(data)
            if of_slow and slow_heard:
                self._slow.publish(data)
            if self._heard:
                messages = {topic: data[places[topic]] for topic in self._heard if topic in places}
        elif self._heard:
            messages = {
                topic: self._codecs[topic].encode(samples[topic], stamp)
                for topic in self._heard
                if samples[topic] is not None
            }
        if node.bus is not None:
            node.bus.post(node.wiring.name, tick, samples, messages)
        for topic, message in messages.items():
            self._heard[topic].publish(message)
        self._exhibit.show(samples, stamp)
        if self._absent_heard:
            for topic, sample in samples.items():
                if sample is None and topic in _READ_BY_NODES:
                    self._say_absent(topic, stamp)

    def _is_used_by_slow(self, tick: int) -> bool:
        return any((tick + lag) % period == 0 for lag, period in self._slow_ticks)

    def flush(self) -> int:
        """Sends what others had no room for; returns how many messages are left."""
        return self._lines.flush()

    @property
    def lost(self) -> int:
        """Messages that somebody did not listen to for too long to get them."""
        return self._lines.lost

    def _kin(self) -> frozenset[str]:
        """Who of simulator and recorder gets the leader's messages without their names."""
        hearers = self._lines.hearers()
        return frozenset(n for n in (SIMULATOR, RECORDER) if n in hearers or self._node.shares_process(n))

    def _say_absent(self, topic: str, stamp: int) -> None:
        header = Header(frame_id=topic)
        header.stamp.sec, header.stamp.nanosec = divmod(stamp, NANOSECONDS)
        self._absent.publish(bytes(CdrWriter(header).data))
