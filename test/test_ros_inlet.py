"""What a node takes in of envelopes and of strangers' messages that it can use in part, or not at all."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.graph.graph_config import GraphConfig
from follower_humanoid.graph.lockstep import LockStep
from follower_humanoid.graph.resimulate import samples_of
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope, envelope_topic
from follower_humanoid.ros.inlet import Inlet

TICK = 2_000_000
ROBOT = RobotModel()


class Reader:
    """A node of which only what it hears matters."""

    bus = frozenset()  # in a process with others: what comes is delivered
    context = None
    tick_ns = TICK

    def __init__(self, name, left_out=()):
        self.wiring = NODES[name]
        self.present = frozenset(NODES) - set(left_out)
        self.graph = GraphConfig()
        self.lock = LockStep(self.wiring, self.present)
        self.rejected, self.hears, self.ready_steps, self.backs = [], {}, 0, []
        self.codecs = {topic: Codec(topic, ROBOT) for topic in self.wiring.inputs.values()}
        Inlet(self).open(self.codecs, self)

    def resolve_topic_name(self, topic, only_expand=False):
        return topic

    def make_subscription(self, kind, topic, callback, qos=None):
        self.hears[topic] = callback

    def watch_source(self, subscription, name):
        assert name in NODES

    def watch_stranger(self, subscription, name):
        pass

    def come_back(self, tick):
        self.backs.append(tick)

    def reject(self, error):
        self.rejected.append(str(error))

    def run_ready_steps(self):
        self.ready_steps += 1


def messages_of(tick):
    run = simulate("none", 0.004)
    samples = {name: samples_of(run[name]) for name in run.series}
    return {
        name: Codec(name, ROBOT).encode(sample[tick], tick * TICK)
        for name, sample in samples.items()
        if tick in sample
    }


MESSAGES = messages_of(0)


def broken(data):
    """A number of it is not finite."""
    data = bytearray(data)
    data[-8:] = np.float64(np.nan).tobytes()
    return bytes(data)


def state(**changed):
    """The simulator's envelope of tick 0."""
    envelope = Envelope(NODES["simulator"])
    return envelope.seal(0, [changed.get(topic, MESSAGES.get(topic, b"")) for topic in envelope.topics])


def test_an_envelope_counts_as_a_whole_or_not_at_all():
    node = Reader("wrench_sensing")
    hear = node.hears[envelope_topic("simulator")]
    hear(state(joint_states=broken(MESSAGES["joint_states"])))
    assert "joint_states rejected" in node.rejected[0]
    assert len(node.lock.missing()) == 4
    assert node.lock.late == node.ready_steps == 0
    hear(state())
    assert node.lock.missing() == []
    assert node.ready_steps == 1


def test_an_unusable_envelope_brings_nobody_back():
    node = Reader("wrench_sensing")
    node.hears[envelope_topic("simulator")](state(joint_states=broken(MESSAGES["joint_states"])))
    assert node.backs == []


@pytest.mark.parametrize("rubbish", [b"", b"\0\1\0\0", bytes(30), b"\xff" * 300])
def test_rubbish_is_rejected_wherever_it_comes(rubbish):
    node = Reader("zmp_balance", left_out=("wrench_sensing",))
    for topic, hear in node.hears.items():
        hear(rubbish)
        assert topic == "graph/absent" or node.rejected.pop()
    assert node.ready_steps == 0


def test_a_command_that_cannot_be_used_counts_as_none_at_the_tick_that_waits_for_it():
    node = Reader("simulator", left_out=("leg_controller", "leader"))
    waiting = [missing.topic for missing in node.lock.missing()]
    assert "legs/command" in waiting
    node.hears["legs/command"](broken(MESSAGES["legs/command"]))
    assert "legs/command" in node.rejected[0]
    assert [m.topic for m in node.lock.missing()] == [t for t in waiting if t != "legs/command"]


def test_a_command_of_another_tick_that_cannot_be_used_takes_nobodys_place():
    node = Reader("simulator", left_out=("leg_controller", "leader"))
    later = messages_of(1)["legs/command"]
    node.hears["legs/command"](broken(later))
    node.lock.put("arms/command", 0, "arms")
    node.hears["legs/command"](MESSAGES["legs/command"])
    assert node.lock.take()["legs/command"] is not None
    node.hears["legs/command"](later)
    assert [m.topic for m in node.lock.missing()] == ["arms/command"]
