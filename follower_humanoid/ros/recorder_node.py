"""The node that writes the run into a bag: a timer empties the queues of what it listens to."""

from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from follower_humanoid.bag.about import about_run, texts_in
from follower_humanoid.bag.recorder import RecorderConfig, Recording
from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.ros.barrier import Announcer
from follower_humanoid.ros.managed_node import FAILED, ManagedNode
from follower_humanoid.ros.outcome import CLOSED_AT, MISSED_TICKS
from follower_humanoid.ros.parameters import declare
from follower_humanoid.ros.recorder_taps import RecorderTaps

_LATE = 0.1  # wall time without a message after which nothing more is expected at the end [s]
_LONGEST_END = 1.0
_MATCH_POLL = 0.05
# Visits in a row where more is waiting than lines hold, and the time in which they fill again [s].
_CATCHING_UP, _REFILL = 20, 0.002
_GONE = 2.0  # wall time without the simulator after which the run is over [s]


class RecorderNode(ManagedNode):
    """Takes every topic of the graph and keeps what the bag needs."""

    _taps: RecorderTaps | None = None

    def __init__(self, **options: Any) -> None:
        """Declares the parameters.

        Raises:
            ConfigurationError: A parameter value cannot be used.
        """
        super().__init__(RECORDER, **options)
        self.config = declare(self, RecorderConfig)
        self._writer: BagWriter | None = None
        self._bag, self._at_the_end = "", False
        self._recording: Recording | None = None
        self._poll = self.make_timer(self.config.poll, self._visit)
        self._poll.cancel()
        self.make_timer(0.5, self._look_for_simulator)
        self._announcer = Announcer(self)
        self._matching = self.make_timer(_MATCH_POLL, self._look_for_publishers)
        self._matching.cancel()
        self._alone_since: float | None = None

    @property
    def subscriptions(self) -> Iterator[Any]:
        """What an executor has to look after: not the taps."""
        taps = set(self._taps.subscriptions) if self._taps is not None else set()
        return (s for s in super().subscriptions if s not in taps)

    def set_up(self) -> None:
        """Opens the bag, then listens."""
        folder = Path(self.config.bag or datetime.now().strftime("bags/%Y-%m-%d-%H-%M-%S"))
        about = about_run(self.graph.urdf, texts_in(self.config.about), self.graph.tick)
        self._writer = BagWriter(folder, about, time.time_ns())
        self._bag = str(folder)
        self._taps = RecorderTaps(self)
        self._recording = Recording(
            self._writer, self.config.rate, self.tick_ns, self._taps.announce, about.urdf
        )
        self._taps.open(self._recording.slot)

    def start(self) -> None:
        """Begins to empty the queues."""
        self._poll.reset()
        self._matching.reset()

    def stop(self) -> None:
        """Lets the queues fill until the node goes on."""
        self._poll.cancel()
        self._matching.cancel()

    def tear_down(self) -> None:
        """Closes the bag."""
        self._visit()
        self._close()
        if self._taps is not None:
            self._taps.close()

    def finish(self) -> None:
        """Waits for messages on their way and closes the bag."""
        deadline = time.monotonic() + _LONGEST_END
        last = time.monotonic()
        while self.running and time.monotonic() < min(deadline, last + _LATE):
            if self._visit():
                last = time.monotonic()
            time.sleep(0.01)
        self._at_the_end = self._writer is not None  # else somebody had it closed before
        self._close()
        super().finish()

    @property
    def stamp(self) -> int:
        """Time of the newest joint state [ns]."""
        return (self._recording.latest_stamp or 0) if self._recording else 0

    def report(self) -> dict[str, float | int | str | bool]:
        """What was written and what was lost."""
        if self._recording is None:
            return {}
        missing = self._recording.missing
        values: dict[str, float | int | str | bool] = {
            "bag": self._bag,
            "messages": self._recording.count,
            MISSED_TICKS: missing,
        }
        if self._at_the_end:
            values[CLOSED_AT] = self.stamp / NANOSECONDS
        if missing:
            values["warning"] = f"{missing} joint states did not arrive"
        return values

    def _visit(self) -> int:
        """Takes in all that has arrived; returns how many messages were kept."""
        recording = self._recording
        if recording is None or self._taps is None or self._writer is None:
            return 0
        try:
            count = 0
            for _ in range(_CATCHING_UP):
                full = self._taps.take(recording)
                count += recording.flush()
                if not full:
                    break
                time.sleep(_REFILL)
            return count
        except Exception as error:  # whatever it is: what was written so far must be kept and the user told
            self._give_up(error)
            return 0

    def _look_for_publishers(self) -> None:
        """Announces the recorder once it hears everyone: a publisher may find its readers first."""
        if self._taps is None:
            return
        self._taps.look_for_strangers()
        if self._taps.hears_everyone():
            self._matching.cancel()
            self._announcer.announce()

    def _look_for_simulator(self) -> None:
        """Ends the node when there have been states and nobody is left to send any."""
        if self._taps is None or self._recording is None or self._writer is None:  # or all was cleaned up
            return
        self._taps.look_for_strangers()
        if self._recording.latest_stamp is None or self._taps.has_simulator():
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = time.monotonic()
        elif time.monotonic() - self._alone_since > _GONE:
            self.quit(0, "the simulator is gone")

    def _close(self) -> None:
        writer, self._writer = self._writer, None
        if writer is None:
            return
        try:
            writer.close()
        except Exception as error:
            self.quit(FAILED, f"bag {writer.folder}: {_reason(error)}; it ends without a summary")

    def _give_up(self, error: Exception) -> None:
        at = self.stamp / 1e9
        folder = self._writer.folder if self._writer else ""
        # First, so that a failure to close, which is likely to follow, does not hide what it came from.
        self.quit(
            FAILED, f"bag {folder}: {_reason(error)} at {at:.2f} s; what was written before can be read"
        )
        self._close()


def _reason(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return f"{type(error).__name__}: {error}"
