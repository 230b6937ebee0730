"""CDR, the wire format of ROS 2: its header, alignment, stamps and texts, in one place.

XCDR1: a header of four bytes that tells the byte order, then the fields one after the other, each
primitive aligned to its own size, counted from behind the header. What is written here is little-endian,
with zeros as padding: equal messages are equal bytes.
"""

from __future__ import annotations

import struct

HEADER = b"\x00\x01\x00\x00"
NANOSECONDS = 1_000_000_000
STAMP_SIZE = 8
LARGEST_STAMP = (2**31 - 1) * NANOSECONDS + NANOSECONDS - 1
"""The last time that a stamp can tell [ns]."""

_LITTLE, _BIG = struct.Struct("<iI"), struct.Struct(">iI")


def stamp_of(data: bytes, offset: int = len(HEADER)) -> int:
    """A `builtin_interfaces/Time` [ns] at an offset, which is where most messages begin with it.

    Returns:
        −1 where the message is cut short.
    """
    if len(data) < offset + STAMP_SIZE:
        return -1
    seconds, nanoseconds = (_LITTLE if data[1] & 1 else _BIG).unpack_from(data, offset)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def text_of(data: bytes, offset: int = len(HEADER)) -> str | None:
    """A string at an offset, which is where a std_msgs/String has it; None where the bytes hold none."""
    begin = offset + 4
    if len(data) < begin:
        return None
    length = int.from_bytes(data[offset:begin], "little" if data[1] & 1 else "big")
    if not 1 <= length <= len(data) - begin or data[begin + length - 1] != 0:
        return None
    try:
        return data[begin : begin + length - 1].decode("utf-8")
    except UnicodeDecodeError:
        return None


def put_stamp(data: bytearray, offset: int, stamp: int) -> None:
    """Writes a `builtin_interfaces/Time`; `stamp` in [ns]."""
    _LITTLE.pack_into(data, offset, *divmod(stamp, NANOSECONDS))


def clock_bytes(stamp: int) -> bytes:
    """A serialised rosgraph_msgs/Clock; `stamp` in [ns]."""
    return HEADER + _LITTLE.pack(*divmod(stamp, NANOSECONDS))


def padding(position: int, size: int) -> int:
    """Bytes to leave out at a position, counted from the first of the header, before a value of a size."""
    return -(position - len(HEADER)) % size


class CdrBytes:
    """A message that is being written.

    Attributes:
        data: The bytes so far.
    """

    def __init__(self) -> None:
        """Begins with the header."""
        self.data = bytearray(HEADER)

    def align(self, size: int) -> None:
        """Pads to a multiple of `size`."""
        self.data += bytes(padding(len(self.data), size))

    def length(self, value: int) -> None:
        """The length of what follows, an unsigned 32-bit number."""
        self.align(4)
        self.data += struct.pack("<I", value)

    def text(self, value: str) -> None:
        """A string."""
        data = value.encode("utf-8") + b"\0"
        self.length(len(data))
        self.data += data

    def stamp(self, value: int = 0) -> int:
        """A `builtin_interfaces/Time` [ns]; returns where it lies."""
        self.align(4)
        self.data += bytes(STAMP_SIZE)
        offset = len(self.data) - STAMP_SIZE
        put_stamp(self.data, offset, value)
        return offset
