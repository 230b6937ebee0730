"""Looks at a lock-stepped node every second: does it go on, and if not, for whom does it wait?

A node of a bringup is ended by it. One that somebody has started ends itself when the run is over in which it
took part: it has seen more of simulated time than a new run begins with.
"""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.spin import PARENT

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode

_PATIENCE = 1.0  # wall time for a stranger who may not keep the ticks [s]
_SURE = 2  # looks in a row


class Watchdog:
    """Stops waiting for strangers who do not keep the ticks, and complains of all others.

    Attributes:
        given_up: How often a message was waited for in vain.
    """

    def __init__(self, node: LockStepNode) -> None:
        """Args: whom to look at."""
        self._node = node
        self.given_up = 0
        self._steps = self._strange = self._late = self._over = 0
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
            self._late, self._over = node.lock.late, 0
            return
        if PARENT not in os.environ and (reason := self._why_over()):
            node.logger.warning(reason)
            node.quit(0, reason)
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

    def _why_over(self) -> str:
        """Why the run is over for a node that stands still; empty where it is not, or not for sure."""
        node = self._node
        if node.wiring.name == SIMULATOR or SIMULATOR not in node.present:
            return ""
        gone, anew = node.count_publishers(CLOCK) == 0, node.lock.late > self._late
        self._late = node.lock.late
        self._over = self._over + 1 if gone or anew else 0
        if self._over < _SURE:
            return ""
        reason = "its simulator has gone" if gone else "simulated time has begun again"
        return f"the run is over: {reason}; start this node again for another one"
