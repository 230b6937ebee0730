"""Reads a bag file that rosbag2 has stored in SQLite, as it did by default before Iron."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

from follower_humanoid.bag.mcap_file import ChannelInfo, Message
from follower_humanoid.errors import ConfigurationError

_BLOCK = 5000


class SqliteFile:
    """A `.db3` file, with what `McapFile` has.

    Attributes:
        channels: Id → topic.
        notes: What is missing or broken, one sentence each; complete once `chunks()` is exhausted.
    """

    def __init__(self, path: Path) -> None:
        """Looks at the list of topics.

        Raises:
            ConfigurationError: Empty, or no bag.
        """
        self.path = path
        self.notes: list[str] = []
        if path.stat().st_size == 0:
            raise ConfigurationError(f"bag {path} is empty")
        self.channels: dict[int, ChannelInfo] = {}
        for number, name, type_name, encoding, qos in self._query(
            "SELECT id, name, type, serialization_format, offered_qos_profiles FROM topics"
        ):
            if encoding == "cdr":
                self.channels[number] = ChannelInfo(name, type_name, qos)
            else:
                self.notes.append(f"{name} is encoded as '{encoding}', not cdr, and left out")

    def statistics(self) -> tuple[Counter[int], tuple[int, int]]:
        """Messages per topic, and the times of the first and the last one [ns]."""
        counts = Counter(dict(self._query("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id")))
        first, last = self._query("SELECT MIN(timestamp), MAX(timestamp) FROM messages")[0]
        return counts, (first or 0, last or 0)

    def chunks(self) -> Iterator[list[Message]]:
        """The messages in the order of time, some thousand at once; what cannot be read is noted."""
        with self._open() as database:
            rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id")
            try:
                while block := rows.fetchmany(_BLOCK):
                    yield [Message(topic, time, time, bytes(data)) for topic, time, data in block]
            except sqlite3.Error as error:
                self.notes.append(f"{self.path.name} is broken ({error}); it is read up to there")
        database.close()

    def _query(self, text: str) -> list[Any]:
        try:
            with self._open() as database:
                return list(database.execute(text))
        except sqlite3.Error as error:
            raise ConfigurationError(f"bag {self.path} cannot be read: {error}") from None

    def _open(self) -> sqlite3.Connection:
        return sqlite3.connect(f"file:{quote(str(self.path.absolute()))}?mode=ro&immutable=1", uri=True)
