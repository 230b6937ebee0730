"""One fault that is tried: the table of `benchmark --faults` has a line for each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from follower_humanoid.bench.check import Check


@dataclass(frozen=True)
class Effort:
    """How long a fault is tried.

    Attributes:
        brief: The short form, which fits into a run of the tests; the long one takes up to an hour.
    """

    brief: bool

    def count(self, brief: int, long: int) -> int:
        """A number of tries."""
        return brief if self.brief else long


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    Attributes:
        name: As in the table.
        try_it: Does it; a line of the table per thing that must hold.
        brief: Part of the short form.
    """

    name: str
    try_it: Callable[[Effort], Iterator[Check]]
    brief: bool = True


def survived(fault: str, required: str, observed: str, good: bool) -> Check:
    """A line of the table."""
    return Check(fault, required, observed, good)
