"""Pages that hold a hand are asked again and again whether they are still there."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from follower_humanoid.viewer.hands import Hands

_EVERY = 0.3  # wall time between two questions to a page [s]


class Heartbeat:
    """Asks each page by itself: one that hangs must not keep the others from being heard."""

    def __init__(self, hands: Hands, clients: Callable[[], Mapping[int, Any]], patience: float) -> None:
        """Begins to ask.

        Args:
            hands: Who holds them; told of signs of life.
            clients: The connected pages, by their number.
            patience: How long an answer may take [s].
        """
        self._hands, self._clients, self._patience = hands, clients, patience
        self._over = threading.Event()
        self._asked: set[int] = set()  # pages that have not answered yet
        threading.Thread(target=self._beat, daemon=True).start()

    def end(self) -> None:
        """Asks no more."""
        self._over.set()

    def _beat(self) -> None:
        while not self._over.wait(_EVERY):
            for number in self._hands.pages():
                client = self._clients().get(number)
                if client is None:
                    self._hands.gone(number)
                elif number not in self._asked:
                    self._asked.add(number)
                    threading.Thread(target=self._ask, args=(number, client), daemon=True).start()

    def _ask(self, number: int, client: Any) -> None:
        # No answer in time: nothing is heard, and its hold runs out.
        try:
            with suppress(RuntimeError, TimeoutError):
                client.local_storage.get_item("follower", timeout=self._patience)
                self._hands.heard(number, time.monotonic())
        finally:
            self._asked.discard(number)
