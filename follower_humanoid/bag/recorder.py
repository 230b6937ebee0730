"""What the recorder keeps: all of what physics and re-simulation need, 100 Hz of the rest.

Free of ROS: serialized messages come in with their times, a bag goes out.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.core import samples
from follower_humanoid.core.config import parameter
from follower_humanoid.core.topics import TOPICS

NANOSECONDS = 1_000_000_000

EVERY_MESSAGE = frozenset(
    {
        "joint_states",
        "odom",
        "imu",
        "left_foot/wrench",
        "right_foot/wrench",
        "left_hand/wrench_raw",
        "right_hand/wrench_raw",
        "left_hand/wrench",
        "right_hand/wrench",
        "left_hand/applied",
        "right_hand/applied",
        "base/applied",
        "legs/command",
        "arms/command",
        "zmp",
        "zmp_reference",
    }
)
"""Topics of which every message is kept."""

_ENCAPSULATION = 4
_TYPE_NAMES: dict[type, str] = {
    samples.Joints: "sensor_msgs/msg/JointState",
    samples.Gait: "sensor_msgs/msg/JointState",
    samples.PrimitiveStates: "sensor_msgs/msg/JointState",
    samples.ContactPlan: "sensor_msgs/msg/JointState",
    samples.Odometry: "nav_msgs/msg/Odometry",
    samples.Inertial: "sensor_msgs/msg/Imu",
    samples.Wrench: "geometry_msgs/msg/WrenchStamped",
    samples.Point: "geometry_msgs/msg/PointStamped",
    samples.Polygon: "geometry_msgs/msg/PolygonStamped",
    samples.Footsteps: "visualization_msgs/msg/MarkerArray",
}


@dataclass(frozen=True)
class RecorderConfig:
    """What the recorder node is told."""

    bag: str = parameter("", "folder of the bag; must not exist yet")
    urdf: str = parameter("", "URDF file carried in the bag; empty: the package's own")
    about: str = parameter("", "YAML file of texts carried in the bag: name -> text")
    rate: float = parameter(100.0, "rate of the topics that are thinned out", "Hz", 1.0, 1000.0)
    poll: float = parameter(0.02, "wall time between two visits to the queues", "s", 0.001, 1.0)


@dataclass(frozen=True)
class Recorded:
    """One topic as it is recorded.

    Attributes:
        name: Relative name.
        type_name: `package/msg/Type`.
        thinned: True where only a part of the messages is kept.
        stamped_at: Byte offset of the stamp in the serialized message.
    """

    name: str
    type_name: str
    thinned: bool
    stamped_at: int = _ENCAPSULATION


def recorded_topics() -> tuple[Recorded, ...]:
    """Every topic of the contract, the clock and the diagnostics."""
    listed = []
    for topic in TOPICS.values():
        # An array of markers begins with its length; the stamp is that of the first marker.
        offset = _ENCAPSULATION + (4 if topic.kind is samples.Footsteps else 0)
        # People's messages carry stamps of any clock, so they cannot be thinned out by them.
        thinned = topic.name not in EVERY_MESSAGE and topic.everybody
        listed.append(Recorded(topic.name, _TYPE_NAMES[topic.kind], thinned, offset))
    listed.append(Recorded("clock", "rosgraph_msgs/msg/Clock", True))
    listed.append(Recorded("diagnostics", "diagnostic_msgs/msg/DiagnosticArray", False))
    return tuple(listed)


def stamp_of(data: bytes, offset: int) -> int | None:
    """Stamp of a serialized message [ns]; None where it is too short to hold one."""
    if len(data) < offset + 8:
        return None
    order = "<" if data[1] & 1 else ">"
    seconds, nanoseconds = struct.unpack_from(order + "iI", data, offset)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


@dataclass(frozen=True)
class Arrival:
    """One message as it came in; times since the epoch [ns]."""

    topic: Recorded
    data: bytes
    received: int
    published: int


class Recording:
    """Sorts, thins out and writes what arrives."""

    def __init__(
        self, writer: BagWriter, rate: float, announce: Callable[[Recorded], tuple[str, list[dict[str, Any]]]]
    ) -> None:
        """Args: the open bag, the rate of thinned topics [Hz], and what names a topic's full name and QoS."""
        self._writer = writer
        self._slot = round(NANOSECONDS / rate)
        self._announce = announce
        self._channels: dict[str, int] = {}
        self._last_slot: dict[str, int] = {}
        self._latest_stamp: int | None = None

    @property
    def latest_stamp(self) -> int | None:
        """Stamp of the newest joint state [ns], None before the first."""
        return self._latest_stamp

    def add(self, arrivals: Iterable[Arrival]) -> None:
        """Writes a batch in the order of arrival.

        Raises:
            OSError: The disk is full or gone.
        """
        for arrival in sorted(arrivals, key=lambda a: a.received):
            topic = arrival.topic
            if topic.name == "joint_states":
                self._latest_stamp = stamp_of(arrival.data, topic.stamped_at)
            if topic.thinned and not self._is_due(topic, arrival.data):
                continue
            channel = self._channels.get(topic.name)
            if channel is None:
                name, qos = self._announce(topic)
                channel = self._channels[topic.name] = self._writer.add_topic(name, topic.type_name, qos)
            self._writer.write(channel, arrival.data, arrival.received, arrival.published)

    def _is_due(self, topic: Recorded, data: bytes) -> bool:
        stamp = stamp_of(data, topic.stamped_at)
        if stamp is None:
            stamp = self._latest_stamp or 0
        slot = stamp // self._slot
        if self._last_slot.get(topic.name) == slot:
            return False
        self._last_slot[topic.name] = slot
        return True
