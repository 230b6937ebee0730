"""A node that fetches its messages itself gets all of them, in order, and sleeps until one is there."""

from __future__ import annotations

import time

import pytest
import rclpy
from graph_bench import ENDLESS, PATIENCE, wait_until
from std_msgs.msg import Header

from follower_humanoid.core.cdr import stamp_of
from follower_humanoid.ros.cdr import CdrWriter
from follower_humanoid.ros.lines import Lines
from follower_humanoid.ros.mailbox import Mailbox
from follower_humanoid.ros.qos import LOCKSTEP


class Correspondence:
    """A reader that wants one message of each topic per round, and who writes to it."""

    def __init__(self, node, topics):
        self.mailbox = node.mailbox
        self.publishers = {topic: node.create_publisher(Header, topic, LOCKSTEP) for topic in topics}
        self.round = 0
        self.received = {topic: [] for topic in topics}
        for topic in topics:
            subscription = node.create_subscription(Header, topic, lambda _: None, LOCKSTEP, raw=True)
            self.mailbox.add(
                subscription,
                lambda data, topic=topic: self.receive(topic, data),
                lambda topic=topic: len(self.received[topic]) <= self.round,
            )
        assert wait_until(lambda: all(p.get_subscription_count() for p in self.publishers.values()))

    def receive(self, topic, data):
        self.received[topic].append(stamp_of(data))
        return self.complete

    @property
    def complete(self):
        return all(len(received) > self.round for received in self.received.values())

    def write(self, topic, number):
        header = Header()
        header.stamp.nanosec = number
        self.publishers[topic].publish(bytes(CdrWriter(header).data))

    def fetch_round(self):
        until = time.monotonic() + PATIENCE
        while not self.complete:
            assert time.monotonic() < until
            assert self.mailbox.fetch(0.5)


@pytest.fixture
def node():
    context = rclpy.Context()
    rclpy.init(context=context)
    made = rclpy.create_node("reader", context=context)
    made.mailbox = Mailbox(context)
    yield made
    made.mailbox.close()
    made.destroy_node()
    rclpy.shutdown(context=context)


def test_every_message_comes_once_and_in_order(node):
    post = Correspondence(node, ("one", "two", "three"))
    for number in range(30):
        for topic in sorted(post.publishers, key=lambda topic: (number * len(topic)) % 7):
            post.write(topic, number)
        post.fetch_round()
        post.round += 1
    assert all(received == list(range(30)) for received in post.received.values())


def test_what_came_early_stays_until_it_is_wanted(node):
    post = Correspondence(node, ("one", "two"))
    for number in range(3):
        post.write("one", number)
    for number in range(3):
        post.write("two", number)
        post.fetch_round()
        assert post.received == {"one": list(range(number + 1)), "two": list(range(number + 1))}
        post.round += 1


def test_it_sleeps_no_longer_than_it_may_and_not_at_all_where_nothing_is_missing(node):
    post = Correspondence(node, ("one",))
    assert post.mailbox.fetch(0.01)
    assert post.received == {"one": []}
    post.write("one", 7)
    post.fetch_round()
    assert not post.mailbox.fetch(ENDLESS)  # at once, or this test never ends
    assert post.received == {"one": [7]}


def test_what_comes_by_a_line_is_not_read_from_the_topic_too(node):
    lines = Lines()
    lines.lay([("there", "here")])
    mouth, ear = lines.mouths["there", "here"], lines.ears["there", "here"]
    received = []
    subscription = node.create_subscription(Header, "one", lambda _: None, LOCKSTEP, raw=True)
    node.mailbox.add_line(ear, subscription, lambda data: not received.append(data), lambda: True)
    publisher = node.create_publisher(Header, "one", LOCKSTEP)
    assert wait_until(publisher.get_subscription_count)
    publisher.publish(Header())
    assert node.mailbox.fetch(0.05)
    assert received == []
    mouth.send(b"this")
    assert node.mailbox.fetch(PATIENCE)
    assert received == [b"this"]
    assert subscription in node.mailbox.subscriptions
    lines.keep(["here"])  # the other end is gone
    assert node.mailbox.fetch(PATIENCE)
    assert not node.mailbox.fetch(ENDLESS)  # nothing can come any more: at once, or this test never ends
