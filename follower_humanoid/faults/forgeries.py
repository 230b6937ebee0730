"""Forged messages: for every topic of the graph, such as its reader must refuse.

Nothing here may be of use by chance: what keeps the graph's own form carries a tick that is over or far
away, or a number that is none.
"""

from __future__ import annotations

import random
import struct

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, String, UInt8MultiArray

from follower_humanoid.core.cdr import HEADER, STAMP_SIZE, put_stamp, stamp_of
from follower_humanoid.core.samples import Wrench
from follower_humanoid.core.topics import PEOPLE
from follower_humanoid.faults.messages import TICK_NS, hostile_message, whole_messages
from follower_humanoid.faults.mutations import damaged_bytes
from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import NODES, SIMULATOR
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.barrier import READY, RESET
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope, envelope_topic
from follower_humanoid.ros.leaving import LEAVE
from follower_humanoid.ros.outlet import ABSENT
from follower_humanoid.ros.qos import LOCKSTEP
from follower_humanoid.ros.validation import MessageError

_GENTLE = 0.1  # N and N·m: what may act without harm
_FRAMES = ("", "world", "l_gripper", "nowhere", "../../etc", "x" * 5000, "\u202e")
_WRONG_STAMPS = (-1, -(2**31) * 10**9, 1, TICK_NS + 1, (2**31 - 1) * 10**9, 10**15, 999 * TICK_NS - 7)


def _topics() -> dict[str, type]:
    robot = RobotModel()
    topics: dict[str, type] = {
        topic: Codec(topic, robot).message_type
        for node in NODES.values()
        for topic in node.outputs.values()
        if topic not in PEOPLE
    }
    for name in NODES:
        topics[envelope_topic(name)] = topics[envelope_topic(name, slow=True)] = UInt8MultiArray
    return topics | {
        ABSENT: Header, RESET: Header, READY: String, LEAVE: String, CLOCK: Clock,
        "/diagnostics": DiagnosticArray,
    }  # fmt: skip


FORGED: dict[str, type] = _topics()
"""Every topic that only nodes of the graph should publish on, and its type."""


class Forger:
    """Makes them, envelopes with the tick that the graph is at."""

    def __init__(self, rng: random.Random) -> None:
        """Args: of all that is random."""
        self._rng = rng
        self._now = 0
        self._whole = {topic: sent for topic, (_, sent) in whole_messages().items()}
        self._broken = {topic: _broken(topic) for topic in self._whole}

    def listen(self, node: Node) -> None:
        """Follows the simulator's ticks."""
        envelope = Envelope(NODES[SIMULATOR])

        def hear(data: bytes) -> None:
            try:
                stamp, _ = envelope.open(data)
            except MessageError:  # one of our own
                return
            if 0 <= stamp - self._now < 10**9:
                self._now = stamp

        node.create_subscription(UInt8MultiArray, envelope_topic(SIMULATOR), hear, LOCKSTEP, raw=True)

    def message(self, topic: str) -> bytes:
        """One for a topic."""
        rng = self._rng
        if topic.startswith("graph/") and topic.split("/")[1] in NODES:
            return self._envelope(topic.split("/")[1])
        if topic in self._whole:
            whole = bytearray(rng.choice(self._whole[topic]))
            if len(whole) >= len(HEADER) + STAMP_SIZE:  # no array without a single element
                put_stamp(whole, len(HEADER), rng.choice(_WRONG_STAMPS[:4]))
            return bytes(whole) if rng.random() < 0.3 else hostile_message(bytes(whole), rng)
        rubbish = rng.randbytes(rng.randint(0, 80))
        if FORGED[topic] is String:
            return HEADER + struct.pack("<I", len(rubbish)) + rubbish
        if FORGED[topic] is Header and rng.random() < 0.5:
            forged = bytearray(HEADER + bytes(8) + struct.pack("<I", 6) + b"nobody\0\0")
            put_stamp(forged, len(HEADER), rng.choice(_WRONG_STAMPS))
            return bytes(forged)
        return rubbish if rng.random() < 0.5 else HEADER + rubbish

    def _envelope(self, name: str) -> bytes:
        """Of this very tick, or one near it, with a number that is none in each message; or damaged."""
        rng = self._rng
        node = NODES[name]
        parts = [self._broken.get(topic, b"\xff" * 9) for topic in node.outputs.values()]
        kind = rng.randrange(4)
        if kind == 0:
            return Envelope(node).seal(rng.choice(_WRONG_STAMPS), parts)
        if kind == 1:
            return hostile_message(Envelope(node).seal(-TICK_NS, parts), rng)
        if kind == 2:
            return damaged_bytes(Envelope(node).seal(2**62, parts), rng)
        near = self._now + rng.randint(0, 20) * TICK_NS
        return Envelope(node).seal(near, parts)


def _broken(topic: str) -> bytes:
    """A message that is one but for a number that is none; where that is of no account, rubbish."""
    codec, sent = whole_messages()[topic]
    data = bytearray(sent[-1])
    for at in range(len(data) - 8, len(HEADER) + 8, -8):
        data[at : at + 8] = np.float64(np.nan).tobytes()
        try:
            codec.decode(bytes(data))
        except MessageError:
            return bytes(data)
    return b"\xff" * 9


def unusable_for_people(topic: str, count: int, rng: random.Random) -> tuple[list[bytes], type]:
    """Messages on what people publish, and their type; none that can be used pulls harder than 0.1 N."""
    robot = RobotModel()
    codec = Codec(topic, robot)
    frames = {frame.name for frame in robot.pin_model.frames} | {"", "world"}
    found: list[bytes] = []
    while len(found) < count:
        numbers = rng.choices((float("nan"), float("inf"), -float("inf"), _GENTLE, 0.0), k=3)
        whole = codec.encode(
            Wrench(np.array(numbers), np.zeros(3), rng.choice(_FRAMES)), rng.choice((0, -5, 2**60, 10**9))
        )
        data = whole if rng.random() < 0.4 else hostile_message(whole, rng)
        if _is_harmless(codec, data, frames):
            found.append(data)
    return found, codec.message_type


def _is_harmless(codec: Codec, data: bytes, frames: set[str]) -> bool:
    try:
        wrench = codec.decode(data)
    except MessageError:
        return True
    strongest = max(np.abs(wrench.force).max(), np.abs(wrench.torque).max())
    return wrench.frame not in frames or strongest <= _GENTLE or stamp_of(data) < -(2**62)
