"""Serialises a message object to CDR and remembers where each number lies.

`serialize_message` would do the first half only, and leaves old memory in padding bytes and
after empty arrays.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from follower_humanoid.core.cdr import CdrBytes

_CODES = {
    "boolean": "?", "octet": "B", "uint8": "B", "int8": "b", "char": "B", "uint16": "H", "int16": "h",
    "uint32": "I", "int32": "i", "uint64": "Q", "int64": "q", "float": "f", "double": "d",
}  # fmt: skip


@dataclass(frozen=True)
class Slot:
    """Where numbers lie in a serialised message.

    Attributes:
        offset: First byte.
        code: Type letter of `struct`.
        count: How many follow one another.
    """

    offset: int
    code: str
    count: int

    @property
    def end(self) -> int:
        """First byte behind."""
        return self.offset + self.count * struct.calcsize(self.code)


class CdrWriter(CdrBytes):
    """Serialises one message.

    Attributes:
        slots: Path of a field (`header.stamp.sec`, `markers[0].pose.position.x`) → where it lies.
    """

    def __init__(self, message: Any) -> None:
        """Serialises the whole message."""
        super().__init__()
        self.slots: dict[str, Slot] = {}
        self._message(message, "")

    def _message(self, message: Any, prefix: str) -> None:
        for name, kind in message.get_fields_and_field_types().items():
            self._value(getattr(message, name), kind, f"{prefix}{name}")

    def _value(self, value: Any, kind: str, path: str) -> None:
        if kind in _CODES:
            self._numbers([value], _CODES[kind], path)
        elif kind.startswith("string"):
            self.text(value)
        elif kind.startswith("sequence<"):
            self.length(len(value))
            self._elements(value, kind[len("sequence<") : -1].partition(",")[0], path)
        elif kind.endswith("]"):
            self._elements(value, kind.partition("[")[0], path)
        else:
            self._message(value, f"{path}.")

    def _elements(self, values: Any, kind: str, path: str) -> None:
        if kind in _CODES:
            self._numbers(values, _CODES[kind], path)
            return
        for index, value in enumerate(values):
            self._value(value, kind, f"{path}[{index}]")

    def _numbers(self, values: Any, code: str, path: str) -> None:
        if len(values):  # an empty sequence is not aligned
            self.align(struct.calcsize(code))
        self.slots[path] = Slot(len(self.data), code, len(values))
        self.data += np.asarray(values, dtype=np.dtype(code).newbyteorder("<")).tobytes()
