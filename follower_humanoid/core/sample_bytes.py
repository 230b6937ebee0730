"""A component's inputs or outputs as bytes, for another process: the same bits at the other end."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import lru_cache
from operator import attrgetter
from typing import Any

import numpy as np

from follower_humanoid.core.samples import Inertial, Joints, Odometry, Wrench

# Of each sample: which of `_KINDS`, the lengths of its arrays, and its text where it has one; None where
# nothing came.
Layout = tuple[tuple[int, tuple[int, ...], str] | None, ...]

_KINDS: tuple[type, ...] = (Joints, Odometry, Inertial, Wrench)
_TEXT = "frame"


def _arrays_of(kind: type) -> Callable[[Any], tuple[Any, ...]]:
    return attrgetter(*(field.name for field in fields(kind) if field.name != _TEXT))


_GETTERS = {kind: (number, _arrays_of(kind)) for number, kind in enumerate(_KINDS)}


def packed(samples: Iterable[Any]) -> tuple[Layout, bytes]:
    """How samples lie one after the other, and their numbers.

    Args:
        samples: Of joints, odometry, inertial measurements and wrenches; None where nothing came.

    Raises:
        KeyError: A sample of another kind.
    """
    layout: list[tuple[int, tuple[int, ...], str] | None] = []
    arrays: list[Any] = []
    for sample in samples:
        if sample is None:
            layout.append(None)
            continue
        kind = type(sample)
        number, arrays_of = _GETTERS[kind]
        own = arrays_of(sample)
        arrays += own
        layout.append((number, tuple(map(len, own)), sample.frame if kind is Wrench else ""))
    return tuple(layout), b"".join(arrays)


def unpacked(layout: Layout, data: bytes) -> list[Any]:
    """The samples again, with arrays of their own."""
    numbers = np.frombuffer(data).copy()
    return [None if make is None else make(numbers) for make in _makers(layout)]


@lru_cache(maxsize=64)
def _makers(layout: Layout) -> tuple[Callable[[Any], Any] | None, ...]:
    makers: list[Callable[[Any], Any] | None] = []
    begin = 0
    for entry in layout:
        if entry is None:
            makers.append(None)
            continue
        number, lengths, text = entry
        ends = np.cumsum((begin, *lengths)).tolist()
        places = [slice(a, b) for a, b in itertools.pairwise(ends)]
        makers.append(_maker(_KINDS[number], places, text))
        begin = ends[-1]
    return tuple(makers)


def _maker(kind: type, places: list[slice], text: str) -> Callable[[Any], Any]:
    if kind is Wrench:
        force, torque = places
        return lambda numbers: Wrench(numbers[force], numbers[torque], text)
    return lambda numbers: kind(*[numbers[place] for place in places])
