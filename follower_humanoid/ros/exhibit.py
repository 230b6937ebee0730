"""Shows observers what a node has published last, far less often than it publishes.

Nobody who only looks needs every tick, and a message for each of a node's topics at every tick would slow the
graph down whenever somebody opens a page. A topic that is published on change stays as it was.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from std_msgs.msg import UInt8MultiArray

from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.envelope import seen_topic
from follower_humanoid.ros.envelope_writer import EnvelopeWriter

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode

# Wall time between two looks at the body, somewhat less than between two pictures of a page; what else there
# is to see is drawn less often [s].
BODY_EVERY, EVERY = 0.025, 0.06


class Exhibit:
    """What an observer sees of one node."""

    def __init__(
        self, node: LockStepNode, writer: EnvelopeWriter, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Makes the publisher. Args: the node, what writes its envelopes, and the wall's time [s]."""
        self._writer = writer
        self._clock = clock
        self._shown_at = -math.inf
        self._publisher = node.make_publisher(UInt8MultiArray, seen_topic(node.wiring.name))
        self._newest: dict[str, Any] = dict.fromkeys(node.wiring.outputs.values())
        self._every = BODY_EVERY if node.wiring.name == SIMULATOR else EVERY
        self._watched = False

    def look(self) -> None:
        """Finds out whether anybody watches."""
        self._watched = self._publisher.get_subscription_count() > 0

    def show(self, samples: Mapping[str, Any], stamp: int) -> None:
        """Takes in a tick's samples and shows the newest ones when it is time; `stamp` in [ns]."""
        if not self._watched:
            return
        for topic, sample in samples.items():
            if sample is not None:
                self._newest[topic] = sample
        now = self._clock()
        if now >= self._shown_at + self._every:
            self._shown_at = now
            self._publisher.publish(self._writer.seal(self._newest, stamp)[0])
