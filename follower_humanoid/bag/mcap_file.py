"""Reads an MCAP file from front to back, also where its end is missing or a chunk is broken."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema

from follower_humanoid.bag.mcap_writer import MAGIC
from follower_humanoid.bag.unpacking import Unpacker
from follower_humanoid.errors import ConfigurationError

_FRAME = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
BROKEN = (
    McapError,
    EndOfFile,
    EOFError,
    struct.error,
    UnicodeDecodeError,
    zstandard.ZstdError,
    RuntimeError,
    ValueError,
)
"""What readers of MCAP raise where a file is damaged."""


class Message(NamedTuple):
    """One serialized message; times since the epoch [ns]."""

    channel: int
    received: int
    published: int
    data: bytes


@dataclass(frozen=True)
class ChannelInfo:
    """What a channel carries.

    Attributes:
        topic: Fully qualified name.
        type_name: `package/msg/Type`.
        qos: Offered profiles as the recorder wrote them (YAML), empty where it wrote none.
    """

    topic: str
    type_name: str
    qos: str


class McapFile:
    """An MCAP file with messages of ROS 2.

    Attributes:
        channels: Id → channel, complete once `chunks()` is exhausted.
        attachments: Name → content, likewise.
        metadata: Name → entries, likewise.
        notes: What is missing or broken, one sentence each, likewise.
    """

    def __init__(self, path: Path) -> None:
        """Looks at the beginning and, where there is one, at the summary.

        Raises:
            ConfigurationError: Missing, empty, not an MCAP file, or not of ROS 2.
        """
        self.path = path
        self.channels: dict[int, ChannelInfo] = {}
        self.attachments: dict[str, bytes] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.notes: list[str] = []
        self._schemas: dict[int, str] = {}
        self._broken: list[str] = []
        self._unpacker = Unpacker(path.stat().st_size if path.is_file() else 0)
        try:
            with path.open("rb") as stream:
                self._check_beginning(stream)
                self._read_summary(stream)
        except OSError as error:
            raise ConfigurationError(f"bag {path} cannot be read: {error.strerror}") from None

    def chunks(self) -> Iterator[list[Message]]:
        """The messages of one chunk after the other; what cannot be read is noted and left out."""
        size = self.path.stat().st_size
        whole = False
        self._broken.clear()
        with self.path.open("rb") as stream:
            position = stream.seek(len(MAGIC))
            while position + _FRAME.size <= size:
                opcode, length = _FRAME.unpack(stream.read(_FRAME.size))
                position += _FRAME.size + length
                if position > size:
                    break
                if opcode == Opcode.DATA_END:
                    whole = True
                    break
                messages = self._record(opcode, stream.read(length))
                if messages:
                    yield messages
        if self._broken:
            count = len(self._broken)
            records = "a record is" if count == 1 else f"{count} records are"
            self.notes.append(f"{self.path.name}: {records} broken and left out ({self._broken[0]})")
        if not whole:
            self.notes.append(f"{self.path.name} has no end: the recording was cut off")

    def _check_beginning(self, stream: BinaryIO) -> None:
        magic = stream.read(len(MAGIC))
        if not magic:
            raise ConfigurationError(f"bag {self.path} is empty")
        if magic != MAGIC:
            raise ConfigurationError(f"bag {self.path} is not an MCAP file")
        try:
            opcode, length = _FRAME.unpack(stream.read(_FRAME.size))
            header = Header.read(ReadDataStream(BytesIO(stream.read(min(length, 65536)))))
        except BROKEN:
            raise ConfigurationError(f"bag {self.path} breaks off in its header") from None
        if opcode != Opcode.HEADER or header.profile != "ros2":
            raise ConfigurationError(f"bag {self.path} is not of ROS 2 (profile '{header.profile}')")

    def _read_summary(self, stream: BinaryIO) -> None:
        """Schemas and channels from the summary outlive a broken first chunk."""
        stream.seek(0)
        try:
            summary = make_reader(stream).get_summary()
        except BROKEN:
            return
        if summary is not None:
            self._schemas.update((schema.id, schema.name) for schema in summary.schemas.values())
            for channel in summary.channels.values():
                self._add_channel(channel)

    def _record(self, opcode: int, body: bytes) -> list[Message]:
        try:
            if opcode == Opcode.CHUNK:
                return self._unpack(Chunk.read(ReadDataStream(BytesIO(body))))
            if opcode == Opcode.MESSAGE:
                return [Message(*_message(body, 0, len(body)))]
            if opcode == Opcode.ATTACHMENT:
                attachment = Attachment.read(ReadDataStream(BytesIO(body)))
                self.attachments[attachment.name] = attachment.data
            elif opcode == Opcode.METADATA:
                entry = Metadata.read(ReadDataStream(BytesIO(body)))
                self.metadata[entry.name] = entry.metadata
            else:
                self._describe(opcode, body)
        except BROKEN as error:
            self._broken.append(str(error) or type(error).__name__)
        return []

    def _unpack(self, chunk: Chunk) -> list[Message]:
        data = self._unpacker.unpack(chunk)
        messages = []
        position = 0
        while position < len(data):
            opcode, length = _FRAME.unpack_from(data, position)
            begin, position = position + _FRAME.size, position + _FRAME.size + length
            if opcode == 0:
                raise McapError("a record of no kind")
            if opcode == Opcode.MESSAGE:
                messages.append(Message(*_message(data, begin, position)))
            else:
                self._describe(opcode, data[begin:position])
        return messages

    def _describe(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(BytesIO(body)))
            self._schemas[schema.id] = schema.name
        elif opcode == Opcode.CHANNEL:
            self._add_channel(Channel.read(ReadDataStream(BytesIO(body))))

    def _add_channel(self, channel: Channel) -> None:
        if channel.message_encoding != "cdr":
            note = f"{channel.topic} is encoded as '{channel.message_encoding}', not cdr, and left out"
            if note not in self.notes:
                self.notes.append(note)
            return
        type_name = self._schemas.get(channel.schema_id, "")
        qos = channel.metadata.get("offered_qos_profiles", "")
        self.channels[channel.id] = ChannelInfo(channel.topic, type_name, qos)


def _message(data: bytes, begin: int, end: int) -> tuple[int, int, int, bytes]:
    channel, _, received, published = _MESSAGE.unpack_from(data, begin)
    return channel, received, published, data[begin + _MESSAGE.size : end]


def bag_files(bag: Path) -> list[Path]:
    """The MCAP files of a bag: a folder as rosbag2 makes it, or one file.

    Raises:
        ConfigurationError: Nothing there that could be read.
    """
    if not os.path.exists(bag):  # unlike Path's, False for a name that no file can have
        raise ConfigurationError(f"bag {bag} does not exist")
    if bag.is_file():
        return [bag]
    files = sorted(bag.glob("*.mcap"), key=_number)
    if files:
        return files
    if any(bag.glob("*.db3")):
        raise ConfigurationError(f"bag {bag} is stored in SQLite; only MCAP can be read")
    raise ConfigurationError(f"bag {bag} holds no .mcap file")


def _number(path: Path) -> tuple[int, str]:
    """rosbag2 numbers the files of a split bag at the end of the name."""
    digits = path.stem.rpartition("_")[2]
    return (int(digits) if digits.isdigit() else 0, path.name)
