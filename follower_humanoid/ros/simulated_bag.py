"""Writes a run that is simulated without the graph into a bag like the recorder's."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter

from follower_humanoid.bag.about import about_run
from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.recorder import (
    ADJUSTED,
    HOLDING,
    STATE,
    Arrival,
    Recorded,
    Recording,
    recorded_topics,
)
from follower_humanoid.bag.writer import About, BagWriter
from follower_humanoid.core.cdr import NANOSECONDS, clock_bytes
from follower_humanoid.core.samples import Sample
from follower_humanoid.graph.record import Adjusted, Holding, Run, RunRecorder
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.cdr import CdrWriter
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.holding import holding_message

_RATE = 100.0  # of topics that are thinned out, as the recorder's default [Hz]
_CLOCK = "clock"
_FLUSH_EVERY = 100  # ticks


class SimulatedBag(RunRecorder):
    """Takes the place of a run held in memory: samples go to the disk as messages of their tick.

    The messages' times of receipt are those of the simulated clock, counted from when the bag was begun.
    """

    def __init__(self, folder: Path, namespace: str | None, run: Run, robot: RobotModel) -> None:
        """Begins the bag.

        Args:
            folder: The bag; must not exist.
            namespace: Of the robot; None: none.
            run: The recorded run that is simulated again; what it carries goes along.
            robot: The model.

        Raises:
            ConfigurationError: The folder exists or cannot be written.
        """
        super().__init__(run.tick, robot.joint_names, robot.urdf)
        self._created = time.time_ns()
        here = about_run("", {}, run.tick)
        texts = {name: text for name, text in run.about.items() if name not in here.values}
        self._writer = BagWriter(folder, About(run.urdf, {**texts, **here.texts}, here.values), self._created)
        self._robot = robot
        self._prefix = f"/{namespace.strip('/')}/" if namespace and namespace.strip("/") else "/"
        self._topics = {topic.name: topic for topic in recorded_topics()}
        self._codecs: dict[str, Codec] = {}
        self._tick_ns = round(run.tick * NANOSECONDS)
        self._recording = Recording(self._writer, _RATE, self._tick_ns, self._announce, run.urdf)

    def add(self, topic: str, tick: int, sample: Sample) -> None:
        """Writes one sample, and the clock with every state."""
        stamp = tick * self._tick_ns
        if topic == STATE:
            self._take(_CLOCK, clock_bytes(stamp), stamp)
            if tick % _FLUSH_EVERY == 0:
                self._recording.flush()
        codec = self._codecs.get(topic) or self._codecs.setdefault(topic, Codec(topic, self._robot))
        self._take(topic, codec.encode(sample, stamp), stamp)

    def adjust(self, adjusted: Adjusted) -> None:
        """Writes a change of parameters."""
        stamp = adjusted.tick * self._tick_ns
        event = ParameterEvent(node=adjusted.node)
        event.stamp.sec, event.stamp.nanosec = divmod(stamp, NANOSECONDS)
        event.changed_parameters = [
            Parameter(name, value=list(value) if isinstance(value, tuple) else value).to_parameter_msg()
            for name, value in adjusted.values.items()
        ]
        self._take(ADJUSTED, bytes(CdrWriter(event).data), stamp)

    def hold(self, holding: Holding) -> None:
        """Writes that the motor drives hold from a tick on, or no longer do."""
        stamp = holding.tick * self._tick_ns
        self._take(HOLDING, bytes(CdrWriter(holding_message(holding, stamp)).data), stamp)

    def close(self) -> None:
        """Ends the bag.

        Raises:
            OSError: The disk is full or gone; it names the bag.
        """
        try:
            self._recording.flush()
        finally:
            self._writer.close()

    def _take(self, topic: str, data: bytes, stamp: int) -> None:
        received = self._created + stamp
        self._recording.take(Arrival(self._topics[topic], data, received, received))

    def _announce(self, topic: Recorded) -> tuple[str, list[dict[str, Any]]]:
        return self._prefix + topic.name, [offered_qos()]
