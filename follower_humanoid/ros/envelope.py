"""The envelope: all that a node publishes in a tick, in one message.

A delivery between processes costs about the same for 100 bytes as for 5000, so nodes hand one another
what belongs together in one piece. In it are the very bytes of the public messages. It travels by `lines`
between processes of one bringup, to all others as std_msgs/UInt8MultiArray on `graph/NODE`, and for nodes
with a longer period, which leave most ticks unread, at the ticks that they use also on `graph/NODE/slow`.
While an observer listens, the newest message of every topic goes out some times a second on
`graph/NODE/seen`. Its data, little-endian:

    int64   stamp [ns]
    uint32  length of each message, in the order of the node's outputs; 0: not published at this tick
    bytes   the messages one after the other, serialised (CDR)
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from follower_humanoid.core.cdr import HEADER
from follower_humanoid.graph.wiring import NodeWiring
from follower_humanoid.ros.validation import MessageError

STAMP = struct.Struct("<q")
# Of a UInt8MultiArray: no dimensions, no offset, length of the data.
_FRONT = struct.Struct("<III")
_DATA = STAMP_AT = len(HEADER) + _FRONT.size


def envelope_topic(node: str, slow: bool = False) -> str:
    """Where a node sends its envelopes: all of them, or those that slow nodes read."""
    return f"graph/{node}/slow" if slow else f"graph/{node}"


def seen_topic(node: str) -> str:
    """Where an observer finds what a node has published last."""
    return f"graph/{node}/seen"


def hears_slow(reader: NodeWiring, producer: NodeWiring) -> bool:
    """Whether a node takes only some of another's envelopes."""
    return reader.period > producer.period


def comes_by_itself(node: Any, topic: str) -> bool:
    """Whether a node hears a topic by its name, since it is asked to or since the topic is remapped."""
    name = node.resolve_topic_name
    return topic in node.graph.heard_by_topic or name(topic) != name(topic, only_expand=True)


class Envelope:
    """Packs and unpacks the envelopes of one node.

    Attributes:
        node: Whose.
        topics: What is in it, in order.
        name: Topic that the envelopes travel on.
        contents: Where the first message begins.
    """

    def __init__(self, node: NodeWiring) -> None:
        """Args: whose envelopes."""
        self.node = node.name
        self.topics = tuple(node.outputs.values())
        self.name = envelope_topic(node.name)
        self._lengths = struct.Struct(f"<{len(self.topics)}I")
        self.contents = _DATA + STAMP.size + self._lengths.size

    def seal(self, stamp: int, messages: Sequence[bytes]) -> bytes:
        """The serialised envelope.

        Args:
            stamp: Time of the tick [ns].
            messages: One per topic; empty where there is none at this tick.
        """
        lengths = self._lengths.pack(*map(len, messages))
        data = b"".join((STAMP.pack(stamp), lengths, *messages))
        return b"".join((HEADER, _FRONT.pack(0, 0, len(data)), data))

    def stamp(self, data: bytes) -> int:
        """Time of the tick [ns].

        Raises:
            MessageError: Not an envelope of this node.
        """
        if len(data) < self.contents:
            raise MessageError(self.name, f"{len(data)} bytes are no envelope")
        return int(STAMP.unpack_from(data, _DATA)[0])

    def lengths(self, data: bytes) -> bytes:
        """The table of lengths as it is."""
        return data[_DATA + STAMP.size : self.contents]

    def open(self, data: bytes) -> tuple[int, list[bytes]]:
        """The inverse of `seal`: stamp [ns] and messages.

        Raises:
            MessageError: Not an envelope of this node, or cut short.
        """
        stamp = self.stamp(data)
        messages = []
        at = self.contents
        for length in self._lengths.unpack_from(data, at - self._lengths.size):
            messages.append(data[at : at + length] if length else b"")
            at += length
        if at > len(data):
            raise MessageError(self.name, f"cut short: {len(data)} bytes of {at}")
        if data[: len(HEADER)] != HEADER or _FRONT.unpack_from(data, len(HEADER)) != (0, 0, at - _DATA):
            raise MessageError(self.name, "its lengths do not agree")
        return stamp, messages
