"""Checks on messages from publishers that are not ours: names, lengths, frames, finite numbers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import FollowerError


class MessageError(FollowerError):
    """A message that cannot be used: names the topic and the reason."""

    def __init__(self, topic: str, reason: str) -> None:
        super().__init__(f"message on {topic} rejected: {reason}")
        self.topic = topic


def finite(topic: str, values: Array) -> Array:
    """The values themselves, shape (n,).

    Raises:
        MessageError: One of them is not finite.
    """
    # One dot product is a third of the price of isfinite().all(); a sum of squares that overflows
    # only leads to the careful look.
    if not math.isfinite(values.dot(values)) and not np.isfinite(values).all():
        raise MessageError(topic, f"number {int(np.flatnonzero(~np.isfinite(values))[0]) + 1} is not finite")
    return values


def order_of(
    topic: str, names: Sequence[str], wanted: Sequence[str], optional: Sequence[str] = ()
) -> list[int]:
    """Where each wanted name stands among the names of a message; −1 for an optional one left out.

    Raises:
        MessageError: A name is missing, unknown or given twice.
    """
    place = {name: index for index, name in enumerate(names)}
    if len(place) != len(names):
        twice = sorted(name for name, times in Counter(names).items() if times > 1)
        raise MessageError(topic, f"name given twice: {_some(twice)}")
    unknown = sorted(place.keys() - set(wanted))
    if unknown:
        raise MessageError(topic, f"unknown name: {_some(unknown)}; valid: {', '.join(wanted)}")
    missing = [name for name in wanted if name not in place and name not in optional]
    if missing:
        raise MessageError(topic, f"name missing: {_some(missing)}")
    return [place.get(name, -1) for name in wanted]


def column(
    topic: str,
    label: str,
    values: Sequence[float],
    order: list[int],
    count: int,
    missing: float | None = None,
) -> Array:
    """One array of a JointState in our order.

    Args:
        topic, label: For the error.
        values: The message's array.
        order: From `order_of`, without left-out names.
        count: Number of names in the message.
        missing: What an empty array stands for; None where the array must be there.

    Raises:
        MessageError: Wrong length or not finite.
    """
    if len(values) == 0 and missing is not None:
        return np.full(len(order), missing)
    if len(values) != count:
        raise MessageError(topic, f"{label} has {len(values)} entries for {count} names")
    return finite(topic, np.array(values, dtype=np.float64)[order])


def check_frame(topic: str, frame: str, wanted: str) -> None:
    """Accepts the frame, the frame with a prefix (`robot1/l_sole`), or none said.

    Raises:
        MessageError: Another frame.
    """
    if frame and frame.rsplit("/", 1)[-1] != wanted:
        raise MessageError(topic, f"frame '{frame}'; needs '{wanted}'")


def _some(names: Sequence[str]) -> str:
    listed = ", ".join(names[:5])
    return listed if len(names) <= 5 else f"{listed} and {len(names) - 5} more"
