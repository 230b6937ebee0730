"""The lines that lead from a node to others, see `lines`: its envelopes go out there."""

from __future__ import annotations

import struct
import time
from collections.abc import Mapping

from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import NodeWiring
from follower_humanoid.ros.envelope import hears_slow
from follower_humanoid.ros.lines import BORN_WITH

SENT_AT = struct.Struct("<q")
"""Before an envelope for the recorder: when it was sent, since the epoch [ns]."""


class Outgoing:
    """Whom a node reaches by a line.

    Attributes:
        reach_quick: Whether anybody hears every tick.
        reach_slow: Whether anybody hears those that slow nodes use.
    """

    def __init__(self, node: NodeWiring, table: Mapping[str, NodeWiring]) -> None:
        """Args: the node, and everyone by name."""
        self._mouths = BORN_WITH.mouths_of(node.name)
        nodes = {name: mouth for name, mouth in self._mouths.items() if name != RECORDER}
        self._recorder = self._mouths.get(RECORDER)
        self._slow = [mouth for name, mouth in nodes.items() if hears_slow(table[name], node)]
        self._quick = [mouth for mouth in nodes.values() if mouth not in self._slow]
        self.reach_quick = bool(self._quick or self._recorder is not None)
        self.reach_slow = bool(self._slow)

    def hearers(self) -> frozenset[str]:
        """Names of all who hear it now."""
        return frozenset([name for name, mouth in self._mouths.items() if mouth.open])

    def send(self, envelope: bytes, of_slow: bool) -> None:
        """Sends a tick's envelope."""
        for mouth in self._quick:
            mouth.send(envelope)
        if of_slow:
            for mouth in self._slow:
                mouth.send(envelope)
        if self._recorder is not None:
            self._recorder.send(SENT_AT.pack(time.time_ns()) + envelope)

    def flush(self) -> int:
        """Sends what others had no room for; returns how many messages are left."""
        return sum(mouth.flush() for mouth in self._mouths.values())

    @property
    def lost(self) -> int:
        """Messages that somebody did not listen to for too long to get them."""
        return sum(mouth.lost for mouth in self._mouths.values())
