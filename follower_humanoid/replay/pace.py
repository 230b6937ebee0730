"""When a recorded moment is due on the wall's clock: rate, pause, stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class Pace:
    """Maps recorded time to wall time; pausing and stopping may come from other threads.

    Attributes:
        rate: Recorded seconds per wall second.
        paused: Whether time stands still.
        stopped: Whether the end was asked for.
    """

    def __init__(
        self, rate: float = 1.0, paused: bool = False, now: Callable[[], int] = time.monotonic_ns
    ) -> None:
        """Args: rate, whether it begins with a pause, and the wall's clock [ns]."""
        self.rate = rate
        self.paused = paused
        self.stopped = False
        self._now = now
        self._changed = threading.Condition()
        self._wall = now()
        self._recorded = 0

    def begin(self, recorded: int) -> None:
        """This recorded moment [ns] is now."""
        with self._changed:
            self._wall, self._recorded = self._now(), recorded

    def pause(self) -> None:
        """Time stands still."""
        with self._changed:
            if not self.paused:
                self._recorded, self._wall = self.reached(), self._now()
                self.paused = True
                self._changed.notify_all()

    def resume(self) -> None:
        """Time goes on from where it stood."""
        with self._changed:
            if self.paused:
                self._wall, self.paused = self._now(), False
                self._changed.notify_all()

    def toggle(self) -> None:
        """Pauses or resumes."""
        with self._changed:
            (self.resume if self.paused else self.pause)()

    def stop(self) -> None:
        """Ends every wait."""
        with self._changed:
            self.stopped = True
            self._changed.notify_all()

    def reached(self) -> int:
        """The recorded moment that is now [ns]."""
        if self.paused:
            return self._recorded
        return self._recorded + round((self._now() - self._wall) * self.rate)

    def wait_for(self, recorded: int) -> bool:
        """Waits until a recorded moment [ns] is due; False when stopped."""
        while not self.stopped:
            if not self.paused:
                left = (recorded - self._recorded) / self.rate - (self._now() - self._wall)
                if left <= 0.0:
                    return True
            with self._changed:
                if self.stopped:
                    break
                # Looked at again under the lock: a pause may have begun since.
                if self.paused:
                    self._changed.wait()
                    continue
                left = (recorded - self._recorded) / self.rate - (self._now() - self._wall)
                if left > 0.0:
                    self._changed.wait(min(left / 1e9, threading.TIMEOUT_MAX))
        return False
