"""Hands samples from node to node within one process: by reference, nothing is serialised.

A node that has received what it waited for is put into a queue and takes its step from there, not
within the step of the node that sent: however many nodes there are, no call is nested in another.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from typing import Any

from rclpy.task import Future

# Tick, topic → sample of all that a node publishes, topic → the same as a message where it was made anyway.
# Returns whether the receiver can step now.
Accept = Callable[[int, Mapping[str, Any], Mapping[str, bytes]], bool]


class Bus:
    """The nodes of one process."""

    def __init__(self, names: Collection[str]) -> None:
        """Args: the nodes that will join."""
        self._names = frozenset(names)
        self._steps: dict[str, Callable[[], None]] = {}
        self._hearers: dict[str, dict[str, tuple[Accept, Callable[[], None]]]] = {}
        self._ready: deque[Callable[[], None]] = deque()
        self._working = False
        self._called: Any = Future()

    def join(self, name: str, step: Callable[[], None]) -> None:
        """Adds a node: what steps when all samples are there."""
        self._steps[name] = step

    def __contains__(self, name: str) -> bool:
        """Whether a node is in this process."""
        return name in self._names

    def listen(self, name: str, producer: str, accept: Accept) -> None:
        """The node `name` takes in what `producer` sends from now on."""
        self._hearers.setdefault(producer, {})[name] = (accept, self._steps[name])

    def post(
        self, producer: str, tick: int, samples: Mapping[str, Any], messages: Mapping[str, bytes]
    ) -> None:
        """Hands one tick's samples to every listener."""
        for accept, step in self._hearers.get(producer, {}).values():
            if accept(tick, samples, messages):
                self._ready.append(step)
        if self._ready and not self._working:
            self.call()

    def call(self) -> None:
        """Says that there is something to look after."""
        if not self._called.done():
            self._called.set_result(None)

    def future(self) -> Any:
        """Completes when there is work. For one wait: an executor leaves a callback in what it waits for."""
        self._called = Future()
        if self._ready:
            self._called.set_result(None)
        return self._called

    def work(self, seconds: float) -> bool:
        """Takes steps for a while; returns whether there are more."""
        until = time.monotonic() + seconds
        self._working = True
        try:
            while self._ready:
                self._ready.popleft()()
                if time.monotonic() > until:
                    break
        finally:
            self._working = False
        return bool(self._ready)
