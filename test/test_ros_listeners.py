"""A publisher knows of everybody who depends on it, and of nobody else."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import pytest

from follower_humanoid.ros.listeners import Listeners

OWN = "/one"


class Graph:
    """Node and publisher in one; `listening` are (name, namespace) of who listens."""

    topic_name = "/one/topic"

    def __init__(self):
        self.listening, self.hearers, self.asked, self.nameless = [], frozenset(), 0, 0

    def get_namespace(self):
        return OWN

    def get_subscription_count(self):
        return len(self.listening) + self.nameless

    def get_subscriptions_info_by_topic(self, topic):
        assert topic == self.topic_name
        self.asked += 1
        return [SimpleNamespace(node_name=n, node_namespace=s) for n, s in self.listening]


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def listeners(graph):
    return Listeners(graph, graph, lambda: graph.hearers)


def test_without_other_ways_everybody_counts_and_nobody_is_asked_for_a_name(graph, listeners):
    assert not listeners.look()
    graph.listening = [("legs", OWN)]
    assert listeners.look()
    graph.listening = []
    assert not listeners.look()
    assert graph.asked == 0


PEOPLE = [("legs", OWN), ("recorder", OWN), ("legs", "/two"), ("echo", "/")]


@pytest.mark.parametrize("count", range(len(PEOPLE) + 1))
def test_only_those_count_who_do_not_hear_it_anyway(graph, listeners, count):
    graph.hearers = frozenset({"legs", "recorder"})
    for chosen in itertools.permutations(PEOPLE, count):
        graph.listening = []
        listeners.look()
        graph.listening = list(chosen)
        assert listeners.look() == any(one not in PEOPLE[:2] for one in chosen)


def test_one_whose_name_is_not_known_yet_counts(graph, listeners):
    graph.hearers, graph.listening, graph.nameless = frozenset({"legs"}), [("legs", OWN)], 1
    assert listeners.look()


def test_who_no_longer_hears_it_otherwise_counts(graph, listeners):
    graph.hearers, graph.listening = frozenset({"legs"}), [("legs", OWN)]
    assert not listeners.look()
    graph.hearers = frozenset()
    assert listeners.look()


def test_one_who_takes_anothers_place_is_found_after_a_while(graph, listeners):
    graph.hearers, graph.listening = frozenset({"legs"}), [("legs", OWN)]
    assert not listeners.look()
    graph.listening = [("echo", "/")]
    assert any(listeners.look() for _ in range(100))
    assert graph.asked < 10
