"""Writes a rosbag2 folder (Jazzy): one MCAP file and metadata.yaml.

Chunks reach the disk at least once a second of received time, so a recorder that is killed leaves
a file that can be read up to its last second.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from follower_humanoid.bag.definitions import definition
from follower_humanoid.bag.mcap_writer import McapWriter
from follower_humanoid.bag.qos import plain_yaml
from follower_humanoid.errors import ConfigurationError

METADATA_VERSION = 9
DISTRIBUTION = "jazzy"
LIBRARY = "follower_humanoid"
URDF_ATTACHMENT = "robot.urdf"
ABOUT_METADATA = "follower_humanoid"
_FLUSH_NS = 200_000_000  # wall time of which a recorder that is killed may take the messages with it


@dataclass(frozen=True)
class _Channel:
    topic: str
    type_name: str
    qos: list[dict[str, Any]]


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
        try:
            self._begin(about, created)
        except OSError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise ConfigurationError(f"bag {folder} cannot be made: {error.strerror}") from None
        self._channels: dict[int, _Channel] = {}
        self._schemas: dict[str, int] = {}
        self._flushed = created
        self._open = True

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        # An error on its way is the one to tell: closing is likely to fail for the same reason.
        with contextlib.suppress(OSError) if kind else contextlib.nullcontext():
            self.close()

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(self._writer.counts.values())

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
            self._schemas[type_name] = self._writer.add_schema(type_name, described.text)
        metadata = {"offered_qos_profiles": plain_yaml(qos), "topic_type_hash": described.type_hash}
        channel = self._writer.add_channel(topic, self._schemas[type_name], metadata)
        self._channels[channel] = _Channel(topic, type_name, qos)
        return channel

    def write(self, channel: int, data: bytes, received: int, published: int) -> None:
        """One serialized message.

        Args:
            channel: From `add_topic`.
            data: CDR with its encapsulation header.
            received, published: Times since the epoch [ns].

        Raises:
            OSError: The disk is full or gone; it names the folder.
        """
        try:
            self._writer.add_message(channel, received, published, data)
            if received - self._flushed > _FLUSH_NS:
                self._flushed = received
                self._writer.flush()
        except OSError as error:
            raise self._placed(error) from None

    def close(self) -> None:
        """Writes summary, statistics and metadata.yaml; harmless when called again.

        Raises:
            OSError: The disk is full, it names the folder; what was flushed before stays readable.
        """
        if not self._open:
            return
        self._open = False
        try:
            self._finish()
        except OSError as error:
            raise self._placed(error) from None

    def _begin(self, about: About, created: int) -> None:
        self._stream = self.file.open("xb")
        try:
            self._writer = McapWriter(self._stream, "ros2", LIBRARY)
            if about.urdf:
                self._writer.attach(URDF_ATTACHMENT, "application/xml", about.urdf.encode("utf-8"), created)
            for name, text in about.texts.items():
                self._writer.attach(name, "text/plain", text.encode("utf-8"), created)
            self._writer.add_metadata(ABOUT_METADATA, dict(about.values))
            self._writer.flush()
        except OSError:
            with contextlib.suppress(OSError):
                self._stream.close()
            raise

    def _placed(self, error: OSError) -> OSError:
        """The same, with the bag that it is about: a failed `write` does not name it."""
        return OSError(error.errno, error.strerror, str(self.folder))

    def _finish(self) -> None:
        try:
            self._writer.flush()
            information = self._information()
            # rosbag2 keeps the inner mapping of metadata.yaml in the file as well.
            self._writer.add_metadata("rosbag2", {"serialized_metadata": plain_yaml(information)})
            self._writer.finish()
        finally:
            # What a full disk refused stays in the stream's buffer and is refused again here.
            with contextlib.suppress(OSError):
                self._stream.close()
        text = plain_yaml({"rosbag2_bagfile_information": information})
        (self.folder / "metadata.yaml").write_text(text, encoding="utf-8")

    def _information(self) -> dict[str, Any]:
        first, last = self._writer.span
        counts = self._writer.counts
        span = {
            "starting_time": {"nanoseconds_since_epoch": first},
            "duration": {"nanoseconds": last - first},
            "message_count": self.message_count,
        }
        return {
            "version": METADATA_VERSION,
            "storage_identifier": "mcap",
            **span,
            "topics_with_message_count": [
                {"topic_metadata": _topic_metadata(channel), "message_count": counts[number]}
                for number, channel in self._channels.items()
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
