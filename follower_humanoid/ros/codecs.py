"""Samples to bytes and back, bit for bit.

Our own messages are equal outside their numbers and stamp, so the numbers are copied at known
offsets without ever building a message object. Bytes that differ anywhere else come from another
publisher (other order of names, other frame): those are deserialised and checked.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message

from follower_humanoid.core.cdr import STAMP_SIZE, put_stamp
from follower_humanoid.core.samples import Array
from follower_humanoid.core.topics import TOPICS
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.cdr import CdrWriter, Slot
from follower_humanoid.ros.formats import format_of
from follower_humanoid.ros.layouts import Format
from follower_humanoid.ros.quiet import quiet_stderr
from follower_humanoid.ros.validation import MessageError, finite

_LARGEST_CACHE = 64
_LONGEST_LEARNT = 1 << 14  # bytes; whose own messages are longer is a stranger


class Layout:
    """One template and where its numbers lie.

    Attributes:
        data: The message as it was filled last.
        stamps: Where its stamps lie.
        slots: Where its numbers lie, block by block.
        views: The numbers in `data`, block by block.
        fixed: First byte, first byte behind, and bytes of what is equal in every message of this layout.
    """

    def __init__(self, form: Format, shape: Hashable) -> None:
        message, blocks = form.template(shape)
        writer = CdrWriter(message)
        self.data = bytearray(writer.data)
        self.stamps = [
            slot.offset for path, slot in writer.slots.items() if path.endswith("header.stamp.sec")
        ]
        self.slots = [
            Slot(writer.slots[path].offset, writer.slots[path].code, count) for path, count in blocks
        ]
        self.views = [
            np.frombuffer(self.data, np.dtype("<" + slot.code), slot.count, slot.offset)
            for slot in self.slots
        ]
        self.fixed = self._fixed_parts()
        if form.fast_reading:
            self._span_offset = self.slots[0].offset
            first = self._span_offset
            self._within_span = [
                ((slot.offset - first) // 8, (slot.end - first) // 8) for slot in self.slots
            ]
            self._span = self._within_span[-1][1]

    def _fixed_parts(self) -> list[tuple[int, int, bytes]]:
        """What must be equal in every message of this layout: all but stamps and numbers."""
        taken = [(offset, offset + STAMP_SIZE) for offset in self.stamps]
        taken += [(slot.offset, slot.end) for slot in self.slots]
        parts, at = [], 0
        for begin, end in [*sorted(taken), (len(self.data), len(self.data))]:
            if begin > at:
                parts.append((at, begin, bytes(self.data[at:begin])))
            at = end
        return parts

    def fill(self, numbers: tuple[Any, ...], stamp: int) -> bytes:
        """The message with these numbers and this stamp [ns]."""
        for view, values in zip(self.views, numbers, strict=True):
            view[:] = values
        for offset in self.stamps:
            put_stamp(self.data, offset, stamp)
        return bytes(self.data)

    def blocks(self, topic: str, data: bytes) -> list[Array]:
        """The numbers in a message that fits, block by block.

        Raises:
            MessageError: A number is not finite.
        """
        # From the first block to the last in one go: cheaper than one by one, and what lies between
        # (lengths, covariances of ours) reads as finite numbers too. Copied, because the bytes are
        # read-only and not aligned to 8.
        span = np.frombuffer(data, np.float64, self._span, self._span_offset).copy()
        if not math.isfinite(span.dot(span)):
            for begin, end in self._within_span:
                finite(topic, span[begin:end])
        return [span[begin:end] for begin, end in self._within_span]

    def numbers(self, topic: str, data: bytes) -> list[Array]:
        """The numbers in a message that fits, whatever their precision, block by block.

        Raises:
            MessageError: A number is not finite.
        """
        return [
            finite(topic, np.frombuffer(data, "<" + slot.code, slot.count, slot.offset).astype(np.float64))
            for slot in self.slots
        ]

    def fits(self, data: bytes) -> bool:
        """Whether a message differs from this one in stamp and numbers only."""
        if len(data) != len(self.data):
            return False
        return all(data[begin:end] == part for begin, end, part in self.fixed)


class Codec:
    """Encodes and decodes one topic.

    Attributes:
        topic: Name of the topic.
        message_type: ROS message class.
        shape: What decides the layout of a sample.
        numbers: The numbers of a sample, block by block as in its layout.
        read_layout: Our own messages on the topic; None where they have several layouts.
    """

    def __init__(self, topic: str, robot: RobotModel) -> None:
        """Args: relative name of the topic and the robot whose joints it may list."""
        self.topic = topic
        self._format = format_of(TOPICS[topic], robot)
        self.message_type = self._format.message_type
        self._layouts: dict[Hashable, Layout] = {}
        self.shape, self.numbers = self._format.shape, self._format.numbers
        self.read_layout = self.layout(None) if self._format.fast_reading else None
        # Length of a message → layout and shape of the last one that was so long, where there are several.
        self._learnt: dict[int, tuple[Layout, Hashable]] = {}

    def layout(self, shape: Hashable) -> Layout:
        """The layout of samples of a shape; made when it is asked for first."""
        layout = self._layouts.get(shape)
        if layout is None:
            if len(self._layouts) >= _LARGEST_CACHE:
                self._layouts.clear()
            layout = self._layouts[shape] = Layout(self._format, shape)
        return layout

    def encode(self, sample: Any, stamp: int) -> bytes:
        """The serialised message; `stamp` in [ns]."""
        return self.layout(self.shape(sample)).fill(self.numbers(sample), stamp)

    def decode(self, data: bytes) -> Any:
        """The sample in a serialised message.

        Raises:
            MessageError: The message cannot be used.
        """
        layout = self.read_layout
        if layout is None:
            return self._decode_any(data)
        if not layout.fits(data):
            return self._read(data)
        return self.made_of(layout.blocks(self.topic, data))

    def made_of(self, blocks: list[Array]) -> Any:
        """The sample with these numbers, block by block as in `read_layout`."""
        return self._format.sample(blocks, None)

    def _decode_any(self, data: bytes) -> Any:
        """Reads our own messages of several layouts like the last one of the same length, if it is alike."""
        layout, shape = self._learnt.get(len(data), (None, None))
        if layout is not None and layout.fits(data):
            return self._format.sample(layout.numbers(self.topic, data), shape)
        sample = self._read(data)
        if len(data) <= _LONGEST_LEARNT:
            shape = self.shape(sample)
            if len(self._learnt) >= _LARGEST_CACHE:
                self._learnt.clear()
            self._learnt[len(data)] = self.layout(shape), shape
        return sample

    def _read(self, data: bytes) -> Any:
        try:
            with quiet_stderr():  # the deserialiser has words of its own for each, as many as there are
                message = deserialize_message(data, self.message_type)
        except Exception as error:  # rclpy raises no narrower type than RMWError, and not always that
            raise MessageError(self.topic, f"not a {self.message_type.__name__}: {error}") from None
        return self._format.read(message)
