"""What goes to the recorder: envelopes of the nodes of one process, a tick of them in one message.

Several in one cost hardly more than one alone, for who sends and for who reads. Each has its time and its
sender before it.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Iterator

from follower_humanoid.graph.wiring import ARM_TASK, NODES

# When it was sent, since the epoch [ns]; whose it is, by its place in `_SENDERS`; bytes.
_ENTRY = struct.Struct("<qII")
_SENDERS = (*NODES, ARM_TASK.name)
_NUMBER = {name: number for number, name in enumerate(_SENDERS)}
_HEAVY = 15_000  # bytes from which on nothing is added: of such messages 13 fit into a line


class Parcel:
    """Collects envelopes until nobody has another one, or one of the senders has the next."""

    def __init__(self, send: Callable[[bytes], None], alone: bool) -> None:
        """Empty. Args: where it goes, and whether there is one sender only, who then need not wait."""
        self._send, self._alone = send, alone
        self._pieces: list[bytes] = []
        self._senders: set[str] = set()
        self._weight = 0

    def add(self, sender: str, envelope: bytes) -> None:
        """One more envelope."""
        if sender in self._senders or self._weight + len(envelope) > _HEAVY:
            self.go()
        self._senders.add(sender)
        self._pieces += (_ENTRY.pack(time.time_ns(), _NUMBER[sender], len(envelope)), envelope)
        self._weight += len(envelope)
        if self._alone:
            self.go()

    def go(self) -> None:
        """Sends what there is."""
        if self._pieces:
            pieces, self._pieces = self._pieces, []
            self._senders.clear()
            self._weight = 0
            self._send(b"".join(pieces))


def unpacked(parcel: bytes) -> Iterator[tuple[str, bytes, int]]:
    """Sender of each envelope, the envelope, and when it was sent, since the epoch [ns]."""
    at = 0
    while at < len(parcel):
        sent_at, number, size = _ENTRY.unpack_from(parcel, at)
        at += _ENTRY.size
        yield _SENDERS[number], parcel[at : at + size], sent_at
        at += size
