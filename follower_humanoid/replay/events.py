"""The messages of a bag in the order in which they are to be sent, read ahead by a thread of its own."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterable, Iterator
from operator import attrgetter
from typing import NamedTuple

from follower_humanoid.bag.mcap_file import Message
from follower_humanoid.core.cdr import clock_bytes
from follower_humanoid.replay.index import BagFile, BagIndex, open_file

CLOCK_TYPE = "rosgraph_msgs/msg/Clock"
CLOCK = "/clock"
READING_AHEAD = "reading ahead"  # the thread's name
_AHEAD = 2  # chunks
_RECEIVED = attrgetter("received")


class Event(NamedTuple):
    """One message to send at a time since the epoch [ns]."""

    time: int
    topic: str
    data: bytes


def events(index: BagIndex, topics: frozenset[str], start: int = 0) -> Iterator[Event]:
    """What was received from `start` on [ns], chunk by chunk, whatever the size of the bag.

    A recorder writes a chunk's messages nearly in the order in which they came; one that belongs
    before the chunk in front of it is sent late rather than sought for in the whole file.
    """
    for chunk in _read_ahead(_chunks(index, topics, start)):
        yield from chunk


def _chunks(index: BagIndex, topics: frozenset[str], start: int) -> Iterator[list[Event]]:
    for path in index.files:
        file = open_file(path)
        for messages in file.chunks():
            yield _events(file, messages, topics, start)
        # Found only now where a summary has promised a whole file.
        index.notes += [note for note in file.notes if note not in index.notes]


def _events(file: BagFile, messages: list[Message], topics: frozenset[str], start: int) -> list[Event]:
    names = {number: info.topic for number, info in file.channels.items() if info.topic in topics}
    messages.sort(key=_RECEIVED)
    return [
        Event(received, names[channel], data)
        for channel, received, _, data in messages
        if received >= start and channel in names
    ]


def _read_ahead(chunks: Iterator[list[Event]]) -> Iterator[list[Event]]:
    """The same, unpacked in another thread: that takes longer than messages lie apart."""
    ready: queue.Queue[list[Event] | Exception | None] = queue.Queue(_AHEAD)
    over = threading.Event()

    def put(item: list[Event] | Exception | None) -> None:
        while not over.is_set():
            try:
                ready.put(item, timeout=0.1)
                return
            except queue.Full:
                continue

    def read() -> None:
        try:
            for chunk in chunks:
                put(chunk)
                if over.is_set():
                    return
            put(None)
        except Exception as error:  # told where the messages are used
            put(error)

    threading.Thread(target=read, name=READING_AHEAD, daemon=True).start()
    try:
        while (item := ready.get()) is not None:
            if isinstance(item, Exception):
                raise item
            yield item
    finally:
        over.set()


def with_clock(messages: Iterable[Event], period: int) -> Iterator[Event]:
    """Adds a clock that tells the time at which messages were received, for bags that have none.

    Args:
        messages: In the order of time.
        period: Between two messages of the clock [ns].
    """
    due: int | None = None
    for message in messages:
        due = message.time if due is None else due
        while due <= message.time:
            yield Event(due, CLOCK, clock_bytes(due))
            due += period
        yield message
