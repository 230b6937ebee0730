"""Looks at a lock-stepped node every second: does it go on, and if not, for whom does it wait?"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode

_PATIENCE = 1.0  # wall time for a stranger who may not keep the ticks [s]


class Watchdog:
    """Stops waiting for strangers who do not keep the ticks, and complains of all others.

    Attributes:
        given_up: How often a message was waited for in vain.
    """

    def __init__(self, node: LockStepNode) -> None:
        """Args: whom to look at."""
        self._node = node
        self.given_up = 0
        self._steps = self._strange = 0
        self._progress_at = time.monotonic()
        node.make_timer(_PATIENCE, self._look)

    def calm(self) -> None:
        """The wait begins now."""
        self._progress_at = time.monotonic()

    def _look(self) -> None:
        node, now = self._node, time.monotonic()
        node.flush()
        if node.steps != self._steps or not (node.started and node.running):
            self._steps, self._progress_at = node.steps, now
            return
        waited = now - self._progress_at
        if node.lock.strange != self._strange and not node.away:
            self._strange = node.lock.strange
            node.catch_up()
        if waited >= _PATIENCE and (given_up := node.lock.give_up()):
            self.given_up += len(given_up)
            for missing in given_up:
                node.logger.warning(f"no {missing}: its newest message is held from now on")
            node.run_ready_steps()
        elif node.graph.watchdog and waited > node.graph.watchdog:
            node.stalled(waited, "; ".join(str(missing) for missing in node.lock.missing()))
