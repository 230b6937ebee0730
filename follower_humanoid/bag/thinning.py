"""What the bag keeps of each topic: every message, or the first one in each slot of stamp time."""

from __future__ import annotations

from follower_humanoid.core.topics import PEOPLE

EVERY_MESSAGE = frozenset(
    {
        "joint_states",
        "odom",
        "imu",
        "left_foot/wrench",
        "right_foot/wrench",
        "left_hand/wrench_raw",
        "right_hand/wrench_raw",
        "left_hand/wrench",
        "right_hand/wrench",
        "left_hand/applied",
        "right_hand/applied",
        "base/applied",
        "left_hand/contact",
        "right_hand/contact",
        "left_hand/target",
        "legs/command",
        "arms/command",
        "zmp",
        "zmp_reference",
    }
)
"""Topics of which every message is kept."""
# Stamps of any clock: people's cannot be thinned out by them. Footsteps are sent when they change.
_AS_THEY_COME = PEOPLE | {"footsteps"}


def is_thinned(topic: str) -> bool:
    """Whether only a part of a topic's messages is kept."""
    return topic not in EVERY_MESSAGE and topic not in _AS_THEY_COME


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
