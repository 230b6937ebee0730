"""Writes an MCAP file chunk by chunk.

The record types are the mcap package's. Its writer takes 9 µs for a message, which at 8000
messages a second is most of what the recorder may use; here a message takes 1 µs, since its
fields are packed at once and a chunk is joined only when it is full.
"""

from __future__ import annotations

import struct
import zlib
from array import array
from collections.abc import Iterable
from typing import Any, BinaryIO

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
_CHUNK_BYTES = 4 * 1024 * 1024
_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIELDS = _MESSAGE.size - 9  # the length counts from behind opcode and length
_INDEX = struct.Struct("<BQHI")
_LEVEL = 1  # as small as higher levels within a few per cent, in half the time


class McapWriter:
    """One file; `finish` writes the summary."""

    def __init__(self, stream: BinaryIO, profile: str, library: str) -> None:
        """Begins the file.

        Args:
            stream: Where to write, at its beginning.
            profile: `ros2`.
            library: Who writes.
        """
        self._stream = stream
        self._position = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._counts: list[int] = [0]  # by channel id, which counts from 1
        self._chunk_count = 0
        # As records: objects would take ten times as much, and a recording of hours has thousands.
        self._chunk_indices = bytearray()
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._first_time: int | None = None
        self._last_time = 0
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._begin_chunk()
        self._put(MAGIC + _record(Header(profile, library)))

    def attach(self, name: str, media_type: str, data: bytes, time: int) -> None:
        """A whole file within the file; `time` in [ns]."""
        record = _record(
            Attachment(create_time=time, log_time=time, name=name, media_type=media_type, data=data)
        )
        self._attachments.append(
            AttachmentIndex(
                offset=self._position,
                length=len(record),
                create_time=time,
                log_time=time,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )
        self._put(record)

    def add_metadata(self, name: str, entries: dict[str, str]) -> None:
        """A few named texts."""
        record = _record(Metadata(name=name, metadata=entries))
        self._metadata.append(MetadataIndex(offset=self._position, length=len(record), name=name))
        self._put(record)

    def add_schema(self, name: str, text: str) -> int:
        """A message definition; returns its id."""
        schema = Schema(id=len(self._schemas) + 1, name=name, encoding="ros2msg", data=text.encode("utf-8"))
        self._schemas.append(schema)
        self._append(_record(schema))
        return schema.id

    def add_channel(self, topic: str, schema: int, metadata: dict[str, str]) -> int:
        """A topic; returns its id."""
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding="cdr",
            metadata=metadata,
            schema_id=schema,
        )
        self._channels.append(channel)
        self._counts.append(0)
        self._append(_record(channel))
        return channel.id

    def add_message(self, channel: int, received: int, published: int, data: bytes) -> None:
        """One serialized message; times in [ns].

        Raises:
            OSError: The disk is full or gone.
        """
        counts = self._counts
        sequence = counts[channel]
        counts[channel] = sequence + 1
        size = _MESSAGE_FIELDS + len(data)
        self._parts.append(_MESSAGE.pack(Opcode.MESSAGE, size, channel, sequence, received, published))
        self._parts.append(data)
        index = self._index.get(channel)
        if index is None:
            index = self._index[channel] = array("Q")
        index.append(received)
        index.append(self._size)
        self._size += 9 + size
        if self._size > _CHUNK_BYTES:
            self.flush()

    def flush(self) -> None:
        """Writes the chunk in progress, if it holds messages, out to the operating system.

        Raises:
            OSError: The disk is full or gone.
        """
        if self._index:
            self._write_chunk()
        self._stream.flush()

    def finish(self) -> None:
        """Writes what is left, the summary and the end.

        Raises:
            OSError: The disk is full or gone.
        """
        self.flush()
        self._put(_record(DataEnd(0)))
        start = self._position
        groups: list[tuple[int, bytes]] = [
            (Opcode.SCHEMA, _records(self._schemas)),
            (Opcode.CHANNEL, _records(self._channels)),
            (Opcode.STATISTICS, _record(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._chunk_indices)),
            (Opcode.ATTACHMENT_INDEX, _records(self._attachments)),
            (Opcode.METADATA_INDEX, _records(self._metadata)),
        ]
        summary = bytearray()
        offsets = bytearray()
        for opcode, part in groups:
            if part:
                offsets += _record(
                    SummaryOffset(opcode, group_start=start + len(summary), group_length=len(part))
                )
            summary += part
        offsets_start = start + len(summary)
        summary += offsets
        # The checksum covers the footer up to itself.
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offsets_start)
        checksum = zlib.crc32(footer, zlib.crc32(summary))
        self._put(
            bytes(summary)
            + _record(Footer(summary_start=start, summary_offset_start=offsets_start, summary_crc=checksum))
            + MAGIC
        )
        self._stream.flush()

    @property
    def counts(self) -> dict[int, int]:
        """Messages by channel."""
        return {channel.id: self._counts[channel.id] for channel in self._channels}

    @property
    def span(self) -> tuple[int, int]:
        """Earliest and latest time of receipt [ns]; zeros without messages."""
        return (0, 0) if self._first_time is None else (self._first_time, self._last_time)

    def _begin_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0
        self._index: dict[int, array[int]] = {}

    def _append(self, record: bytes) -> None:
        self._parts.append(record)
        self._size += len(record)

    def _put(self, data: bytes) -> None:
        self._stream.write(data)
        self._position += len(data)

    def _write_chunk(self) -> None:
        data = b"".join(self._parts)
        index, self._index = self._index, {}
        first = min(min(times[::2]) for times in index.values())
        last = max(max(times[::2]) for times in index.values())
        self._first_time = first if self._first_time is None else min(first, self._first_time)
        self._last_time = max(last, self._last_time)
        packed = self._compressor.compress(data)
        chunk = _record(
            Chunk(
                compression="zstd",
                data=packed,
                message_start_time=first,
                message_end_time=last,
                uncompressed_crc=zlib.crc32(data),
                uncompressed_size=len(data),
            )
        )
        begin = self._position
        offsets: dict[int, int] = {}
        indices = bytearray()
        for channel, entries in index.items():
            offsets[channel] = begin + len(chunk) + len(indices)
            packed_entries = entries.tobytes()
            size = len(packed_entries)
            indices += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size) + packed_entries
        self._chunk_count += 1
        self._chunk_indices += _record(
            ChunkIndex(
                chunk_start_offset=begin,
                chunk_length=len(chunk),
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(data),
                message_start_time=first,
                message_end_time=last,
                message_index_offsets=offsets,
                message_index_length=len(indices),
            )
        )
        self._begin_chunk()
        self._put(chunk + bytes(indices))

    def _statistics(self) -> Statistics:
        first, last = self.span
        counts = self.counts
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=counts,
            chunk_count=self._chunk_count,
            message_count=sum(counts.values()),
            metadata_count=len(self._metadata),
            message_start_time=first,
            message_end_time=last,
            schema_count=len(self._schemas),
        )


def _records(records: Iterable[Any]) -> bytes:
    return b"".join(_record(record) for record in records)


def _record(record: Any) -> bytes:
    builder: Any = RecordBuilder()  # not annotated
    record.write(builder)
    return bytes(builder.end())
