"""The node that writes the run into a bag.

Its subscriptions are not spun: a timer empties their queues. That costs less than callbacks, and
a message then brings the times at which it was sent and received.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from follower_humanoid.bag.about import about_run, texts_in
from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.recorder import (
    STATE,
    Arrival,
    Recorded,
    RecorderConfig,
    Recording,
    recorded_topics,
)
from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import PRODUCER
from follower_humanoid.ros.barrier import Announcer
from follower_humanoid.ros.managed_node import FAILED, ManagedNode
from follower_humanoid.ros.parameters import declare

# Four seconds of the fastest topic: a disk may hesitate that long.
_DEPTH = 2000
_LATE = 0.1  # wall time without a message after which nothing more is expected at the end [s]
_LONGEST_END = 1.0
_MATCH_POLL = 0.05
_GONE = 2.0  # wall time without the simulator after which the run is over [s]


class RecorderNode(ManagedNode):
    """Takes every topic of the graph and keeps what the bag needs."""

    _taps: tuple[tuple[Recorded, Any], ...] = ()

    def __init__(self, **options: Any) -> None:
        """Declares the parameters.

        Raises:
            ConfigurationError: A parameter value cannot be used.
        """
        super().__init__(RECORDER, **options)
        self.config = declare(self, RecorderConfig)
        self._writer: BagWriter | None = None
        self._recording: Recording | None = None
        self._poll = self.create_timer(self.config.poll, self._visit, clock=self._wall)
        self._poll.cancel()
        self.create_timer(0.5, self._look_for_simulator, clock=self._wall)
        self._announcer = Announcer(self)
        self._matching = self.create_timer(_MATCH_POLL, self._look_for_publishers, clock=self._wall)
        self._matching.cancel()
        self._alone_since: float | None = None

    @property
    def subscriptions(self) -> Iterator[Any]:
        """What an executor has to look after: not the taps."""
        taps = {subscription for _, subscription in self._taps}
        return (s for s in super().subscriptions if s not in taps)

    def set_up(self) -> None:
        """Opens the bag, then listens."""
        folder = Path(self.config.bag or datetime.now().strftime("bags/%Y-%m-%d-%H-%M-%S"))
        about = about_run(self.graph.urdf, texts_in(self.config.about), self.graph.tick)
        self._writer = BagWriter(folder, about, time.time_ns())
        self._recording = Recording(
            self._writer, self.config.rate, self.tick_ns, self._announce, about.urdf
        )
        self._taps = tuple((topic, self._listen(topic)) for topic in recorded_topics())

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
        taps, self._taps = self._taps, ()
        for _, subscription in taps:
            self.destroy_subscription(subscription)

    def finish(self) -> None:
        """Waits for messages on their way and closes the bag."""
        deadline = time.monotonic() + _LONGEST_END
        last = time.monotonic()
        while self.running and time.monotonic() < min(deadline, last + _LATE):
            if self._visit():
                last = time.monotonic()
            time.sleep(0.01)
        self._close()
        super().finish()

    @property
    def stamp(self) -> int:
        """Time of the newest joint state [ns]."""
        return (self._recording.latest_stamp or 0) if self._recording else 0

    def report(self) -> dict[str, float | int | str | bool]:
        """What was written and what was lost."""
        if self._recording is None or self._writer is None:
            return {}
        missing = self._recording.missing
        values: dict[str, float | int | str | bool] = {
            "bag": str(self._writer.folder),
            "messages": self._recording.count,
            "missed_ticks": missing,
        }
        if missing:
            values["warning"] = f"{missing} joint states did not arrive"
        return values

    def _listen(self, topic: Recorded) -> Any:
        # Reliable for what our own nodes send; best effort hears every publisher.
        reliable = topic.lockstepped
        policy = ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        qos = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=_DEPTH, reliability=policy)
        package, _, name = topic.type_name.partition("/msg/")
        message_type = getattr(importlib.import_module(f"{package}.msg"), name)
        return self.create_subscription(message_type, topic.name, lambda _: None, qos, raw=True)

    def _visit(self) -> int:
        """Takes in all that has arrived; returns how many messages were kept."""
        recording = self._recording
        if recording is None or self._writer is None:
            return 0
        try:
            for topic, subscription in self._taps:
                self._empty(recording, topic, subscription)
            return recording.flush()
        except Exception as error:  # whatever it is: what was written so far must be kept and the user told
            self._give_up(error)
            return 0

    @staticmethod
    def _empty(recording: Recording, topic: Recorded, subscription: Any) -> None:
        handle, message_type = subscription.handle, subscription.msg_type
        with handle:
            while (taken := handle.take_message(message_type, True)) is not None:
                data, info = taken
                received, published = info["received_timestamp"], info["source_timestamp"]
                recording.take(Arrival(topic, data, received, published))

    def _announce(self, topic: Recorded) -> tuple[str, list[dict[str, Any]]]:
        subscription = next(tap for known, tap in self._taps if known is topic)
        name = str(subscription.topic_name)
        profiles = [info.qos_profile for info in self.get_publishers_info_by_topic(name)]
        offered = [offered_qos(p.reliability.name.lower(), p.durability.name.lower()) for p in profiles]
        return name, offered or [offered_qos()]

    def _look_for_publishers(self) -> None:
        """Announces the recorder once it hears everyone: a publisher may find its readers first."""
        awaited = (
            tap
            for topic, tap in self._taps
            if topic.name in PRODUCER and PRODUCER[topic.name].name in self.present
        )
        if all(tap.get_publisher_count() for tap in awaited):
            self._matching.cancel()
            self._announcer.announce()

    def _look_for_simulator(self) -> None:
        """Ends the node when there have been states and nobody is left to send any."""
        begun = self._recording is not None and self._recording.latest_stamp is not None
        state = next((tap for topic, tap in self._taps if topic.name == STATE), None)
        if not begun or state is None or state.get_publisher_count():
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
