"""Writes a rosbag2 folder (Jazzy): one MCAP file and metadata.yaml.

Chunks reach the disk at least once a second of received time, so a recorder that is killed leaves
a file that can be read up to its last second.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from mcap.writer import CompressionType, Writer

from follower_humanoid.bag.definitions import definition
from follower_humanoid.bag.qos import plain_yaml
from follower_humanoid.errors import ConfigurationError

METADATA_VERSION = 9
DISTRIBUTION = "jazzy"
LIBRARY = "follower_humanoid"
URDF_ATTACHMENT = "robot.urdf"
ABOUT_METADATA = "follower_humanoid"
_CHUNK_BYTES = 4 * 1024 * 1024
_FLUSH_NS = 1_000_000_000


@dataclass
class _Channel:
    topic: str
    type_name: str
    qos: list[dict[str, Any]]
    count: int = 0


@dataclass
class _Span:
    """Receive times seen so far [ns]."""

    first: int | None = None
    last: int = 0
    count: int = 0

    def add(self, time: int) -> None:
        self.first = time if self.first is None else min(self.first, time)
        self.last = max(self.last, time)
        self.count += 1

    def as_metadata(self) -> dict[str, Any]:
        start = self.first or 0
        return {
            "starting_time": {"nanoseconds_since_epoch": start},
            "duration": {"nanoseconds": self.last - start if self.count else 0},
            "message_count": self.count,
        }


@dataclass(frozen=True)
class About:
    """What the bag carries so that the run can be repeated.

    Attributes:
        urdf: URDF text.
        texts: Name → text, each an attachment (parameters, programme, versions).
        values: Short facts (tick, seed) in one metadata record.
    """

    urdf: str = ""
    texts: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, str] = field(default_factory=dict)


class BagWriter:
    """One recording; use as a context manager or call `close`."""

    def __init__(self, folder: Path, about: About, created: int) -> None:
        """Makes the folder and begins the file.

        Args:
            folder: The bag; must not exist.
            about: Carried at the beginning of the file, so that a truncated one has it too.
            created: Time of creation since the epoch [ns].

        Raises:
            ConfigurationError: The folder exists or cannot be written.
        """
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            raise ConfigurationError(f"bag {folder} exists already; nothing is overwritten") from None
        except OSError as error:
            raise ConfigurationError(f"bag {folder} cannot be made: {error.strerror}") from None
        self.folder = folder
        self.file = folder / f"{folder.name}_0.mcap"
        self._stream = self.file.open("xb")
        # The library's writer is only half annotated.
        self._writer = cast(
            Any, Writer(self._stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        )
        self._writer.start(profile="ros2", library=LIBRARY)
        if about.urdf:
            self._attach(URDF_ATTACHMENT, "application/xml", about.urdf, created)
        for name, text in about.texts.items():
            self._attach(name, "text/plain", text, created)
        self._writer.add_metadata(ABOUT_METADATA, dict(about.values))
        self._writer.flush()
        self._channels: dict[int, _Channel] = {}
        self._schemas: dict[str, int] = {}
        self._span = _Span()
        self._flushed = created
        self._open = True

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return self._span.count

    def add_topic(self, topic: str, type_name: str, qos: list[dict[str, Any]]) -> int:
        """Announces a topic; the result identifies it in `write`.

        Args:
            topic: Fully qualified name.
            type_name: `package/msg/Type`.
            qos: Offered profiles, see `bag.qos.offered_qos`.

        Raises:
            ConfigurationError: The message package is not installed.
        """
        described = definition(type_name)
        if type_name not in self._schemas:
            data = described.text.encode("utf-8")
            self._schemas[type_name] = self._writer.register_schema(type_name, "ros2msg", data)
        metadata = {"offered_qos_profiles": plain_yaml(qos), "topic_type_hash": described.type_hash}
        channel = self._writer.register_channel(topic, "cdr", self._schemas[type_name], metadata)
        self._channels[channel] = _Channel(topic, type_name, qos)
        return int(channel)

    def write(self, channel: int, data: bytes, received: int, published: int) -> None:
        """One serialized message.

        Args:
            channel: From `add_topic`.
            data: CDR with its encapsulation header.
            received, published: Times since the epoch [ns].

        Raises:
            OSError: The disk is full or gone.
        """
        entry = self._channels[channel]
        self._writer.add_message(channel, received, data, published, entry.count)
        entry.count += 1
        self._span.add(received)
        if received - self._flushed > _FLUSH_NS:
            self._flushed = received
            self._writer.flush()

    def close(self) -> None:
        """Writes summary, statistics and metadata.yaml; harmless when called again.

        Raises:
            OSError: The disk is full; what was flushed before stays readable.
        """
        if not self._open:
            return
        self._open = False
        metadata = plain_yaml({"rosbag2_bagfile_information": self._metadata()})
        try:
            # rosbag2 keeps the inner mapping of metadata.yaml in the file as well.
            self._writer.add_metadata("rosbag2", {"serialized_metadata": plain_yaml(self._metadata())})
            self._writer.finish()
            self._stream.flush()
        finally:
            # What a full disk refused stays in the stream's buffer and is refused again here.
            with contextlib.suppress(OSError):
                self._stream.close()
        (self.folder / "metadata.yaml").write_text(metadata, encoding="utf-8")

    def _attach(self, name: str, media_type: str, text: str, created: int) -> None:
        self._writer.add_attachment(created, created, name, media_type, text.encode("utf-8"))

    def _metadata(self) -> dict[str, Any]:
        span = self._span.as_metadata()
        return {
            "version": METADATA_VERSION,
            "storage_identifier": "mcap",
            "duration": span["duration"],
            "starting_time": span["starting_time"],
            "message_count": span["message_count"],
            "topics_with_message_count": [
                {"topic_metadata": _topic_metadata(channel), "message_count": channel.count}
                for channel in self._channels.values()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.file.name],
            "files": [{"path": self.file.name, **span}],
            "custom_data": None,
            "ros_distro": DISTRIBUTION,
        }


def _topic_metadata(channel: _Channel) -> dict[str, Any]:
    return {
        "name": channel.topic,
        "type": channel.type_name,
        "serialization_format": "cdr",
        "offered_qos_profiles": channel.qos,
        "type_description_hash": definition(channel.type_name).type_hash,
    }
