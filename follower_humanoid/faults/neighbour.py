"""A hostile neighbour: `python -m follower_humanoid.faults.neighbour SECONDS` floods what people can publish.

Two publishers per topic send, as fast as they can, numbers that are none, frames that do not exist, stamps
of any time, and now and then a pull of a tenth of a newton. Prints how many messages it sent and how fast.
"""

from __future__ import annotations

import random
import sys
import time
from collections.abc import Sequence

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.utilities import try_shutdown

from follower_humanoid.ros.formats import PEOPLE

_FRAMES = ("", "world", "l_gripper", "nowhere", "../../etc", "x" * 5000, "\u202e")
_NUMBERS = (float("nan"), float("inf"), -float("inf"), 0.1, 0.0)


def main(args: Sequence[str]) -> int:
    """Floods until the time is over."""
    rclpy.init()
    node = Node("neighbour")
    publishers = [
        node.create_publisher(WrenchStamped, topic, qos_profile_sensor_data)
        for topic in sorted(PEOPLE)
        for _ in range(2)
    ]
    rng = random.Random(1)
    messages = [_message(rng) for _ in range(500)]
    begin, sent = time.monotonic(), 0
    while (elapsed := time.monotonic() - begin) < float(args[0]):
        rng.choice(publishers).publish(rng.choice(messages))
        sent += 1
    print(f"{sent} messages, {sent / elapsed:.0f} per second")
    node.destroy_node()
    try_shutdown()
    return 0


def _message(rng: random.Random) -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id = rng.choice(_FRAMES)
    message.header.stamp.sec = rng.choice((0, -(2**31), 2**31 - 1, 7))
    message.header.stamp.nanosec = rng.choice((0, 2**32 - 1, 500))
    force = message.wrench.force
    force.x, force.y, force.z = (rng.choice(_NUMBERS) for _ in range(3))
    return message


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
