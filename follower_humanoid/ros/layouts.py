"""Where a sample's numbers lie in its message: one format per kind of sample.

A format makes the template message (names, frame, ids: what does not change from tick to tick),
says which fields hold the numbers, and reads any valid message the slow way.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Protocol

import numpy as np
from geometry_msgs.msg import Point32, PointStamped, PolygonStamped, WrenchStamped
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import Imu

from follower_humanoid.core import samples
from follower_humanoid.core.samples import Array
from follower_humanoid.core.topics import Topic
from follower_humanoid.ros.validation import check_frame, finite

# First field of a run of numbers, and how many follow one another in memory.
Blocks = tuple[tuple[str, int], ...]


class Format(Protocol):
    """How one topic's samples become messages."""

    message_type: type
    # False where the numbers of one message do not fill one sample (or nobody in the loop reads it).
    fast_reading: bool

    def shape(self, sample: Any) -> Hashable:
        """What decides the template: samples of equal shape differ in their numbers only."""

    def template(self, shape: Any) -> tuple[Any, Blocks]:
        """The message without its numbers, and where those lie."""

    def numbers(self, sample: Any) -> tuple[Array, ...]:
        """The numbers, one array per block."""

    def sample(self, blocks: list[Array], shape: Any) -> Any:
        """The inverse of `numbers`."""

    def read(self, message: Any) -> Any:
        """The sample of any valid message; raises `MessageError`."""


class Stamped:
    """What the formats of messages with one header share."""

    fast_reading = True

    def __init__(self, topic: Topic) -> None:
        self.topic = topic

    def shape(self, sample: Any) -> Hashable:
        """What decides the template."""
        return None

    def framed(self, message: Any, frame: str = "") -> Any:
        """The message with the topic's frame, or another."""
        message.header.frame_id = frame or self.topic.frame
        return message

    def check_frame(self, message: Any) -> None:
        """Refuses a frame that is not the topic's."""
        check_frame(self.topic.name, message.header.frame_id, self.topic.frame)

    def finite(self, *values: float) -> Array:
        """The values as an array, refused where one is not finite."""
        return finite(self.topic.name, np.array(values, dtype=np.float64))


class OdometryFormat(Stamped):
    """Pose and twist of a frame."""

    message_type = OdometryMessage

    def template(self, shape: None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        message = self.framed(OdometryMessage(child_frame_id=self.topic.child_frame))
        return message, (
            ("pose.pose.position.x", 3),
            ("pose.pose.orientation.x", 4),
            ("twist.twist.linear.x", 3),
            ("twist.twist.angular.x", 3),
        )

    def numbers(self, sample: samples.Odometry) -> tuple[Array, ...]:
        """One array per block."""
        return sample.position, sample.quat_xyzw, sample.linear_velocity, sample.angular_velocity

    def sample(self, blocks: list[Array], shape: None) -> samples.Odometry:
        """The inverse of `numbers`."""
        return samples.Odometry(*blocks)

    def read(self, message: OdometryMessage) -> samples.Odometry:
        """Any valid message, the slow way."""
        self.check_frame(message)
        check_frame(self.topic.name, message.child_frame_id, self.topic.child_frame)
        p, q = message.pose.pose.position, message.pose.pose.orientation
        v, w = message.twist.twist.linear, message.twist.twist.angular
        return samples.Odometry(
            self.finite(p.x, p.y, p.z),
            self.finite(q.x, q.y, q.z, q.w),
            self.finite(v.x, v.y, v.z),
            self.finite(w.x, w.y, w.z),
        )


class InertialFormat(Stamped):
    """An inertial measurement unit."""

    message_type = Imu

    def template(self, shape: None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        blocks = (("orientation.x", 4), ("angular_velocity.x", 3), ("linear_acceleration.x", 3))
        return self.framed(Imu()), blocks

    def numbers(self, sample: samples.Inertial) -> tuple[Array, ...]:
        """One array per block."""
        return sample.quat_xyzw, sample.angular_velocity, sample.linear_acceleration

    def sample(self, blocks: list[Array], shape: None) -> samples.Inertial:
        """The inverse of `numbers`."""
        return samples.Inertial(*blocks)

    def read(self, message: Imu) -> samples.Inertial:
        """Any valid message, the slow way."""
        self.check_frame(message)
        q, w, a = message.orientation, message.angular_velocity, message.linear_acceleration
        return samples.Inertial(
            self.finite(q.x, q.y, q.z, q.w), self.finite(w.x, w.y, w.z), self.finite(a.x, a.y, a.z)
        )


class WrenchFormat(Stamped):
    """Force and moment; people's topics carry the frame they were given in."""

    message_type = WrenchStamped

    def __init__(self, topic: Topic, frame_is_free: bool) -> None:
        super().__init__(topic)
        self._frame_is_free = frame_is_free

    def shape(self, sample: samples.Wrench) -> str:
        """What decides the template."""
        return (sample.frame or self.topic.frame) if self._frame_is_free else self.topic.frame

    def template(self, shape: str | None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        return self.framed(WrenchStamped(), shape or ""), (("wrench.force.x", 3), ("wrench.torque.x", 3))

    def numbers(self, sample: samples.Wrench) -> tuple[Array, ...]:
        """One array per block."""
        return sample.force, sample.torque

    def sample(self, blocks: list[Array], shape: str | None) -> samples.Wrench:
        """The inverse of `numbers`."""
        force, torque = blocks
        return samples.Wrench(force, torque, (shape or self.topic.frame) if self._frame_is_free else "")

    def read(self, message: WrenchStamped) -> samples.Wrench:
        """Any valid message, the slow way."""
        if not self._frame_is_free:
            self.check_frame(message)
        f, t = message.wrench.force, message.wrench.torque
        return self.sample([self.finite(f.x, f.y, f.z), self.finite(t.x, t.y, t.z)], message.header.frame_id)


class PointFormat(Stamped):
    """A point in world."""

    message_type = PointStamped

    def template(self, shape: None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        return self.framed(PointStamped()), (("point.x", 3),)

    def numbers(self, sample: samples.Point) -> tuple[Array, ...]:
        """One array per block."""
        return (sample.xyz,)

    def sample(self, blocks: list[Array], shape: None) -> samples.Point:
        """The inverse of `numbers`."""
        return samples.Point(*blocks)

    def read(self, message: PointStamped) -> samples.Point:
        """Any valid message, the slow way."""
        self.check_frame(message)
        return samples.Point(self.finite(message.point.x, message.point.y, message.point.z))


class PolygonFormat(Stamped):
    """A polygon in world; the message has single precision."""

    message_type = PolygonStamped
    fast_reading = False

    def shape(self, sample: samples.Polygon) -> int:
        """What decides the template."""
        return len(sample.vertices)

    def template(self, shape: int) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        message = self.framed(PolygonStamped())
        message.polygon.points = [Point32() for _ in range(shape)]
        return message, (("polygon.points[0].x", 3 * shape),) if shape else ()

    def numbers(self, sample: samples.Polygon) -> tuple[Array, ...]:
        """One array per block."""
        return (sample.vertices.reshape(-1),) if len(sample.vertices) else ()

    def sample(self, blocks: list[Array], shape: int) -> samples.Polygon:
        """The inverse of `numbers`."""
        flat = blocks[0] if blocks else np.zeros(0)
        return samples.Polygon(flat.reshape(-1, 3).astype(np.float64))

    def read(self, message: PolygonStamped) -> samples.Polygon:
        """Any valid message, the slow way."""
        self.check_frame(message)
        flat = self.finite(*(v for p in message.polygon.points for v in (p.x, p.y, p.z)))
        return self.sample([flat], len(message.polygon.points))
