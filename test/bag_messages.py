"""Serialized messages of a short, made-up run, as a graph publishes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point32, PointStamped, PolygonStamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Header

from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.recorder import Announce, Arrival, Recorded, Recording, recorded_topics
from follower_humanoid.bag.writer import About, BagWriter

TICK_NS = 2_000_000
START = 1_700_000_000_000_000_000
JOINTS = tuple(f"joint_{number}" for number in range(45))
TOPICS = {topic.name: topic for topic in recorded_topics()}


def header(tick: int, frame: str) -> Header:
    seconds, nanoseconds = divmod(tick * TICK_NS, 10**9)
    return Header(stamp=Time(sec=seconds, nanosec=nanoseconds), frame_id=frame)


def joint_state(tick: int, names: tuple[str, ...] = JOINTS, scale: float = 0.001) -> bytes:
    rng = np.random.default_rng(tick)
    message = JointState(header=header(tick, "base_link"), name=list(names))
    message.position = (scale * rng.standard_normal(len(names))).tolist()
    message.velocity = rng.standard_normal(len(names)).tolist()
    message.effort = rng.standard_normal(len(names)).tolist()
    return bytes(serialize_message(message))


def joint_positions(tick: int, scale: float = 0.001) -> np.ndarray:
    return scale * np.random.default_rng(tick).standard_normal(len(JOINTS))


def odometry(tick: int) -> bytes:
    message = Odometry(header=header(tick, "world"), child_frame_id="base_link")
    message.pose.pose.position.x = 0.001 * tick
    message.twist.twist.angular.z = -0.5
    return bytes(serialize_message(message))


def imu(tick: int) -> bytes:
    message = Imu(header=header(tick, "base_link"))
    message.linear_acceleration.z = 9.81
    return bytes(serialize_message(message))


def wrench(tick: int, force_z: float, frame: str = "l_sole") -> bytes:
    message = WrenchStamped(header=header(tick, frame))
    message.wrench.force.z = force_z
    message.wrench.torque.y = 0.25 * tick
    return bytes(serialize_message(message))


def point(tick: int) -> bytes:
    message = PointStamped(header=header(tick, "world"))
    message.point.x = 0.01 * tick
    return bytes(serialize_message(message))


def polygon(tick: int, corners: int) -> bytes:
    message = PolygonStamped(header=header(tick, "world"))
    message.polygon.points = [Point32(x=0.5 * k, y=-0.25 * k, z=0.0) for k in range(corners)]
    return bytes(serialize_message(message))


def named_values(tick: int, values: dict[str, float]) -> bytes:
    filled = list(values.values())
    message = JointState(header=header(tick, ""), name=list(values), position=filled)
    # Empty float arrays serialize with whatever lay in memory behind them.
    message.velocity = message.effort = [0.0] * len(filled)
    return bytes(serialize_message(message))


GAIT = {"walk_speed": 1.0, "walk_dir": 0.2, "step_length": 1.25, "step_height": 1.0, "heading": 0.1}


def arrivals(count: int) -> list[Arrival]:
    """Every kind of regular message at every tick, in the order of receipt."""
    made = []
    for tick in range(count):
        messages = {
            "joint_states": joint_state(tick),
            "odom": odometry(tick),
            "imu": imu(tick),
            "left_foot/wrench": wrench(tick, 358.0),
            "gait": named_values(tick, GAIT),
            "primitives": named_values(tick, {"lean": 0.5, "bend": 0.25}),
            "support_polygon": polygon(tick, 4 + tick % 3),
            "com": point(tick),
        }
        received = START + tick * TICK_NS
        for number, (name, data) in enumerate(messages.items()):
            made.append(Arrival(TOPICS[name], data, received + 1000 * number, received))
    return made


def announce_in(namespace: str = "/") -> Announce:
    def announce(topic: Recorded) -> tuple[str, list[dict[str, Any]]]:
        return namespace + topic.name, [offered_qos()]

    return announce


ABOUT = About("<robot/>", {"parameters": "a: 1\n", "programme": "fig4"}, {"tick": "0.002", "seed": "7"})


def record(writer: BagWriter, made: list[Arrival], namespace: str = "/") -> Recording:
    recording = Recording(writer, 100.0, TICK_NS, announce_in(namespace))
    for arrival in made:
        recording.take(arrival)
    recording.flush()
    return recording


def write_bag(
    folder: Path, count: int = 500, namespace: str = "/", made: list[Arrival] | None = None
) -> Path:
    """A bag of `count` ticks."""
    with BagWriter(folder, ABOUT, START) as writer:
        record(writer, arrivals(count) if made is None else made, namespace)
    return folder
