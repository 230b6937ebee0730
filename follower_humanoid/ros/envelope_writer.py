"""Writes a node's envelopes: numbers and stamps go straight to their places in a copy that is kept."""

from __future__ import annotations

import struct
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.cdr import NANOSECONDS, STAMP_SIZE
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope

_LARGEST_CACHE = 64
_ABSENT = object()
_STAMP = struct.Struct("<iI")  # builtin_interfaces/Time


class _Form:
    """Envelopes whose messages are of certain layouts.

    Attributes:
        data: The envelope as it was filled last.
        places: Where each message that is there lies in it.
    """

    def __init__(self, envelope: Envelope, codecs: Mapping[str, Codec], shapes: Sequence[Hashable]) -> None:
        layouts = {
            topic: codecs[topic].layout(shape)
            for topic, shape in zip(envelope.topics, shapes, strict=True)
            if shape is not _ABSENT
        }
        empty = [bytes(layouts[topic].data) if topic in layouts else b"" for topic in envelope.topics]
        self.data = bytearray(envelope.seal(0, empty))
        self.places: dict[str, slice] = {}
        self._stamps: list[slice] = []
        self._views: list[tuple[str, Codec, list[NDArray[Any]]]] = []
        at = envelope.contents
        for topic, layout in layouts.items():
            self.places[topic] = slice(at, at + len(layout.data))
            self._stamps += [slice(at + offset, at + offset + STAMP_SIZE) for offset in layout.stamps]
            views = [
                np.frombuffer(self.data, np.dtype("<" + slot.code), slot.count, at + slot.offset)
                for slot in layout.slots
            ]
            self._views.append((topic, codecs[topic], views))
            at += len(layout.data)

    def fill(self, samples: Mapping[str, Any], stamp: int) -> None:
        """Writes these numbers and this stamp [ns]."""
        for topic, codec, views in self._views:
            for view, values in zip(views, codec.numbers(samples[topic]), strict=True):
                view[:] = values
        time = _STAMP.pack(*divmod(stamp, NANOSECONDS))
        for place in self._stamps:
            self.data[place] = time


class EnvelopeWriter:
    """Makes the envelopes of one node."""

    def __init__(self, envelope: Envelope, codecs: Mapping[str, Codec]) -> None:
        """Args: the envelope, and a codec for every topic in it."""
        self._envelope, self._codecs = envelope, codecs
        self._ordered = [codecs[topic] for topic in envelope.topics]
        self._forms: dict[tuple[Hashable, ...], _Form] = {}

    def seal(self, samples: Mapping[str, Any], stamp: int) -> tuple[bytes, dict[str, slice]]:
        """The serialised envelope, and where each message that is there lies in it.

        Args:
            samples: Topic → sample, in the order of the envelope; None where there is none at this tick.
            stamp: Time of the tick [ns].
        """
        shapes = tuple(
            _ABSENT if sample is None else codec.shape(sample)
            for codec, sample in zip(self._ordered, samples.values(), strict=True)
        )
        form = self._forms.get(shapes)
        if form is None:
            if len(self._forms) >= _LARGEST_CACHE:
                self._forms.clear()
            form = self._forms[shapes] = _Form(self._envelope, self._codecs, shapes)
        form.fill(samples, stamp)
        self._envelope.put_stamp(form.data, stamp)
        return bytes(form.data), form.places
