"""What a bag holds, told before it is played: topics, types, counts, begin and end."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Statistics

from follower_humanoid.bag.mcap_file import BROKEN, McapFile, bag_files
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.replay.offered import Offered, offered_in
from follower_humanoid.replay.sqlite_file import SqliteFile

BagFile = McapFile | SqliteFile
_SQLITE = ".db3"


@dataclass
class TopicIndex:
    """One topic of a bag.

    Attributes:
        type_name: `package/msg/Type`.
        offered: Quality of service that its publishers offered.
        count: Messages.
    """

    type_name: str
    offered: Offered
    count: int = 0


@dataclass
class BagIndex:
    """A whole bag.

    Attributes:
        path: Folder or file.
        files: Its files in the order of time.
        topics: Full name → topic.
        begin, end: Times at which the first and the last message were received, since the epoch [ns].
        notes: What is missing or broken, one sentence each.
    """

    path: Path
    files: list[Path]
    topics: dict[str, TopicIndex] = field(default_factory=dict)
    begin: int = 0
    end: int = 0
    notes: list[str] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self.end - self.begin) / 1e9

    @property
    def count(self) -> int:
        """Messages of all topics."""
        return sum(topic.count for topic in self.topics.values())

    def chosen(self, names: Iterable[str]) -> frozenset[str]:
        """Full names of topics as people type them; all where none is named.

        Raises:
            UnknownNameError: The bag has no such topic.
        """
        wanted = frozenset(name if name.startswith("/") else f"/{name}" for name in names)
        for name in sorted(wanted - self.topics.keys()):
            raise UnknownNameError("topic", name, self.topics, f"bag {self.path}")
        return wanted or frozenset(self.topics)


def index_bag(path: Path) -> BagIndex:
    """Reads the summaries of a bag; where there is none, the whole file.

    Raises:
        ConfigurationError: Nothing there that could be played.
    """
    index = BagIndex(path, _files(path))
    spans: list[tuple[int, int]] = []
    for file in map(open_file, index.files):
        counts, span = _counts(file)
        for number, channel in file.channels.items():
            offered = offered_in(channel.qos)
            topic = index.topics.setdefault(channel.topic, TopicIndex(channel.type_name, offered))
            topic.count += counts[number]
        if sum(counts.values()):
            spans.append(span)
        index.notes += file.notes
    if not spans:
        raise ConfigurationError(f"bag {path} holds no messages")
    index.begin, index.end = min(first for first, _ in spans), max(last for _, last in spans)
    return index


def open_file(path: Path) -> BagFile:
    """One file of a bag, whatever its storage."""
    return SqliteFile(path) if path.suffix == _SQLITE else McapFile(path)


def _files(bag: Path) -> list[Path]:
    """The files of a bag in the order of time; SQLite only where there is no MCAP."""
    if os.path.isdir(bag) and not any(bag.glob("*.mcap")):
        databases = [(SqliteFile(path).statistics()[1], path) for path in bag.glob(f"*{_SQLITE}")]
        if databases:
            return [path for _, path in sorted(databases)]
    return bag_files(bag)


def _counts(file: BagFile) -> tuple[Counter[int], tuple[int, int]]:
    if isinstance(file, SqliteFile):
        return file.statistics()
    statistics = _statistics(file.path)
    if statistics is None:
        return _walk(file)
    span = (statistics.message_start_time, statistics.message_end_time)
    return Counter(statistics.channel_message_counts), span


def _statistics(file: Path) -> Statistics | None:
    try:
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
    except (*BROKEN, OSError):
        return None
    return None if summary is None else summary.statistics


def _walk(file: McapFile) -> tuple[Counter[int], tuple[int, int]]:
    counts: Counter[int] = Counter()
    first, last = 2**63, 0
    for messages in file.chunks():
        counts.update(message.channel for message in messages)
        times = [message.received for message in messages]
        first, last = min(first, *times), max(last, *times)
    return counts, (first, last)
