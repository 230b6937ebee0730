"""Decodes serialized messages (CDR) of one topic together.

A message is walked through once; the layout found (where the numbers lie, which bytes must be
the same for the layout to hold) then reads all messages of the topic as one array.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.cdr import HEADER, NANOSECONDS, STAMP_SIZE, padding, stamp_of
from follower_humanoid.core.samples import Array


class CdrError(Exception):
    """The bytes are not the message they are said to be."""


class Cursor:
    """Walks through one message.

    Attributes:
        fixed: Ranges of bytes that carry structure: lengths and texts.
        numbers: Field → (offset, count) of float64 values.
        stamps: Offsets of the stamps met.
    """

    def __init__(self, data: bytes) -> None:
        """Raises: CdrError: Not plain CDR."""
        if len(data) < len(HEADER) or data[0] != 0 or data[1] not in (0, 1):
            raise CdrError("no plain CDR")
        self._data = data
        self._order = "<" if data[1] == 1 else ">"
        self.position = len(HEADER)
        self.fixed: list[tuple[int, int]] = [(0, 2)]
        self.numbers: dict[str, tuple[int, int]] = {}
        self.stamps: list[int] = []

    @property
    def big_endian(self) -> bool:
        """Byte order of the numbers."""
        return self._order == ">"

    def align(self, size: int) -> None:
        """Skips to the next multiple of `size`, counted from behind the encapsulation header."""
        self.position += padding(self.position, size)

    def skip(self, count: int, size: int = 1) -> None:
        """Passes over `count` values of `size` bytes."""
        if count:
            self.align(size)
            self._advance(count * size)

    def length(self) -> int:
        """An unsigned 32-bit length, part of the structure."""
        self.align(4)
        begin = self._advance(4)
        self.fixed.append((begin, self.position))
        return int(struct.unpack_from(self._order + "I", self._data, begin)[0])

    def integer(self) -> int:
        """A signed 32-bit value."""
        self.align(4)
        return int(struct.unpack_from(self._order + "i", self._data, self._advance(4))[0])

    def byte(self) -> int:
        """An unsigned 8-bit value."""
        return self._data[self._advance(1)]

    def long_integers(self, count: int) -> tuple[int, ...]:
        """`count` signed 64-bit values."""
        if count:
            self.align(8)
        begin = self._advance(8 * count)
        return struct.unpack_from(f"{self._order}{count}q", self._data, begin)

    def text(self) -> str:
        """A string, part of the structure."""
        count = self.length()
        begin = self._advance(count)
        self.fixed.append((begin, self.position))
        return self._data[begin : max(self.position - 1, begin)].decode("utf-8", errors="replace")

    def texts(self) -> tuple[str, ...]:
        """A sequence of strings."""
        return tuple(self.text() for _ in range(self.bounded(self.length())))

    def doubles(self, name: str, count: int) -> Array:
        """`count` float64 values."""
        if count:
            self.align(8)
        begin = self._advance(8 * count)
        self.numbers[name] = (begin, count)
        return np.frombuffer(self._data, self._order + "f8", count, begin).astype(np.float64)

    def floats(self, count: int) -> Array:
        """`count` float32 values."""
        if count:
            self.align(4)
        begin = self._advance(4 * count)
        return np.frombuffer(self._data, self._order + "f4", count, begin).astype(np.float64)

    def double_sequence(self, name: str) -> Array:
        """A sequence of float64."""
        return self.doubles(name, self.length())

    def stamp(self) -> int:
        """A `builtin_interfaces/Time` [ns]."""
        self.align(4)
        begin = self._advance(STAMP_SIZE)
        self.stamps.append(begin)
        return stamp_of(self._data, begin)

    def header(self) -> tuple[int, str]:
        """A `std_msgs/Header`: stamp [ns] and frame."""
        return self.stamp(), self.text()

    def bounded(self, count: int) -> int:
        """A length that the rest of the message can hold, so that rubbish does not fill the memory."""
        if count > len(self._data):
            raise CdrError("impossible length")
        return count

    def _advance(self, count: int) -> int:
        begin = self.position
        self.position += count
        if self.position > len(self._data):
            raise CdrError("breaks off")
        return begin


@dataclass(frozen=True)
class Batch:
    """Messages of one layout.

    Attributes:
        rows: Which messages of the batch, shape (n,).
        stamps: Of each, shape (n,) [ns].
        numbers: Field → values, shape (n, count).
        words: What the walk returned for this layout (frame, names).
    """

    rows: NDArray[np.intp]
    stamps: NDArray[np.int64]
    numbers: dict[str, Array]
    words: tuple[tuple[str, ...], ...]


Walk = Callable[[Cursor], tuple[tuple[str, ...], ...]]


def decode_batch(messages: Sequence[bytes], walk: Walk) -> list[Batch]:
    """Decodes messages whose numbers are all float64, grouped by layout.

    A message that is not of the type is in none of the batches.

    Args:
        messages: Serialized messages of one type, each beginning with a header.
        walk: Walks a cursor through one message and returns its texts.
    """
    batches: list[Batch] = []
    by_length: dict[int, list[int]] = {}
    for row, data in enumerate(messages):
        by_length.setdefault(len(data), []).append(row)
    by_length.pop(0, None)
    for length, rows in by_length.items():
        remaining = np.array(rows, dtype=np.intp)
        table = np.frombuffer(b"".join(messages[row] for row in rows), np.uint8).reshape(-1, length)
        while len(remaining):
            try:
                cursor = Cursor(table[0].tobytes())
                words = walk(cursor)
            except CdrError:
                table, remaining = table[1:], remaining[1:]
                continue
            same = _same_structure(table, cursor)
            batches.append(_read(table[same], remaining[same], cursor, words))
            table, remaining = table[~same], remaining[~same]
    return batches


def _same_structure(table: NDArray[np.uint8], cursor: Cursor) -> NDArray[np.bool_]:
    columns = np.concatenate([np.arange(begin, end) for begin, end in cursor.fixed])
    same: NDArray[np.bool_] = (table[:, columns] == table[0, columns]).all(axis=1)
    return same


def _read(
    table: NDArray[np.uint8], rows: NDArray[np.intp], cursor: Cursor, words: tuple[tuple[str, ...], ...]
) -> Batch:
    def columns(begin: int, count: int, kind: str) -> NDArray[np.generic]:
        size = int(kind[-1])
        if not count:
            return np.zeros((len(table), 0))
        part = np.ascontiguousarray(table[:, begin : begin + size * count])
        order = ">" if cursor.big_endian else "<"
        return part.view(order + kind).reshape(len(table), count)

    stamp = cursor.stamps[0]
    seconds = columns(stamp, 1, "i4")[:, 0].astype(np.int64)
    nanoseconds = columns(stamp + 4, 1, "u4")[:, 0].astype(np.int64)
    numbers = {
        name: columns(begin, count, "f8").astype(np.float64)
        for name, (begin, count) in cursor.numbers.items()
    }
    return Batch(rows, seconds * NANOSECONDS + nanoseconds, numbers, words)
