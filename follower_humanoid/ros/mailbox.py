"""Messages that a node fetches by itself: nobody wakes it for each.

A node that waits for several others at every tick would be woken several times to do nothing, which costs
more than what it does. So it sleeps until one of the missing messages is there, the one that came last at the
tick before, and then takes them all.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation

from follower_humanoid.core.cdr import NANOSECONDS


@dataclass(frozen=True, eq=False)
class _Box:
    """One subscription.

    Attributes:
        handle, message_type: Of the subscription.
        receive: Takes a serialised message in; returns whether it was the last one that was missing.
        missing: Whether a message is waited for.
    """

    handle: Any
    message_type: type
    receive: Callable[[bytes], bool]
    missing: Callable[[], bool]


class Mailbox:
    """Subscriptions that no executor looks after.

    Attributes:
        subscriptions: They.
    """

    def __init__(self, context: Any) -> None:
        """Empty. Args: the node's rclpy context."""
        self.subscriptions: list[Any] = []
        self._context = context
        self._boxes: list[_Box] = []
        self._last: _Box | None = None
        self._waiting: Any = None
        self._held = ExitStack()

    def add(
        self, subscription: Any, receive: Callable[[bytes], bool], missing: Callable[[], bool]
    ) -> None:
        """Looks after a subscription to serialised messages.

        Args:
            subscription: It.
            receive: Takes a message in; returns whether it was the last one that was missing.
            missing: Whether one of its messages is waited for.
        """
        if self._waiting is not None:
            raise RuntimeError("a subscription was added to a mailbox in use")
        self.subscriptions.append(subscription)
        self._boxes.append(_Box(subscription.handle, subscription.msg_type, receive, missing))

    def fetch(self, seconds: float) -> bool:
        """Sleeps until something that is missing is there, then takes all that is there of what is missing.

        Args:
            seconds: The longest that it sleeps [s].

        Returns:
            False at once where nothing is missing.
        """
        missing = [box for box in self._boxes if box.missing()]
        if not missing:
            return False
        awaited = self._last if self._last in missing else missing[0]
        waiting = self._wait_set()
        waiting.clear_entities()
        waiting.add_subscription(awaited.handle)
        waiting.wait(round(seconds * NANOSECONDS))
        for box in missing:
            while (taken := box.handle.take_message(box.message_type, True)) is not None:
                if box.receive(taken[0]):
                    self._last = box
                if not box.missing():
                    break
        return True

    def _wait_set(self) -> Any:
        if self._waiting is None:
            self._waiting = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, self._context.handle)
            self._held.enter_context(self._waiting)
            for box in self._boxes:
                self._held.enter_context(box.handle)
        return self._waiting

    def close(self) -> None:
        """Lets go of the subscriptions; nothing is fetched any more."""
        self._boxes.clear()
        self._held.close()
        if self._waiting is not None:
            self._waiting.destroy_when_not_in_use()
            self._waiting = None
