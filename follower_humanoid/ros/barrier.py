"""The start barrier: tick 0 begins only when every publisher has found every subscriber it owes a message.

Discovery takes a while, and a message sent before a reader was matched is lost: in a lock-stepped
graph that is a deadlock. Each node checks its own publishers and then announces itself on
`graph/ready`; the simulator starts when all have. It works in any order of starting.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from std_msgs.msg import String

from follower_humanoid.core.cdr import text_of
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.lockstep import CLOCK, hears_clock
from follower_humanoid.graph.wiring import SIMULATOR, nodes_with
from follower_humanoid.ros.qos import LATCHED
from follower_humanoid.ros.validation import MessageError

READY = "graph/ready"
RESET = "graph/reset"
_STRANGERS_TIME = 2.0  # s


def expected_readers(topic: str, present: Collection[str]) -> frozenset[str]:
    """Names of the nodes that must have found a publisher of `topic` before tick 0."""
    readers = {
        name
        for name, node in nodes_with(present).items()
        if topic in node.inputs.values() or (topic == CLOCK and hears_clock(node, present))
    }
    return frozenset((readers | {RECORDER}) & set(present))


class Barrier:
    """Whether all messages of one node will arrive."""

    def __init__(self, node: Node, present: Collection[str]) -> None:
        """Args: whose publishers, and the nodes that run."""
        self._node = node
        self._present = present
        self._publishers: list[tuple[Any, frozenset[str]]] = []
        self._choices: list[tuple[Any, Mapping[str, Sequence[Any]]]] = []
        self._sources: list[tuple[Any, str]] = []
        self._strangers: list[tuple[Any, str]] = []
        self._strangers_here_since: float | None = None

    def watch(self, publisher: Any, readers: Collection[str]) -> None:
        """Adds a publisher and the nodes that must be able to hear it."""
        self._publishers.append((publisher, frozenset(readers)))

    def watch_either(self, publisher: Any, others: Mapping[str, Sequence[Any]]) -> None:
        """Adds a publisher that each reader must be able to hear, or else all the others given for it."""
        self._choices.append((publisher, others))

    def watch_source(self, subscription: Any, producer: str) -> None:
        """Adds a subscription that must have found its publisher: until then what is sent to it is lost."""
        self._sources.append((subscription, producer))

    def watch_stranger(self, subscription: Any, instead_of: str) -> None:
        """Adds a subscription whose publisher may be anybody's."""
        self._strangers.append((subscription, instead_of))

    def waiting_for(self) -> list[str]:
        """What is still missing, one text each; empty when all is found."""
        missing = []
        for publisher, readers in self._publishers:
            absent = self._absent_readers(publisher, readers)
            if absent:
                missing.append(f"{', '.join(absent)} to listen to {publisher.topic_name}")
        for publisher, others in self._choices:
            readers = frozenset(r for r in others if not self._is_heard_by(r, others[r]))
            absent = self._absent_readers(publisher, readers)
            if absent:
                missing.append(f"{', '.join(absent)} to listen to {publisher.topic_name}")
        for subscription, name in self._sources:
            if subscription.get_publisher_count() == 0:
                missing.append(f"{name} to be found at {subscription.topic_name}")
        for subscription, name in self._strangers:
            if subscription.get_publisher_count() == 0:
                missing.append(f"a publisher of {subscription.topic_name} (instead of {name})")
                self._strangers_here_since = None
        if self._strangers and not missing:
            # What a stranger listens to is not known, so it gets time to be found.
            now = time.monotonic()
            self._strangers_here_since = self._strangers_here_since or now
            if now < self._strangers_here_since + _STRANGERS_TIME:
                missing.append("other people's nodes to find what they listen to")
        return missing

    def _is_heard_by(self, reader: str, publishers: Sequence[Any]) -> bool:
        found = (not self._absent_readers(publisher, frozenset({reader})) for publisher in publishers)
        return bool(publishers) and all(found)

    def _absent_readers(self, publisher: Any, readers: frozenset[str]) -> list[str]:
        # The count is of matched endpoints, which is what decides; the graph's list says whose
        # they may be, so that somebody's `ros2 topic echo` is not taken for a controller.
        if publisher.get_subscription_count() < len(readers):
            return sorted(readers)
        infos = self._node.get_subscriptions_info_by_topic(publisher.topic_name)
        infos = [i for i in infos if i.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL]
        namespace = self._node.get_namespace()
        known = {info.node_name for info in infos if info.node_namespace == namespace}
        if readers - known:
            return sorted(readers - known)
        return [] if publisher.get_subscription_count() >= len(infos) else sorted(readers)


def reset_known(name: str, tick: int) -> str:
    """What a node announces once it knows of a reset."""
    return f"{name} resets at {tick}"


class Announcer:
    """Says that a node is ready, at the start and for each reset."""

    def __init__(self, node: Node) -> None:
        """Args: the node that announces itself."""
        self._publisher = node.create_publisher(String, READY, LATCHED)
        self._name = node.get_name()

    def announce(self) -> None:
        """Tells everyone, also those who start later."""
        self._publisher.publish(String(data=self._name))

    def announce_reset(self, tick: int) -> None:
        """Tells the simulator that this node will reset at a tick."""
        self._publisher.publish(String(data=reset_known(self._name, tick)))


class RollCall:
    """Who has announced itself; the simulator holds it.

    Attributes:
        others: Nodes that reset with the simulator; the recorder is awaited at the start only.
    """

    def __init__(
        self,
        node: Node,
        present: Collection[str],
        complete: Callable[[], None],
        reject: Callable[[Exception], None],
    ) -> None:
        """Begins to listen.

        Args:
            node: Who listens.
            present: The nodes that run.
            complete: What to do when the last has spoken.
            reject: Where complaints go.
        """
        self.others = frozenset(name for name in present if name not in (RECORDER, SIMULATOR))
        self._awaited = set(present) - {SIMULATOR}
        self._complete, self._reject = complete, reject
        node.create_subscription(String, READY, self._heard, LATCHED, raw=True)

    def expect_reset(self, tick: int, gone: Collection[str] = ()) -> None:
        """From here on it waits until every node knows of the reset but those that have left."""
        self._awaited = {reset_known(name, tick) for name in self.others if name not in gone}

    def _heard(self, data: bytes) -> None:
        text = text_of(data)
        if text is None:
            self._reject(MessageError(READY, "not a String"))
        elif text in self._awaited:
            self._awaited.discard(text)
            if not self._awaited:
                self._complete()

    def waiting_for(self) -> list[str]:
        """Nodes that are not ready, sorted."""
        return sorted(self._awaited)
