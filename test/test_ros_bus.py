"""Nodes of one process: samples by reference, steps one after the other, never one within another."""

from __future__ import annotations

from follower_humanoid.ros.bus import Bus


class Member:
    """Steps at every tick that it has heard of, and sends the next one on."""

    def __init__(self, bus, name, others, last):
        self.bus, self.name, self.last = bus, name, last
        self.heard, self.depth, self.deepest = [], 0, 0
        self.pending = []
        bus.join(name, self.step)
        self.others = others

    def listen(self):
        for other in self.others:
            self.bus.listen(self.name, other, self.accept)

    def accept(self, tick, samples, messages):
        self.heard.append(samples["topic"])
        self.pending.append(tick)
        return True

    def step(self):
        self.depth += 1
        self.deepest = max(self.deepest, self.depth)
        while self.pending:
            tick = self.pending.pop(0)
            if tick < self.last:
                self.bus.post(self.name, tick + 1, {"topic": [tick + 1]}, {})
        self.depth -= 1


def ring(last):
    bus = Bus(["one", "two"])
    members = [Member(bus, "one", ["two"], last), Member(bus, "two", ["one"], last)]
    for member in members:
        member.listen()
    return bus, members


def test_a_sample_arrives_as_the_same_object():
    bus, (_, two) = ring(0)
    sample = object()
    bus.post("one", 0, {"topic": sample}, {})
    assert two.heard[0] is sample


def test_nodes_that_answer_one_another_for_long_do_not_nest():
    bus, (one, two) = ring(10_000)
    bus.post("one", 0, {"topic": [0]}, {})
    assert not bus.work(60.0)
    assert one.heard[-1] == [9_999]
    assert two.heard[-1] == [10_000]
    assert (one.deepest, two.deepest) == (1, 1)


def test_work_ends_in_time_and_goes_on_later():
    bus, (_, two) = ring(100)
    bus.post("one", 0, {"topic": [0]}, {})
    turns = 0
    while bus.work(0.0):
        turns += 1
        assert bus.future().done()  # whoever waits for work need not wait
    assert turns == 100
    assert two.heard[-1] == [100]
    assert not bus.future().done()


def test_a_post_wakes_whoever_waits_for_work():
    bus, _ = ring(0)
    waited_for = bus.future()
    assert not waited_for.done()
    bus.post("one", 0, {"topic": [0]}, {})
    assert waited_for.done()


def test_who_listens_twice_hears_once():
    bus, (_, two) = ring(0)
    two.listen()
    bus.post("one", 0, {"topic": [0]}, {})
    assert len(two.heard) == 1
    assert "one" in bus
    assert "three" not in bus
