"""Writes a node's envelopes: numbers and stamps as bytes, put between those that stay the same."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np

from follower_humanoid.core.cdr import NANOSECONDS, STAMP_SIZE
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import STAMP, STAMP_AT, Envelope

_LARGEST_CACHE = 64
_ABSENT = object()
_TIME = struct.Struct("<iI")  # builtin_interfaces/Time


class _Form:
    """Envelopes whose messages are of certain layouts.

    Attributes:
        places: Where each message that is there lies in such an envelope.
    """

    def __init__(self, envelope: Envelope, codecs: Mapping[str, Codec], shapes: Sequence[Hashable]) -> None:
        layouts = {
            topic: codecs[topic].layout(shape)
            for topic, shape in zip(envelope.topics, shapes, strict=True)
            if shape is not _ABSENT
        }
        empty = [bytes(layouts[topic].data) if topic in layouts else b"" for topic in envelope.topics]
        self.places: dict[str, slice] = {}
        spans = {(STAMP_AT, STAMP_AT + STAMP.size)}
        times: list[tuple[int, int]] = []
        blocks: list[tuple[str, Codec, list[tuple[tuple[int, int], np.dtype[Any], int]]]] = []
        at = envelope.contents
        for topic, layout in layouts.items():
            self.places[topic] = slice(at, at + len(layout.data))
            times += [(at + offset, at + offset + STAMP_SIZE) for offset in layout.stamps]
            slots = [
                ((at + s.offset, at + s.end), kind, (s.end - s.offset) // kind.itemsize)
                for s in layout.slots
                for kind in (np.dtype("<" + s.code),)
            ]
            blocks.append((topic, codecs[topic], slots))
            spans.update(span for span, _, _ in slots)
            at += len(layout.data)
        spans.update(times)
        data = envelope.seal(0, empty)
        # The envelope from cut to cut: pieces that change, and between them those that stay the same.
        cuts = sorted({0, len(data), *itertools.chain(*spans)})
        self._pieces = [data[begin:end] for begin, end in itertools.pairwise(cuts)]
        number = {begin: index for index, begin in enumerate(cuts)}
        self._stamp = number[STAMP_AT]
        self._times = [number[begin] for begin, _ in times]
        self._numbers = [
            (topic, codec, [(number[begin], kind, count) for (begin, _), kind, count in slots])
            for topic, codec, slots in blocks
        ]

    def filled(self, samples: Mapping[str, Any], stamp: int) -> bytes:
        """The envelope with these numbers and this stamp [ns].

        Raises:
            ValueError: An array has not the length that its message was laid out for.
        """
        pieces = self._pieces
        pieces[self._stamp] = STAMP.pack(stamp)
        time = _TIME.pack(*divmod(stamp, NANOSECONDS))
        for index in self._times:
            pieces[index] = time
        for topic, codec, slots in self._numbers:
            for (index, kind, count), values in zip(slots, codec.numbers(samples[topic]), strict=True):
                if values.size != count:
                    raise ValueError(f"{topic}: an array of {values.size} numbers in place of {count}")
                pieces[index] = (values if values.dtype is kind else values.astype(kind)).tobytes()
        return b"".join(pieces)


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
            [
                _ABSENT if sample is None else codec.shape(sample)
                for codec, sample in zip(self._ordered, samples.values(), strict=True)
            ]
        )
        form = self._forms.get(shapes)
        if form is None:
            if len(self._forms) >= _LARGEST_CACHE:
                self._forms.clear()
            form = self._forms[shapes] = _Form(self._envelope, self._codecs, shapes)
        return form.filled(samples, stamp), form.places
