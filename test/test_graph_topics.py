"""Who listens to what in the running graph: the wiring table, and nothing that the contract forbids.

Between nodes of the package the topics of a tick travel together in envelopes. So the graph is looked at
twice: as it runs, and with every topic heard by its name, which shows what a node takes out of them.
"""

from __future__ import annotations

import time

import pytest
import rclpy
from graph_bench import PATIENCE
from rclpy.context import Context
from rclpy.parameter import Parameter

from follower_humanoid.bag.recorder import ADJUSTED, HOLDING
from follower_humanoid.core.topics import PEOPLE, READERS, TOPICS
from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import ARM_TASK, NODES, PRODUCER, SIMULATOR, WIRING, used_tick
from follower_humanoid.ros.barrier import RESET
from follower_humanoid.ros.component_node import ComponentNode
from follower_humanoid.ros.envelope import envelope_topic, seen_topic
from follower_humanoid.ros.leaving import LEAVE
from follower_humanoid.ros.outlet import ABSENT
from follower_humanoid.ros.simulator_node import SimulatorNode

NAMESPACE = "/robots"
ENVELOPES = {envelope_topic(name, slow) for name in NODES for slow in (False, True)}
SEEN = {seen_topic(name) for name in NODES}
OWN = {"robot_description", ABSENT, ADJUSTED, HOLDING, RESET, CLOCK, LEAVE, "graph/ready", *ENVELOPES, *SEEN}
ROS_OWN = {"/parameter_events", "/rosout", "/diagnostics"}


def endpoints_with(namespace, *settings):
    """Node → (topics it listens to, topics it publishes), as the graph tells, namespace taken off."""
    context = Context()
    rclpy.init(context=context, args=["--ros-args", "-r", f"__ns:={namespace}"])
    settings = [Parameter("autostart", value=False), *settings]
    nodes = {
        name: SimulatorNode(context=context, parameter_overrides=settings)
        if name == SIMULATOR
        else ComponentNode(name, context=context, parameter_overrides=settings)
        for name in NODES
    }
    for made in nodes.values():
        made.trigger_configure()
    assert [made.exit_reason for made in nodes.values() if made.exit_status is not None] == []
    asked = nodes[SIMULATOR]
    found, before = {}, None
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        found = {
            name: (
                topics_of(asked.get_subscriber_names_and_types_by_node, name, namespace),
                topics_of(asked.get_publisher_names_and_types_by_node, name, namespace),
            )
            for name in nodes
        }
        known = all(set(node.outputs.values()) <= found[node.name][1] for node in WIRING)
        known = known and all(RESET in found[name][0] for name in NODES if name != SIMULATOR)
        if known and found == before:
            break
        before = found
        time.sleep(0.2)
    yield found
    for made in nodes.values():
        made.destroy_node()
    rclpy.shutdown(context=context)


@pytest.fixture(scope="module")
def endpoints():
    yield from endpoints_with(f"{NAMESPACE}/by_topic", Parameter("by_topic", value=",".join(TOPICS)))


@pytest.fixture(scope="module")
def running():
    yield from endpoints_with(f"{NAMESPACE}/as_it_runs")


def topics_of(ask, name, namespace):
    full = {topic for topic, _ in ask(name, namespace)}
    above = f"{namespace}/"
    outside = {topic for topic in full if not topic.startswith(above)}
    assert outside <= ROS_OWN, "a name that does not follow the namespace"
    own = {topic.removeprefix(above) for topic in full - outside}
    return own - {f"{name}/transition_event"}  # the lifecycle's own


@pytest.mark.parametrize("name", NODES)
def test_node_listens_to_its_row_of_the_wiring_and_to_nothing_else(endpoints, name):
    listens, _ = endpoints[name]
    assert listens - OWN == set(NODES[name].inputs.values())


@pytest.mark.parametrize("name", NODES)
def test_node_publishes_its_row_of_the_wiring_and_nothing_else(endpoints, name):
    _, publishes = endpoints[name]
    assert publishes - OWN == set(NODES[name].outputs.values())


@pytest.mark.parametrize("name", NODES)
def test_envelopes_come_from_those_who_produce_an_input_and_from_nobody_else(running, name):
    listens, publishes = running[name]
    producers = {PRODUCER[topic].name for topic in NODES[name].inputs.values()}
    if name == "leader":  # the simulator's envelopes are its clock
        producers = {SIMULATOR}
    slow = NODES[name].period > 1
    assert listens & ENVELOPES == {envelope_topic(producer, slow) for producer in producers}
    assert envelope_topic(name) in publishes & ENVELOPES <= {envelope_topic(name), envelope_topic(name, True)}


@pytest.mark.parametrize("name", NODES)
def test_what_observers_see_is_for_no_node_of_the_graph(running, name):
    listens, publishes = running[name]
    assert not listens & SEEN
    assert publishes & SEEN == {seen_topic(name)}


def test_slow_nodes_are_the_only_reason_for_a_second_envelope(running):
    slow = {name for name, (_, publishes) in running.items() if envelope_topic(name, True) in publishes}
    assert slow == {SIMULATOR, "wrench_sensing", "arm_controller"}


@pytest.mark.parametrize("name", NODES)
def test_what_an_envelope_brings_is_not_heard_a_second_time(running, name):
    listens, publishes = running[name]
    assert listens - OWN == (PEOPLE if name == SIMULATOR else set())
    assert publishes - OWN == set(NODES[name].outputs.values())


@pytest.mark.parametrize("topic", TOPICS)
def test_nobody_reads_what_the_contract_does_not_let_it_read(endpoints, topic):
    readers = {name for name, (listens, _) in endpoints.items() if topic in listens}
    assert readers <= READERS.get(topic, frozenset(NODES))


def test_what_the_leader_does_is_known_to_the_simulator_only(endpoints):
    for topic in ("leader/left_hand/wrench", "leader/right_hand/wrench", "base/push"):
        assert {name for name, (listens, _) in endpoints.items() if topic in listens} == {SIMULATOR}


def test_the_clock_comes_from_the_simulator_alone(endpoints):
    assert {name for name, (_, publishes) in endpoints.items() if CLOCK in publishes} == {SIMULATOR}


@pytest.mark.parametrize("topic", TOPICS)
def test_every_topic_has_one_source(topic):
    assert sum(topic in node.outputs.values() for node in (*WIRING, ARM_TASK)) == 1


def test_only_the_state_and_the_commands_of_a_tick_are_used_at_that_tick():
    same = {topic for topic in TOPICS if used_tick(10, topic) == 10}
    of_the_tick = (SIMULATOR, "leg_controller", "arm_controller")
    published = {topic for name in of_the_tick for topic in NODES[name].outputs.values()}
    assert same == published - {"arms/mode"}  # neither state nor command
