"""Tells the bag which parameters were changed during the run, and from which tick on.

`/parameter_events` would not do: it says when by the wall's clock, and a repetition needs the tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter

from follower_humanoid.bag.recorder import ADJUSTED
from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.ros.barrier import Barrier

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode


class AdjustedParameters:
    """Publishes the changes of one node; those from before the start count from its first tick on."""

    def __init__(self, node: LockStepNode) -> None:
        """Args: whose parameters."""
        self._node = node
        self._publisher: Any = None
        self._untold: list[ParameterEvent] = []

    def open(self, barrier: Barrier) -> None:
        """Makes the publisher; the recorder must have found it before tick 0."""
        self._publisher = self._node.make_publisher(ParameterEvent, ADJUSTED)
        barrier.watch(self._publisher, {RECORDER} & self._node.present)

    def note(self, changed: Sequence[Parameter]) -> None:
        """Parameters have just got other values, which the next step will be the first to use."""
        values = [parameter.to_parameter_msg() for parameter in changed]
        self._untold.append(ParameterEvent(node=self._node.get_name(), changed_parameters=values))
        if self._node.started:
            self.tell()

    def tell(self) -> None:
        """Publishes what has been noted, with the time of the next step."""
        stamp = self._node.lock.tick * self._node.tick_ns
        for event in self._untold:
            event.stamp.sec, event.stamp.nanosec = divmod(stamp, NANOSECONDS)
            self._publisher.publish(event)
        self._untold.clear()
