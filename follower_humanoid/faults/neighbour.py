"""A hostile neighbour: `python -m follower_humanoid.faults.neighbour KIND COUNT` beside a running graph.

KIND is one of

- people: on what people can publish, rubbish, damaged messages, numbers that are none, frames that do not
  exist, stamps of any time, and now and then a pull of a tenth of a newton, from two publishers per topic;
- nodes: on every topic between nodes and on their envelopes, all of it unusable;
- services: parameters that cannot be, transitions that are not possible, questions about nothing.

Messages come in bursts, as fast as they can be sent, COUNT per topic (nodes: on all topics together).
Prints a line of JSON: how much was sent and how fast, what was wrongly accepted, and what the graph's
nodes said of themselves last.
"""

from __future__ import annotations

import json
import random
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import qos_profile_sensor_data
from rclpy.task import Future
from rclpy.utilities import try_shutdown

from follower_humanoid.core.topics import PEOPLE
from follower_humanoid.faults.forgeries import FORGED, Forger, unusable_for_people
from follower_humanoid.faults.hostile_services import Operator
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.barrier import READY
from follower_humanoid.ros.director import reports_in
from follower_humanoid.ros.leaving import LEAVE
from follower_humanoid.ros.qos import DIAGNOSTICS, LATCHED, LOCKSTEP
from follower_humanoid.ros.spin import start_ros

_POOL = 2000  # different messages per topic
_BURST = 500
_DISCOVERY = 3.0  # wall time to learn who is there, and for them to learn of the neighbour [s]
_PATIENCE = 20.0  # wall time that the graph gets to find the neighbour, and to report [s]


class Neighbour:
    """Sends, and listens to what the nodes report meanwhile.

    Attributes:
        node: In the graph's domain.
        reports: Node → key → text, as last reported.
    """

    def __init__(self) -> None:
        """Joins."""
        start_ros(["--ros-args"])
        self.node = Node("neighbour", start_parameter_services=False)
        self.reports: dict[str, dict[str, str]] = {}
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, DIAGNOSTICS, raw=True)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)

    def _hear(self, data: bytes) -> None:
        self.reports.update(reports_in(data, "/"))

    def spin(self, seconds: float, until: Any = None) -> None:
        """Handles what has come."""
        self._executor.spin_until_future_complete(until or Future(), timeout_sec=seconds)

    def spin_until(self, condition: Callable[[], bool]) -> None:
        """Handles what comes until the condition is true, or patience is at an end."""
        end = time.monotonic() + _PATIENCE
        while not condition() and time.monotonic() < end:
            self.spin(0.05)

    def find(self, publishers: Iterable[Publisher]) -> None:
        """Waits until all who are there to hear them do."""
        waiting = [(publisher, publisher.topic_name) for publisher in publishers]
        self.spin(_DISCOVERY)
        self.spin_until(
            lambda: all(
                publisher.get_subscription_count() >= self.node.count_subscribers(topic)
                for publisher, topic in waiting
            )
        )

    def hear_all(self) -> None:
        """Waits until each node that has ever reported does so again."""
        self.spin_until(lambda: SIMULATOR in self.reports)
        known = set(self.reports)
        self.reports.clear()
        self.spin_until(lambda: known <= set(self.reports))

    def close(self) -> None:
        """Leaves."""
        self._executor.shutdown()
        self.node.destroy_node()
        try_shutdown()


def flood_people(neighbour: Neighbour, count: int, rng: random.Random) -> int:
    """From two publishers per topic."""
    senders = []
    for topic in sorted(PEOPLE):
        messages, kind = unusable_for_people(topic, _POOL, rng)
        publishers = [neighbour.node.create_publisher(kind, topic, qos_profile_sensor_data) for _ in range(2)]
        senders.append((publishers, messages))
    neighbour.find(publisher for publishers, _ in senders for publisher in publishers)
    for number in range(count):
        for publishers, messages in senders:
            publishers[rng.randrange(2)].publish(messages[rng.randrange(_POOL)])
        if number % _BURST == 0:
            neighbour.spin(0.001)
    return count * len(senders)


def flood_nodes(neighbour: Neighbour, count: int, rng: random.Random) -> int:
    """Forges what only the graph's own nodes should send."""
    forger = Forger(rng)
    names = sorted(FORGED)
    publishers = {
        name: neighbour.node.create_publisher(
            FORGED[name], name, LATCHED if name in (READY, LEAVE) else LOCKSTEP
        )
        for name in names
    }
    forger.listen(neighbour.node)
    neighbour.find(publishers.values())
    for number in range(count):
        name = names[rng.randrange(len(names))]
        try:
            publishers[name].publish(forger.message(name))
        except rclpy_implementation.RCLError as error:  # a reliable writer waits for slow readers
            if "cannot publish" not in str(error):
                raise
        if number % _BURST == 0:
            neighbour.spin(0.01)
    return count


def main(args: Sequence[str]) -> int:
    """Floods until all is sent."""
    kind, count = args[0], int(args[1])
    neighbour, rng = Neighbour(), random.Random(f"{kind} 1")
    accepted: list[str] = []
    begin = time.monotonic()
    if kind == "services":
        operator = Operator(neighbour.node, lambda future: neighbour.spin(_PATIENCE, future), rng)
        sent, accepted = operator.trouble(count)
    else:
        sent = (flood_people if kind == "people" else flood_nodes)(neighbour, count, rng)
    seconds = time.monotonic() - begin
    neighbour.hear_all()
    told = {"sent": sent, "seconds": seconds, "rate": sent / seconds, "accepted": accepted[:5]}
    print(json.dumps({**told, "reports": neighbour.reports}), flush=True)
    neighbour.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
