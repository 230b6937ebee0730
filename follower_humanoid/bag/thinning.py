"""Of topics that come at every tick the bag keeps the first message in each slot of stamp time."""

from __future__ import annotations


class Thinning:
    """Says which messages are kept, in the order of their stamps.

    Attributes:
        slot: In each such time the first message of a topic is kept [ns].
    """

    def __init__(self, slot: int) -> None:
        """Args: see the attributes."""
        self.slot = slot
        self._last: dict[str, int] = {}

    def keeps(self, topic: str, stamp: int) -> bool:
        """Whether this is the first message of its slot; `stamp` in [ns]. To be asked once per message."""
        slot = stamp // self.slot
        if self._last.get(topic) == slot:
            return False
        self._last[topic] = slot
        return True
