"""The lines that lead from a node to others, see `lines`: its envelopes go out there."""

from __future__ import annotations

import struct
import time
from collections.abc import Mapping

from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import NodeWiring
from follower_humanoid.ros.envelope import hears_slow
from follower_humanoid.ros.lines import born_with

SENT_AT = struct.Struct("<q")
"""Before an envelope for the recorder: when it was sent, since the epoch [ns]."""


class Outgoing:
    """Whom a node reaches by a line.

    Attributes:
        hearers: Names of them.
        every_tick, slow: How many of them hear every tick, and how many only some.
    """

    def __init__(self, node: NodeWiring, table: Mapping[str, NodeWiring]) -> None:
        """Args: the node, and everyone by name."""
        lines = born_with().hearers_of(node.name)
        self.hearers = frozenset(lines)
        self._recorder = lines.pop(RECORDER, None)
        self._slow = [mouth for name, mouth in lines.items() if hears_slow(table[name], node)]
        self._quick = [mouth for mouth in lines.values() if mouth not in self._slow]
        self.slow = len(self._slow)
        self.every_tick = len(self._quick) + (self._recorder is not None)

    def wanted(self, of_slow: bool) -> bool:
        """Whether anybody hears a tick, one that slow nodes use or another."""
        return self.every_tick > 0 or (of_slow and self.slow > 0)

    def send(self, envelope: bytes, of_slow: bool) -> None:
        """Sends a tick's envelope."""
        for mouth in self._quick:
            mouth.send(envelope)
        if of_slow:
            for mouth in self._slow:
                mouth.send(envelope)
        if self._recorder is not None:
            self._recorder.send(SENT_AT.pack(time.time_ns()) + envelope)

    def flush(self) -> bool:
        """Sends what others had no room for; returns whether any of it is left."""
        mouths = [*self._quick, *self._slow, *([self._recorder] if self._recorder else [])]
        return sum(mouth.flush() for mouth in mouths) > 0
