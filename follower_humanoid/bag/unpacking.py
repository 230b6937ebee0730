"""Unpacks the chunks of a bag within bounds: a small file must not fill the memory."""

from __future__ import annotations

import zlib
from io import BytesIO

import lz4.frame
import zstandard
from mcap.exceptions import McapError
from mcap.records import Chunk

_LARGEST_CHUNK = 32 * 2**20  # bytes; rosbag2 makes them of 0.8 MB, one large image or cloud may need more
# All chunks together: what is recorded of a robot packs to a fifth, of one that stands without any
# noise to a fiftieth.
_LARGEST_RATIO = 200
_ALWAYS_ALLOWED = 64 * 2**20


class Unpacker:
    """Unpacks the chunks of one file.

    Attributes:
        left: Bytes that may still come out of it.
    """

    def __init__(self, size: int) -> None:
        """Args: the size of the file [bytes]."""
        self.left = _ALWAYS_ALLOWED + _LARGEST_RATIO * size

    def unpack(self, chunk: Chunk) -> bytes:
        """The records of a chunk.

        Raises:
            McapError: It is too large unpacked, is packed in an unknown way, or its check sum is wrong.
        """
        bound = min(_LARGEST_CHUNK, self.left)
        if chunk.uncompressed_size > bound:
            raise McapError(
                f"a chunk of {chunk.uncompressed_size} bytes, more than the {bound} that are read"
            )
        data = _unpacked(chunk, bound)
        if len(data) > bound:
            raise McapError(f"a chunk of more than the {bound} bytes that are read")
        self.left -= len(data)
        if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
            raise McapError("a chunk with a wrong check sum")
        return data


def _unpacked(chunk: Chunk, bound: int) -> bytes:
    """At most one byte more than the bound."""
    if chunk.compression == "":
        return bytes(chunk.data)
    if chunk.compression == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(BytesIO(chunk.data)) as stream:
            return bytes(stream.read(bound + 1))
    if chunk.compression == "lz4":
        with lz4.frame.LZ4FrameFile(BytesIO(chunk.data)) as stream:
            return bytes(stream.read(bound + 1))
    raise McapError(f"a chunk packed with '{chunk.compression}'")
