"""How a lock-stepped node begins: it looks again and again whether all others are found, then goes on."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from follower_humanoid.ros.barrier import Barrier

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode

_POLL = 0.02
_TELL_EVERY = 5.0


class Starting:
    """One node at its start barrier.

    Attributes:
        barrier: What it waits for; None until the node has endpoints.
    """

    def __init__(self, node: LockStepNode) -> None:
        """Args: who begins."""
        self.barrier: Barrier | None = None
        self._node = node
        self._told_at = time.monotonic()
        self._timer = node.make_timer(_POLL, self._look)
        self._timer.cancel()

    def begin(self) -> None:
        """Looks from now on."""
        self._told_at = time.monotonic()
        self._timer.reset()

    def hold(self) -> None:
        """Looks no more."""
        self._timer.cancel()

    def _look(self) -> None:
        node, barrier = self._node, self.barrier
        waiting = barrier.waiting_for() if barrier is not None else []
        waiting = waiting or node.still_waiting_for()
        now = time.monotonic()
        if not waiting:
            self._timer.cancel()
            node.all_found()
        elif now - self._told_at > _TELL_EVERY:
            self._told_at = now
            node.logger.info(f"waiting for {'; '.join(waiting)}")
