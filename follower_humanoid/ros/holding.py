"""Tells the bag at which ticks the simulator went on without motor commands, so that the drives held.

In real time nobody waits for a command that is late, and how late it is nobody can repeat: what was
done without it belongs to what acted on the robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from std_msgs.msg import Header

from follower_humanoid.bag.recorder import HOLDING
from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.record import Holding
from follower_humanoid.graph.wiring import PRODUCER
from follower_humanoid.ros.barrier import Barrier

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode


class HoldingDrives:
    """Publishes when commands of the graph's own controllers begin to be missing, and when all are back."""

    def __init__(self, node: LockStepNode) -> None:
        """Args: the simulator."""
        self._node = node
        self._publisher: Any = None
        self._commands = [
            topic
            for topic in node.wiring.inputs.values()
            if topic.endswith("/command") and PRODUCER[topic].name in node.present
        ]
        self._missing: tuple[str, ...] = ()

    def open(self, barrier: Barrier) -> None:
        """Makes the publisher; the recorder must have found it before tick 0."""
        self._publisher = self._node.make_publisher(Header, HOLDING)
        barrier.watch(self._publisher, {RECORDER} & self._node.present)

    def note(self, tick: int, samples: Mapping[str, Any]) -> None:
        """Looks at what a step is given; what it does not wait for is not missing."""
        missing = tuple(topic for topic in self._commands if samples.get(topic, True) is None)
        if missing != self._missing:
            self._missing = missing
            stamp = tick * self._node.tick_ns
            self._publisher.publish(holding_message(Holding(tick, missing), stamp))


def holding_message(holding: Holding, stamp: int) -> Header:
    """As it is sent; `stamp` is the time of its tick [ns]."""
    header = Header(frame_id=",".join(holding.topics))
    header.stamp.sec, header.stamp.nanosec = divmod(stamp, NANOSECONDS)
    return header
