"""Rates that `ros2` keeps and tells, on a clock that goes when somebody sleeps."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from follower_humanoid.command_line import Parser
from follower_humanoid.ros2_front import topic_pub
from follower_humanoid.ros2_front.topic_hz import statistics

RATE = 20.0
COUNT = 60


class Machine:
    """Sleeps as long as it is told to, but once for longer: after the message of that number."""

    def __init__(self, late: float = 0.0, after: int = 0) -> None:
        self.now = 0.0
        self.sent: list[float] = []
        self._late, self._after = late, after

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds + (self._late if len(self.sent) == self._after else 0.0)

    def get_subscription_count(self) -> int:
        return 0

    def publish(self, message: object) -> None:
        self.sent.append(self.now)


def sent_by(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    node = SimpleNamespace(create_publisher=lambda *_: machine)
    monkeypatch.setattr(topic_pub, "time", machine)
    monkeypatch.setattr(topic_pub, "graph_node", lambda *_: nullcontext(node))
    monkeypatch.setattr(topic_pub, "ok", lambda: len(machine.sent) < COUNT)
    parser = Parser()
    topic_pub.arguments(parser)
    words = ["-r", str(RATE), "-w", "0", "-p", "0", "/pull", "geometry_msgs/msg/WrenchStamped"]
    assert topic_pub.run(parser.parse_args(words)) == 0
    return machine.sent


def test_pub_keeps_its_rate(monkeypatch):
    sent = sent_by(Machine(), monkeypatch)
    assert sent == pytest.approx([number / RATE for number in range(COUNT)])


@pytest.mark.parametrize("late", [0.03, 0.27])
def test_pub_makes_up_for_a_short_delay(monkeypatch, late):
    sent = sent_by(Machine(late, after=2), monkeypatch)
    assert sent == pytest.approx([max(n / RATE, 0.1 + late if n > 1 else 0.0) for n in range(COUNT)])


def test_pub_does_not_make_up_for_a_long_delay(monkeypatch):
    sent = sent_by(Machine(9.0, after=2), monkeypatch)
    at_once = sum(time == pytest.approx(9.1) for time in sent)
    assert at_once <= 1.0 * RATE + 2
    since = sent[1 + at_once :]
    assert since == pytest.approx([9.1 + n / RATE for n in range(len(since))])


def test_hz_tells_the_rate_of_the_times_of_arrival():
    told = statistics([10**9 + 20_000_000 * number for number in range(51)])
    assert told.startswith("average rate: 50.000\n\tmin: 0.020s max: 0.020s std dev: 0.00000s window: 51")
