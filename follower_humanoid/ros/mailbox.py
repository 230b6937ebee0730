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

    def add(
        self, subscription: Any, receive: Callable[[bytes], bool], missing: Callable[[], bool]
    ) -> None:
        """Looks after a subscription to serialised messages.

        Args:
            subscription: It.
            receive: Takes a message in; returns whether it was the last one that was missing.
            missing: Whether one of its messages is waited for.
        """
        self.subscriptions.append(subscription)
        self._boxes.append(_Box(subscription.handle, subscription.msg_type, receive, missing))

    def fetch(self) -> bool:
        """Takes what is there of what is missing; returns whether there was anything."""
        found = False
        for box in self._boxes:
            if not box.missing():
                continue
            with box.handle:
                while (taken := box.handle.take_message(box.message_type, True)) is not None:
                    found = True
                    if box.receive(taken[0]):
                        self._last = box
                    if not box.missing():
                        break
        return found

    def wait(self, seconds: float) -> bool:
        """Sleeps until what is missing may be there; returns False at once where nothing is."""
        missing = [box for box in self._boxes if box.missing()]
        if not missing:
            return False
        box = self._last if self._last in missing else missing[0]
        if self._waiting is None:
            self._waiting = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, self._context.handle)
        with ExitStack() as held:
            held.enter_context(self._waiting)
            held.enter_context(box.handle)
            self._waiting.clear_entities()
            self._waiting.add_subscription(box.handle)
            self._waiting.wait(round(seconds * NANOSECONDS))
        return True

    def close(self) -> None:
        """Waits no more."""
        self._boxes.clear()
        if self._waiting is not None:
            self._waiting.destroy_when_not_in_use()
            self._waiting = None
