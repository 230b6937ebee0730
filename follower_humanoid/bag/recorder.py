"""What the recorder keeps: all of what physics and re-simulation need, 100 Hz of the rest.

Free of ROS: serialized messages come in with their times, a bag goes out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple

from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.thinning import Thinning, is_thinned
from follower_humanoid.bag.transforms import TRANSFORMED, Made, TransformMaker
from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.core import samples
from follower_humanoid.core.cdr import HEADER, NANOSECONDS, stamp_of
from follower_humanoid.core.config import parameter
from follower_humanoid.core.topics import PEOPLE, TOPICS

STATE = "joint_states"
ADJUSTED = "graph/adjusted"
"""Parameters that were changed during the run, with the time of the first tick that used them."""
HOLDING = "graph/holding"
"""When the drives held for want of motor commands: stamp of the first tick, names of what was missing."""

_MADE = frozenset({"/tf", "/tf_static", "robot_description"})
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

    bag: str = parameter("", "folder of the bag, must not exist yet; empty: bags/<date-time>", path=True)
    about: str = parameter(
        "", "YAML file, name -> text, of what the bag shall carry; empty: nothing", path=True
    )
    rate: float = parameter(100.0, "rate of the topics that are thinned out", "Hz", 1.0, 1000.0)
    poll: float = parameter(0.02, "wall time between two visits to the queues", "s", 0.001, 1.0)


@dataclass(frozen=True)
class Recorded:
    """One topic as it is recorded.

    Attributes:
        name: Relative name; diagnostics are shared by all robots.
        type_name: `package/msg/Type`.
        thinned: True where only a part of the messages is kept.
        lockstepped: True where only nodes of the graph publish, reliably.
        stamped_at: Byte offset of the stamp in the serialized message.
    """

    name: str
    type_name: str
    thinned: bool
    lockstepped: bool
    stamped_at: int = len(HEADER)


def recorded_topics() -> tuple[Recorded, ...]:
    """Every topic of the contract, what else a repetition needs, the clock and the diagnostics."""
    listed = []
    for topic in TOPICS.values():
        # An array of markers begins with its length; the stamp is that of the first marker.
        offset = len(HEADER) + (4 if topic.kind is samples.Footsteps else 0)
        reliable = topic.name not in PEOPLE
        listed.append(Recorded(topic.name, _TYPE_NAMES[topic.kind], is_thinned(topic.name), reliable, offset))
    listed.append(Recorded(ADJUSTED, "rcl_interfaces/msg/ParameterEvent", False, True))
    listed.append(Recorded(HOLDING, "std_msgs/msg/Header", False, True))
    listed.append(Recorded("clock", "rosgraph_msgs/msg/Clock", True, False))
    listed.append(Recorded("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", False, False))
    return tuple(listed)


class Arrival(NamedTuple):
    """One message as it came in; times since the epoch [ns]."""

    topic: Recorded
    data: bytes
    received: int
    published: int


_RECEIVED = attrgetter("received")
Announce = Callable[[Recorded], tuple[str, list[dict[str, Any]]]]


class Recording:
    """Thins out, sorts and writes what arrives.

    Attributes:
        latest_stamp: Of the newest state [ns], None where there is none yet.
        missing: States that did not arrive.
    """

    def __init__(
        self, writer: BagWriter, rate: float, tick_ns: int, announce: Announce, urdf: str = ""
    ) -> None:
        """Begins with nothing.

        Args:
            writer: The open bag.
            rate: Of the topics that are thinned out [Hz].
            tick_ns: Control tick [ns].
            announce: Gives a topic's full name and offered QoS when its first message is here.
            urdf: Text of the robot's URDF; with it the bag carries transforms and the description.
        """
        self._maker = TransformMaker(urdf) if urdf else None
        self._state: Recorded | None = None
        self._writer = writer
        self._thinning = Thinning(round(NANOSECONDS / rate))
        self._tick = tick_ns
        self._announce = announce
        self._channels: dict[str, int] = {}
        self._batch: list[Arrival] = []
        self._latched: set[str] = set()
        self.latest_stamp: int | None = None
        self.missing = 0

    @property
    def slot(self) -> int:
        """See `Thinning` [ns]."""
        return self._thinning.slot

    @property
    def count(self) -> int:
        """Messages written so far."""
        return self._writer.message_count

    def take(self, arrival: Arrival) -> None:
        """Takes a message in; thinned topics keep the first one of each slot of stamp time."""
        topic = arrival.topic
        if topic.thinned:
            stamp = stamp_of(arrival.data, topic.stamped_at)
            if not self._thinning.keeps(topic.name, stamp if stamp >= 0 else self.latest_stamp or 0):
                return
        elif topic.name == STATE:
            self._watch(stamp_of(arrival.data, topic.stamped_at))
        self._batch.append(arrival)
        if self._maker is not None and topic.name in TRANSFORMED:
            self._make(self._maker, arrival)

    def flush(self) -> int:
        """Writes what was taken in since the last time, in the order of arrival.

        Returns:
            How many messages were written.

        Raises:
            OSError: The disk is full or gone.
        """
        batch, self._batch = self._batch, []
        batch.sort(key=_RECEIVED)
        write, channels = self._writer.write, self._channels
        for topic, data, received, published in batch:
            channel = channels.get(topic.name)
            if channel is None:
                name, qos = self._announced(topic)
                channel = channels[topic.name] = self._writer.add_topic(name, topic.type_name, qos)
            write(channel, data, received, published)
        return len(batch)

    def _make(self, maker: TransformMaker, arrival: Arrival) -> None:
        """Adds transforms to a state that has arrived."""
        if arrival.topic.name == STATE and self._state is None:
            self._state = arrival.topic
            for made in maker.latched():
                self._add(made, arrival)
        transforms = maker.take(arrival.topic.name, arrival.data)
        if transforms is not None:
            self._add(transforms, arrival)

    def _add(self, made: Made, cause: Arrival) -> None:
        topic = Recorded(made.topic, made.type_name, False, True)
        if made.latched:
            self._latched.add(made.topic)
        self._batch.append(Arrival(topic, made.data, cause.received, cause.published))

    def _announced(self, topic: Recorded) -> tuple[str, list[dict[str, Any]]]:
        """Full name and offered QoS of a topic; what is made here has the namespace of the state."""
        if self._state is None or topic.name not in _MADE:
            return self._announce(topic)
        above = self._announce(self._state)[0].removesuffix(STATE)
        qos = offered_qos("reliable", "transient_local" if topic.name in self._latched else "volatile")
        return topic.name if topic.name.startswith("/") else above + topic.name, [qos]

    def _watch(self, stamp: int) -> None:
        """Counts the ticks whose state did not arrive."""
        if stamp < 0:  # cut short
            return
        if self.latest_stamp is not None:
            self.missing += max(0, round((stamp - self.latest_stamp) / self._tick) - 1)
        self.latest_stamp = stamp
