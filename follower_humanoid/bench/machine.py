"""What a machine does to whoever must keep time on it: a loop that works and rests, and nothing else."""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median

from follower_humanoid.graph.pace import Pace

_LOOK = 0.0002  # between two looks at the clock while there is nothing to do [s]
_TRIALS = 200


def own_lateness(tick: float, share: float, ticks: int) -> float:
    """Lateness of 99 % of the ticks of a loop that computes for a share of each, paced like the simulator.

    What is late here is late without any of our nodes: a machine that others share halts now and then.

    Args:
        tick: Length of a tick [s].
        share: Part of a tick for which it computes, below 1.
        ticks: How many.

    Returns:
        Wall time [s].
    """
    rounds = _rounds_within(share * tick)
    return paced_lateness(tick, ticks, lambda: _compute(rounds), time.monotonic, time.sleep)


def paced_lateness(
    tick: float, ticks: int,
    work: Callable[[], object], now: Callable[[], float], rest: Callable[[float], None],
) -> float:  # fmt: skip
    """The same for any work and clock. Args: see `own_lateness`; `rest` lets time pass [s]."""
    pace = Pace(tick, now(), 0)
    for n in range(1, ticks + 1):
        while not pace.may_begin(n, now()):
            rest(_LOOK)
        work()
    (late,) = pace.late.percentiles(99.0)
    return late


def _rounds_within(seconds: float) -> int:
    """How often `_compute` goes round in that time, as a rule."""
    probe = 1000
    spent = []
    for _ in range(_TRIALS):
        begin = time.perf_counter()
        _compute(probe)
        spent.append(time.perf_counter() - begin)
    return max(1, round(probe * seconds / median(spent)))


def _compute(rounds: int) -> int:
    total = 0
    for n in range(rounds):
        total += n * n
    return total
