"""The lines that lead from a node to others, see `lines`: its envelopes go out there."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

from follower_humanoid.bag.thinning import Thinning, is_thinned
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import NodeWiring
from follower_humanoid.ros.envelope import hears_slow
from follower_humanoid.ros.lines import BORN_WITH

SLOT = struct.Struct("<q")
"""What the recorder says to who sends: see `Thinning.slot` [ns]."""


class Outgoing:
    """Whom a node reaches by a line.

    Attributes:
        reach_quick: Whether anybody hears every tick.
        reach_slow: Whether anybody hears those that slow nodes use.
        recorded: Whether the recorder hears.
    """

    def __init__(self, node: NodeWiring, table: Mapping[str, NodeWiring]) -> None:
        """Args: the node, and everyone by name."""
        self._mouths = BORN_WITH.mouths_of(node.name)
        nodes = {name: mouth for name, mouth in self._mouths.items() if name != RECORDER}
        self._name = node.name
        self._recorder = self._mouths.get(RECORDER)
        self._parcel = BORN_WITH.parcel_of(node.name)
        self._slow = [mouth for name, mouth in nodes.items() if hears_slow(table[name], node)]
        self._quick = [mouth for mouth in nodes.values() if mouth not in self._slow]
        self._thinned = [topic for topic in node.outputs.values() if is_thinned(topic)]
        self._thinning: Thinning | None = None
        self.reach_quick = bool(self._quick)
        self.reach_slow = bool(self._slow)
        self.recorded = self._parcel is not None

    def hearers(self) -> frozenset[str]:
        """Names of all who hear it now."""
        return frozenset([name for name, mouth in self._mouths.items() if mouth.open])

    def look(self) -> None:
        """Takes in what the recorder has said."""
        if self._recorder is None:
            return
        word = self._recorder.heard_back()  # the last one, where several nodes share the line
        if len(word) == SLOT.size and (self._thinning is None or word != SLOT.pack(self._thinning.slot)):
            self._thinning = Thinning(*SLOT.unpack(word))

    def kept(self, samples: Mapping[str, Any], stamp: int) -> dict[str, Any]:
        """Those of a tick's samples that the recorder keeps; None in the place of others. `stamp` in [ns]."""
        kept = dict(samples)
        if self._thinning is not None:
            for topic in self._thinned:
                if kept[topic] is not None and not self._thinning.keeps(topic, stamp):
                    kept[topic] = None
        return kept

    def send(self, envelope: bytes, of_slow: bool) -> None:
        """Sends a tick's envelope."""
        for mouth in self._quick:
            mouth.send(envelope)
        if of_slow:
            for mouth in self._slow:
                mouth.send(envelope)
        if self._parcel is not None:
            self._parcel.add(self._name, envelope)

    def flush(self) -> int:
        """Sends what was kept; returns how many messages are left that others have no room for."""
        if self._parcel is not None:
            self._parcel.go()
        return sum(mouth.flush() for mouth in self._mouths.values())

    @property
    def lost(self) -> int:
        """Messages that somebody did not listen to for too long to get them."""
        return sum(mouth.lost for mouth in self._mouths.values())
