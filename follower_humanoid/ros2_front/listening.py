"""Hears a topic by emptying the queue of a subscription: no executor, exact times of arrival."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.utilities import ok

from follower_humanoid.ros2_front.graph import wait_for

_PAUSE = 0.01
_FIRST = 1.0


def topic_type(node: Node, name: str) -> str | None:
    """Type of a topic, None while nobody is known to use it."""
    types = dict(node.get_topic_names_and_types()).get(name)
    return str(types[0]) if types else None


def publishers_of(node: Node, name: str) -> list[Any]:
    """Who publishes a topic; waits a moment for the first of them."""
    return wait_for(lambda: node.get_publishers_info_by_topic(name) or None, _FIRST) or []


class Ear:
    """One subscription."""

    def __init__(self, node: Node, message_class: Any, name: str, qos: QoSProfile, raw: bool = False) -> None:
        """Args: where, what, how reliably, and whether serialized messages are wanted."""
        self._class, self._raw = message_class, raw
        self._subscription: Any = node.create_subscription(message_class, name, lambda _: None, qos, raw=raw)

    def arrived(self) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Messages since the last look, each with its times (`received_timestamp` [ns], ...)."""
        handle = self._subscription.handle
        with handle:
            while (taken := handle.take_message(self._class, self._raw)) is not None:
                yield taken


def pause() -> bool:
    """Waits a little; False once the process is asked to stop."""
    time.sleep(_PAUSE)
    return bool(ok())
