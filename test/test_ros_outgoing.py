"""What goes to the recorder only is thinned out as the recorder does it, once it has said how."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from follower_humanoid.bag.thinning import Thinning, is_thinned
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros import outgoing
from follower_humanoid.ros.lines import Lines
from follower_humanoid.ros.outgoing import SLOT, Outgoing

NAME = "zmp_balance"
TICK = 2_000_000
SLOTS = (10_000_000, 7_000_000, 30_000_000)


@pytest.fixture
def line(monkeypatch):
    lines = Lines()
    lines.lay([(NAME, RECORDER), ("simulator", RECORDER)], composed=True)
    monkeypatch.setattr(outgoing, "BORN_WITH", lines)
    made = Outgoing(NODES[NAME], NODES)
    yield made, lines.ears[NAME, RECORDER]
    lines.keep(())


def samples(tick):
    """Of every topic, but for one that comes now and then."""
    made = {topic: SimpleNamespace(tick=tick) for topic in NODES[NAME].outputs.values()}
    if tick % 3:
        made["dcm"] = None
    return made


def test_everything_goes_until_the_recorder_has_spoken(line):
    made, _ = line
    assert made.recorded
    made.look()
    assert all(made.kept(samples(tick), tick * TICK) == samples(tick) for tick in range(9))


@pytest.mark.parametrize("slot", SLOTS)
def test_the_recorder_would_keep_the_same(line, slot):
    made, ear = line
    ear.say(SLOT.pack(slot))
    made.look()
    recorder = Thinning(slot)
    for tick in range(100):
        every, kept = samples(tick), made.kept(samples(tick), tick * TICK)
        assert list(kept) == list(every)  # absent ones keep their places
        for topic, sample in every.items():
            wanted = sample is not None and (not is_thinned(topic) or recorder.keeps(topic, tick * TICK))
            assert kept[topic] == (sample if wanted else None), (topic, tick)


def test_the_recorder_may_change_its_mind(line):
    made, ear = line
    for slot in SLOTS:
        ear.say(SLOT.pack(slot))
        made.look()
        kept = [made.kept(samples(tick), tick * TICK)["balance/reference"] for tick in range(105)]
        assert sum(sample is not None for sample in kept) == -(-105 * TICK // slot)


def test_words_of_another_kind_are_nothing(line):
    made, ear = line
    ear.say(b"what?")
    made.look()
    assert made.kept(samples(0), 0) == samples(0)
