"""What people at the page do, as messages."""

import time

import numpy as np
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import deserialize_message

from follower_humanoid.core.samples import Side
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.leading import Leading


class Publisher:
    """Keeps what is published."""

    def __init__(self) -> None:
        self.forces: list[list[float]] = []

    def publish(self, data: bytes) -> None:
        force = deserialize_message(data, WrenchStamped).wrench.force
        self.forces.append([force.x, force.y, force.z])


class Node:
    """Makes publishers."""

    def __init__(self) -> None:
        self.publishers: dict[str, Publisher] = {}

    def create_publisher(self, _, topic, __):
        return self.publishers.setdefault(topic, Publisher())


def test_whoever_lets_go_says_so_however_late_the_viewer_comes_to_it():
    node = Node()
    leading = Leading(node, RobotModel())
    leading.pull({Side.LEFT: None, Side.RIGHT: None}, 0)
    assert node.publishers == {}  # nobody has pulled: nothing is said
    leading.pull({Side.LEFT: np.array([3.0, 0.0, 0.0]), Side.RIGHT: None}, 0)
    time.sleep(0.4)  # a busy machine
    for _ in range(50):
        leading.pull({}, 0)
    (told,) = node.publishers.values()
    assert told.forces[0] == [3.0, 0.0, 0.0]
    zeros = told.forces[1:]
    assert zeros
    assert not np.any(zeros)
    assert len(zeros) < 50  # and then it is silent, so that others may lead
