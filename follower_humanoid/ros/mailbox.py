"""Messages that a node fetches by itself: nobody wakes it for each.

A node that waits for several others at every tick would be woken several times to do nothing, which costs
more than what it does. So it sleeps until one of the missing messages is there, the one that came last at the
tick before, and then takes them all.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol

from rclpy.impl.implementation_singleton import rclpy_implementation

from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.ros.lines import Ear


class _Source(Protocol):
    """Where messages come from: an `Ear`, or a subscription."""

    open: bool

    def wait(self, seconds: float) -> None: ...

    def take(self) -> bytes | None: ...

    def close(self) -> None: ...


class _Subscribed:
    """A subscription as a source."""

    def __init__(self, subscription: Any, context: Any) -> None:
        self.open = True
        self._handle, self._type = subscription.handle, subscription.msg_type
        self._waiting = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, context.handle)
        self._held = ExitStack()  # else who destroys the subscription takes it away under a wait
        self._held.enter_context(self._waiting)
        self._held.enter_context(self._handle)

    def wait(self, seconds: float) -> None:
        self._waiting.clear_entities()
        self._waiting.add_subscription(self._handle)
        self._waiting.wait(round(seconds * NANOSECONDS))

    def take(self) -> bytes | None:
        taken = self._handle.take_message(self._type, True)
        return None if taken is None else taken[0]

    def close(self) -> None:
        if not self.open:
            return
        self.open = False
        self._held.close()
        self._waiting.destroy_when_not_in_use()


@dataclass(frozen=True, eq=False)
class _Box:
    """What comes from one source.

    Attributes:
        source: Where from.
        receive: Takes a serialised message in; returns whether it was the last one that was missing.
        missing: Whether a message is waited for.
    """

    source: _Source
    receive: Callable[[bytes], bool]
    missing: Callable[[], bool]


class Mailbox:
    """Subscriptions and lines that no executor looks after.

    Attributes:
        subscriptions: Those of them that are subscriptions, read or not.
    """

    def __init__(self, context: Any) -> None:
        """Empty. Args: the node's rclpy context."""
        self.subscriptions: list[Any] = []
        self._context = context
        self._boxes: list[_Box] = []
        self._last: _Box | None = None

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
        self._boxes.append(_Box(_Subscribed(subscription, self._context), receive, missing))

    def add_line(
        self, line: Ear, unread: Any, receive: Callable[[bytes], bool], missing: Callable[[], bool]
    ) -> None:
        """Looks after a line.

        Args:
            line: It.
            unread: The subscription whose messages come this way; it only shows who hears whom.
            receive, missing: See `add`.
        """
        self.subscriptions.append(unread)
        self._boxes.append(_Box(line, receive, missing))

    def fetch(self, seconds: float) -> bool:
        """Sleeps until something that is missing is there, then takes all that is there of what is missing.

        Args:
            seconds: The longest that it sleeps [s].

        Returns:
            False at once where nothing is missing, or only what cannot come any more.
        """
        missing = [box for box in self._boxes if box.missing() and box.source.open]
        if not missing:
            return False
        awaited = self._last if self._last in missing else missing[0]
        awaited.source.wait(seconds)
        for box in missing:
            while (data := box.source.take()) is not None:
                if box.receive(data):
                    self._last = box
                if not box.missing():
                    break
        return True

    def close(self) -> None:
        """Lets go of them; nothing is fetched any more."""
        for box in self._boxes:
            box.source.close()
        self._boxes.clear()
