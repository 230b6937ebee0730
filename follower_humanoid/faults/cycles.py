"""Starts and stops, one after the other, in one process and in one per node."""

from __future__ import annotations

import signal
from collections.abc import Iterator

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import graph_run
from follower_humanoid.faults.nodes import end_of, ended_well


def cycles(effort: Effort) -> Iterator[Check]:
    """A line for all of them."""
    count = effort.count(5, 50)
    slowest, faults = 0.0, []
    for number in range(count):
        options = ("--leader", "fig4", *(("--composed",) if number % 2 else ()))
        with graph_run(*options) as run:
            started = run.reaches(0.1)
            slowest = max(slowest, run.end(signal.SIGINT if number % 3 else signal.SIGTERM))
            if not started or run.status() != 0 or not ended_well(run):
                faults.append(f"{number}: status {run.status()}, {end_of(run)}, {run.last_words!r}")
    observed = f"{count - len(faults)} well, slowest stop {slowest:.1f} s"
    observed += "".join(f"; {fault}" for fault in faults[:3])
    yield survived(f"{count} starts and stops", "status 0, no orphan, readable bags", observed, not faults)
