"""What observers see of a node: its newest samples some times a second, whole, and only while they look."""

from __future__ import annotations

import time

import numpy as np
import pytest
import rclpy
from graph_bench import PATIENCE
from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray
from test_ros_codecs import ROBOT, sample_of
from test_ros_envelope_layout import CODECS, same

from follower_humanoid.core.topics import TOPICS
from follower_humanoid.graph.graph_config import GraphConfig
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros.envelope import Envelope, seen_topic
from follower_humanoid.ros.envelope_reader import EnvelopeReader
from follower_humanoid.ros.envelope_writer import EnvelopeWriter
from follower_humanoid.ros.exhibit import EVERY, Exhibit
from follower_humanoid.ros.newest import Newest
from follower_humanoid.ros.qos import LOCKSTEP

WIRING = NODES["motion_composition"]


class Shelf:
    """A publisher that keeps what it is given."""

    def __init__(self):
        self.watchers, self.messages = 0, []

    def get_subscription_count(self):
        return self.watchers

    def publish(self, data):
        self.messages.append(data)


class Maker:
    """A node of which only the publisher matters."""

    wiring = WIRING

    def __init__(self):
        self.shelf = Shelf()

    def make_publisher(self, kind, topic):
        assert (kind, topic) == (UInt8MultiArray, seen_topic(WIRING.name))
        return self.shelf


def samples(rng, without=()):
    return {t: None if t in without else sample_of(TOPICS[t], rng) for t in WIRING.outputs.values()}


def exhibit(clock=time.monotonic):
    maker = Maker()
    return Exhibit(maker, EnvelopeWriter(Envelope(WIRING), CODECS), clock), maker.shelf


def test_nothing_is_shown_while_nobody_looks():
    shown, shelf = exhibit()
    shown.look()
    for tick in range(20):
        shown.show(samples(np.random.default_rng(tick)), tick)
    assert shelf.messages == []


def test_what_is_published_on_change_stays_to_be_seen():
    looks = 41
    times = iter((7.0 + 0.0501 * EVERY * np.arange(looks)).tolist())
    shown, shelf = exhibit(lambda: next(times))
    shelf.watchers = 1
    shown.look()
    rng = np.random.default_rng(3)
    said = [samples(rng, () if tick == 1 else ("footsteps",)) for tick in range(looks)]
    for tick, sample in enumerate(said):
        shown.show(sample, tick)
    assert len(shelf.messages) == 3  # at the beginning, and twice when EVERY has passed
    topics = tuple(WIRING.outputs.values())
    read = EnvelopeReader(Envelope(WIRING), {topic: CODECS[topic] for topic in topics})
    last = dict(zip(topics, read.read(shelf.messages[-1]), strict=True))
    change = CODECS["footsteps"].encode(said[1]["footsteps"], 0)
    assert CODECS["footsteps"].encode(last["footsteps"], 0) == change
    assert same(last["motion/reference"], said[-1]["motion/reference"])


class Observer(Node):
    """A node that looks by hand."""

    graph = GraphConfig()


@pytest.fixture
def nodes():
    context = rclpy.Context()
    rclpy.init(context=context)
    made = [Observer("observer", context=context), rclpy.create_node("speaker", context=context)]
    yield made
    for node in made:
        node.destroy_node()
    rclpy.shutdown(context=context)


def until_seen(newest, say, topic="zmp_reference"):
    until = time.monotonic() + PATIENCE
    while not newest.look(topic):
        assert time.monotonic() < until
        say()
        time.sleep(0.02)
    return newest.samples


def test_an_observer_sees_what_a_node_shows_and_hears_nothing_by_name(nodes):
    observer, speaker = nodes
    newest = Newest(observer, ("zmp_reference", "footsteps"), ROBOT, pytest.fail)
    newest.listen()
    publisher = speaker.create_publisher(UInt8MultiArray, seen_topic(WIRING.name), LOCKSTEP)
    said = samples(np.random.default_rng(1))
    data, _ = EnvelopeWriter(Envelope(WIRING), CODECS).seal(said, 14_000_000)
    seen = until_seen(newest, lambda: publisher.publish(data))
    assert same(seen["zmp_reference"], said["zmp_reference"])
    assert newest.stamp == 14_000_000
    assert speaker.count_subscribers("zmp_reference") == 0


def test_what_nobody_shows_is_heard_by_its_name(nodes):
    observer, speaker = nodes
    newest = Newest(observer, ("zmp_reference",), ROBOT, pytest.fail)
    newest.listen()
    codec = CODECS["zmp_reference"]
    publisher = speaker.create_publisher(codec.message_type, "zmp_reference", LOCKSTEP)
    said = sample_of(TOPICS["zmp_reference"], np.random.default_rng(2))
    seen = until_seen(newest, lambda: publisher.publish(codec.encode(said, 6_000_000)))
    assert same(seen["zmp_reference"], said)
    assert newest.stamp == 6_000_000
