"""Whether anybody listens to a publisher besides those who hear the same another way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_AGAIN = 40  # looks after which it is asked again although the number of listeners is the same


class Listeners:
    """Who listens to one publisher, looked at now and then.

    Attributes:
        others: Whether there is anybody who depends on what is published.
    """

    def __init__(self, node: Any, publisher: Any, hearers: Callable[[], frozenset[str]]) -> None:
        """Nobody has been found yet.

        Args:
            node: Whose publisher.
            publisher: It.
            hearers: Names of nodes of the same namespace that hear the same another way.
        """
        self.others = False
        self._node, self._publisher, self._hearers = node, publisher, hearers
        self._seen: tuple[int, frozenset[str]] = (0, frozenset())
        self._looks = 0

    def look(self) -> bool:
        """Finds out about `others`."""
        seen = self._publisher.get_subscription_count(), self._hearers()
        self._looks += 1
        if seen != self._seen or self._looks % _AGAIN == 0:  # names cost more than a number
            self._seen = seen
            self.others = self._find(*seen)
        return self.others

    def _find(self, count: int, hearers: frozenset[str]) -> bool:
        if count == 0 or not hearers:
            return count > 0
        # The number is known before the names: who has none yet is a stranger.
        namespace = self._node.get_namespace()
        infos = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
        known = [i for i in infos if i.node_name in hearers and i.node_namespace == namespace]
        return count > len(known)
