"""A line hands on every message, in order, whether or not the other end listens, and tells of an end."""

from __future__ import annotations

import pytest

from follower_humanoid.graph.graph_config import LEADER, RECORDER
from follower_humanoid.graph.wiring import NODES, SIMULATOR
from follower_humanoid.ros.lines import _DEPTH, Lines, line_pairs

PAIR = ("one", "two")
LARGE = 4096


@pytest.fixture
def line():
    lines = Lines([PAIR])
    yield lines.mouths[PAIR], lines.ears[PAIR]
    lines.keep(())


def message(number):
    return number.to_bytes(4, "little") + bytes(LARGE)


def heard(ear):
    taken = []
    while (data := ear.take()) is not None:
        assert data == message(int.from_bytes(data[:4], "little"))
        taken.append(int.from_bytes(data[:4], "little"))
    return taken


def test_messages_arrive_whole_and_in_order(line):
    mouth, ear = line
    for number in range(5):
        mouth.send(message(number))
    ear.wait(60.0)  # at once, or this test never ends
    assert heard(ear) == [0, 1, 2, 3, 4]
    ear.wait(0.001)
    assert ear.take() is None
    assert ear.open


def test_who_does_not_listen_for_a_while_misses_nothing(line):
    mouth, ear = line
    for number in range(_DEPTH // 2):
        mouth.send(message(number))
    assert mouth.flush()  # something is left: the system has not so much room
    numbers = []
    while mouth.flush():
        numbers += heard(ear)
    mouth.send(message(_DEPTH // 2))
    assert numbers + heard(ear) == list(range(_DEPTH // 2 + 1))


def test_who_does_not_listen_for_long_misses_the_oldest_of_what_was_kept(line):
    mouth, ear = line
    for number in range(3 * _DEPTH):
        mouth.send(message(number))
    numbers = heard(ear)
    while mouth.flush():
        numbers += heard(ear)
    numbers += heard(ear)
    assert numbers == sorted(numbers)
    assert numbers[-_DEPTH:] == list(range(2 * _DEPTH, 3 * _DEPTH))


def test_both_ends_learn_that_the_other_is_gone(line):
    mouth, ear = line
    mouth.send(message(7))
    mouth.close()
    assert heard(ear) == [7]
    assert not ear.open
    ear.wait(60.0)
    mouth.send(message(8))
    assert not mouth.flush()

    lines = Lines([PAIR])
    lines.keep(["one"])  # as in a process where "two" is not
    assert lines.ears == {}
    mouth = lines.mouths[PAIR]
    mouth.send(message(1))
    assert not mouth.open
    mouth.send(message(2))
    assert not mouth.flush()


def test_a_process_keeps_the_ends_of_its_own_nodes():
    lines = Lines([("a", "b"), ("b", "a"), ("b", "c")])
    lines.keep(["b"])
    assert set(lines.mouths) == {("b", "a"), ("b", "c")}
    assert set(lines.ears) == {("a", "b")}
    assert set(lines.hearers_of("b")) == {"a", "c"}
    lines.keep(())


@pytest.mark.parametrize("recorded", [True, False])
def test_every_input_has_a_line_from_where_it_is_made(recorded):
    pairs = line_pairs(tuple(NODES), False, recorded)
    made_by = {topic: node.name for node in NODES.values() for topic in node.outputs.values()}
    for name, node in NODES.items():
        for topic in node.inputs.values():
            assert (made_by[topic], name) in pairs
    assert (SIMULATOR, LEADER) in pairs  # the clock paces it
    assert len(set(pairs)) == len(pairs)
    assert {sender for sender, hearer in pairs if hearer == RECORDER} == (set(NODES) if recorded else set())


def test_nodes_of_one_process_need_lines_to_the_recorder_only():
    assert line_pairs(tuple(NODES), True, True) == [(name, RECORDER) for name in NODES]
    assert line_pairs(tuple(NODES), True, False) == []


def test_there_are_no_lines_to_who_is_left_out():
    present = tuple(name for name in NODES if name != "leg_controller")
    assert not any("leg_controller" in pair for pair in line_pairs(present, False, True))
