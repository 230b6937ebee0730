"""Everything begins anew at one tick, which the simulator tells all nodes ahead."""

from __future__ import annotations

from typing import TYPE_CHECKING

from std_msgs.msg import Header

from follower_humanoid.core.cdr import stamp_of
from follower_humanoid.ros.barrier import RESET, Announcer
from follower_humanoid.ros.leaving import AHEAD
from follower_humanoid.ros.validation import MessageError

if TYPE_CHECKING:
    from follower_humanoid.ros.lockstep_node import LockStepNode


class Resets:
    """When a node begins anew.

    Attributes:
        due_at: Tick from which everything begins anew, None where no reset is on its way.
    """

    def __init__(self, node: LockStepNode, announcer: Announcer) -> None:
        """Args: whose they are, and how it says that it knows of one."""
        self._node, self._announcer = node, announcer
        self.due_at: int | None = None

    def hear(self) -> None:
        """Subscribes to what the simulator says."""
        self._node.make_subscription(Header, RESET, self._receive)

    def _receive(self, data: bytes) -> None:
        tick, rest = divmod(stamp_of(data), self._node.tick_ns)
        # One that has just come back is a little ahead of the others. Of two the earlier one counts.
        earliest = self._node.lock.tick - 2 * AHEAD
        if rest or tick < earliest or (self.due_at is not None and tick > self.due_at):
            self._node.reject(MessageError(RESET, f"tick {tick} is not one to begin anew at"))
            return
        self.due_at = tick
        self._announcer.announce_reset(tick)
        self._node.run_ready_steps()

    def begin_if_due(self) -> int | None:
        """Resets the component at the tick of a reset, and returns that tick; None where none is due."""
        due = self.due_at
        if due is None or self._node.lock.tick < due:
            return None
        self.due_at = None
        if self._node.component is not None:
            self._node.reset()
        return due
