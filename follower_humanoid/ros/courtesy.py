"""Who goes first where a graph has more processes than the machine has processors.

For a tick's state and motor commands everybody waits, so their processes are woken at once. What is used a
tick later, or only kept, is made in between: such a process does not interrupt anybody when a message wakes
it, which matters since a node sends to up to seven others per tick, and has a little less of a processor.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from contextlib import suppress

from follower_humanoid.graph.wiring import NODES

_A_LITTLE = 2  # niceness; more would leave too little beside other people's programs
_ASIDE = 10  # of who only looks on; Linux's idle policy would stop its page on a full machine


def give_way(nodes: Collection[str], aside: bool) -> None:
    """Sets the scheduling of this process, one of bringup's; nodes started by hand stay as they are.

    Args:
        nodes: In it.
        aside: Whether it only looks on, so that everybody goes before it.
    """
    if not aside and any(NODES[name].same_tick for name in nodes if name in NODES):
        return
    os.nice(_ASIDE if aside else _A_LITTLE)
    if hasattr(os, "SCHED_BATCH"):
        with suppress(OSError):  # not allowed everywhere, and not needed
            os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
