"""A node that somebody has started ends when its run is over, and not before."""

from __future__ import annotations

import logging
from types import SimpleNamespace

import pytest

from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros import watchdog as module
from follower_humanoid.ros.watchdog import Watchdog


class Node:
    """A started node that takes no step."""

    def __init__(self, name="gait_mapping"):
        self.wiring, self.present = NODES[name], frozenset(NODES)
        self.lock = SimpleNamespace(late=0, strange=0, give_up=lambda: [], missing=lambda: [])
        self.graph = SimpleNamespace(watchdog=0.0)
        self.steps, self.started, self.running, self.away = 7, True, True, False
        self.logger = logging.getLogger(__name__)
        self.clocks, self.ended = 1, []

    def make_timer(self, period, look):
        self.look = look

    def flush(self):
        return 0

    def count_publishers(self, topic):
        return self.clocks

    def quit(self, status, reason):
        self.ended.append((status, reason))


@pytest.fixture
def started_by_hand(monkeypatch):
    monkeypatch.delenv(module.PARENT, raising=False)


def looked_at(node, times=5, between=lambda node: None):
    Watchdog(node)
    node.look()  # it has come as far as this
    for _ in range(times):
        between(node)
        node.look()
    return node.ended


def without_simulator(node):
    node.clocks = 0


def hears_of_the_past(node):
    node.lock.late += 1


@pytest.mark.usefixtures("started_by_hand")
@pytest.mark.parametrize(
    ("between", "reason"),
    [(without_simulator, "its simulator has gone"), (hears_of_the_past, "simulated time has begun again")],
)
def test_it_ends_when_the_run_is_over(between, reason):
    assert looked_at(Node(), 1, between) == []  # one look is not enough
    status, words = looked_at(Node(), 2, between)[0]
    assert status == 0
    assert reason in words


@pytest.mark.usefixtures("started_by_hand")
def test_it_waits_for_others_while_there_is_a_simulator():
    assert looked_at(Node()) == []


@pytest.mark.usefixtures("started_by_hand")
def test_it_goes_on_while_it_takes_steps():
    def step(node):
        without_simulator(node)
        hears_of_the_past(node)
        node.steps += 1

    assert looked_at(Node(), between=step) == []


@pytest.mark.usefixtures("started_by_hand")
def test_the_simulator_itself_waits():
    assert looked_at(Node("simulator"), between=without_simulator) == []


def test_a_node_of_a_bringup_is_ended_by_it(monkeypatch):
    monkeypatch.setenv(module.PARENT, "1")
    assert looked_at(Node(), between=without_simulator) == []
