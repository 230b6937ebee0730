"""Reads what one node wants of another's envelopes, in one look at the bytes.

Envelopes of the same lengths differ in stamps and numbers only, if our own nodes made them: all other
bytes are compared, all numbers are copied and looked at, by one compiled loop. What it does not accept
goes message by message through the codecs, which know why.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope

_LARGEST_CACHE = 64
_DOUBLE = 8

Bytes = NDArray[np.uint8]
Spans = NDArray[np.int64]


@kernel(
    "boolean(Array(uint8, 1, 'C', readonly=True), uint8[::1], int64[:,::1], int64[:,::1], float64[::1])"
)
def unpack(data: Bytes, template: Bytes, fixed: Spans, runs: Spans, numbers: Array) -> bool:
    """Copies the numbers; False where a fixed byte differs or a number is not finite.

    Args:
        data: Shape (≥ n,).
        template: What the fixed bytes are, shape (n,).
        fixed: First byte, and first byte behind, of what must be equal, shape (·, 2).
        runs: First byte of numbers, and how many bytes they are, shape (·, 2).
        numbers: Written, one run after the other.
    """
    different = np.uint8(0)
    for n in range(fixed.shape[0]):
        # Without a way out, and with indices that cannot be negative: so it is many bytes at a time.
        for at in range(np.uint64(fixed[n, 0]), np.uint64(fixed[n, 1])):
            different |= data[at] ^ template[at]
    if different:
        return False
    target = numbers.view(np.uint8)
    end = np.uint64(0)
    for n in range(runs.shape[0]):
        first, count = np.uint64(runs[n, 0]), np.uint64(runs[n, 1])
        for at in range(count):
            target[end + np.uint64(at)] = data[first + np.uint64(at)]
        end += count
    nothing = 0.0
    for number in numbers:
        nothing += number - number
    return nothing == 0.0


@dataclass(frozen=True)
class _Part:
    """One message in an envelope.

    Attributes:
        begin, end: Its bytes; empty where it is absent.
        codec: Reads it.
        blocks: Where its numbers are among all numbers; None where they are not read that way.
    """

    begin: int
    end: int
    codec: Codec
    blocks: list[slice] | None


class _Plan:
    """How envelopes with messages of certain lengths are read.

    Attributes:
        size: Bytes of such an envelope.
    """

    def __init__(self, contents: int, lengths: list[int], wanted: list[tuple[int, Codec]]) -> None:
        begins = [contents, *(contents + total for total in itertools.accumulate(lengths))]
        self.size = begins[-1]
        template = bytearray(self.size)
        fixed: list[tuple[int, int]] = []
        runs: list[tuple[int, int]] = []
        self._parts: list[_Part] = []
        count = 0
        for index, codec in wanted:
            begin, end = begins[index], begins[index + 1]
            blocks = None
            layout = codec.read_layout
            if layout is not None and len(layout.data) == lengths[index]:
                template[begin:end] = layout.data
                fixed += [(begin + first, begin + behind) for first, behind, _ in layout.fixed]
                blocks = []
                for slot in layout.slots:
                    runs.append((begin + slot.offset, slot.count * _DOUBLE))
                    blocks.append(slice(count, count + slot.count))
                    count += slot.count
            self._parts.append(_Part(begin, end, codec, blocks))
        self._template = np.frombuffer(template, np.uint8)
        self._fixed = np.array(fixed, dtype=np.int64).reshape(-1, 2)
        self._runs = np.array(runs, dtype=np.int64).reshape(-1, 2)
        self._count = count

    def read(self, data: bytes) -> tuple[Any, ...]:
        """The samples; None where a message is absent.

        Raises:
            MessageError: A message cannot be used.
        """
        numbers = np.empty(self._count)
        ours = unpack(np.frombuffer(data, np.uint8), self._template, self._fixed, self._runs, numbers)
        samples: list[Any] = []
        for part in self._parts:
            if part.begin == part.end:
                samples.append(None)
            elif ours and part.blocks is not None:
                samples.append(part.codec.made_of([numbers[block] for block in part.blocks]))
            else:
                samples.append(part.codec.decode(data[part.begin : part.end]))
        return tuple(samples)


class EnvelopeReader:
    """What one node reads of another's envelopes.

    Attributes:
        envelope: Says where messages lie.
    """

    def __init__(self, envelope: Envelope, codecs: Mapping[str, Codec]) -> None:
        """Args: whose envelopes, and a codec for every topic that is wanted, in the order of the samples."""
        self.envelope = envelope
        self._wanted = [(envelope.topics.index(topic), codec) for topic, codec in codecs.items()]
        self._plans: dict[bytes, _Plan] = {}

    def read(self, data: bytes) -> tuple[Any, ...]:
        """The samples that are wanted; None where a message is absent.

        Args:
            data: The serialised envelope, whose `stamp` has been read.

        Raises:
            MessageError: Cut short, or a message in it cannot be used.
        """
        plan = self._plans.get(self.envelope.lengths(data))
        if plan is None or len(data) < plan.size:
            plan = self._plan(data)
        return plan.read(data)

    def message(self, data: bytes, topic: str) -> bytes:
        """One message as it is, of an envelope that `read` has accepted; empty where it is absent."""
        return self.envelope.open(data)[1][self.envelope.topics.index(topic)]

    def _plan(self, data: bytes) -> _Plan:
        _, messages = self.envelope.open(data)  # refuses what is cut short
        if len(self._plans) >= _LARGEST_CACHE:
            self._plans.clear()
        plan = _Plan(self.envelope.contents, [len(message) for message in messages], self._wanted)
        self._plans[self.envelope.lengths(data)] = plan
        return plan
