"""A line hands on every message, in order, whether or not the other end listens, and tells of an end."""

from __future__ import annotations

import pytest
from graph_bench import ENDLESS

from follower_humanoid.graph.graph_config import LEADER, RECORDER
from follower_humanoid.graph.wiring import NODES, SIMULATOR
from follower_humanoid.ros.lines import DEPTH, LARGEST, RECORDER_DEPTH, Lines, line_pairs

PAIR = ("one", "two")
LARGE = 4096


def laid(*pairs):
    lines = Lines()
    lines.lay(pairs)
    return lines


@pytest.fixture
def line():
    lines = laid(PAIR)
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
    ear.wait(ENDLESS)  # at once, or this test never ends
    assert heard(ear) == [0, 1, 2, 3, 4]
    ear.wait(0.001)
    assert ear.take() is None
    assert ear.open


def test_who_does_not_listen_for_a_while_misses_nothing(line):
    mouth, ear = line
    for number in range(DEPTH // 2):
        mouth.send(message(number))
    assert mouth.flush()  # something is left: the system has not so much room
    numbers = []
    while mouth.flush():
        numbers += heard(ear)
    mouth.send(message(DEPTH // 2))
    assert numbers + heard(ear) == list(range(DEPTH // 2 + 1))


def test_who_does_not_listen_for_long_misses_the_oldest_of_what_was_kept(line):
    mouth, ear = line
    for number in range(3 * DEPTH):
        mouth.send(message(number))
    numbers = heard(ear)
    while mouth.flush():
        numbers += heard(ear)
    numbers += heard(ear)
    assert numbers == sorted(numbers)
    assert numbers[-DEPTH:] == list(range(2 * DEPTH, 3 * DEPTH))
    assert mouth.lost == 3 * DEPTH - len(numbers) > 0


def test_both_ends_learn_that_the_other_is_gone(line):
    mouth, ear = line
    mouth.send(message(7))
    mouth.close()
    assert heard(ear) == [7]
    assert not ear.open
    ear.wait(ENDLESS)
    mouth.send(message(8))
    assert not mouth.flush()

    lines = laid(PAIR)
    lines.keep(["one"])  # as in a process where "two" is not
    assert lines.ears == {}
    mouth = lines.mouths[PAIR]
    mouth.send(message(1))
    assert not mouth.open
    mouth.send(message(2))
    assert not mouth.flush()


def test_one_who_goes_while_messages_wait_for_it_is_noticed_quietly(line):
    mouth, ear = line
    for number in range(DEPTH):
        mouth.send(message(number))
    assert mouth.flush()
    ear.close()
    mouth.send(message(DEPTH))
    assert not mouth.open
    assert mouth.flush() == 0
    mouth.send(message(DEPTH))


def test_what_the_other_end_could_not_take_in_is_refused(line):
    mouth, ear = line
    mouth.send(bytes(LARGEST))
    assert len(ear.take()) == LARGEST
    with pytest.raises(ValueError, match="valid: up to"):
        mouth.send(bytes(LARGEST + 1))
    assert mouth.open


def test_nobody_keeps_messages_for_ears_that_will_not_listen():
    lines = laid(("a", "c"), ("b", "c"))
    lines.hear_only("c", ["a"])
    lines.mouths["b", "c"].send(b"this")
    lines.mouths["a", "c"].send(b"that")
    assert lines.ear_of("c", "b") is None
    assert not lines.mouths["b", "c"].open
    assert lines.ear_of("c", "a").take() == b"that"
    lines.keep(())


def test_a_recorder_may_hesitate_longer():
    lines = laid(("a", "b"), ("a", RECORDER))
    lost = []
    for mouth in lines.mouths.values():
        for number in range(RECORDER_DEPTH):
            mouth.send(message(number))
        lost.append(mouth.lost > 0)
    assert lost == [True, False]
    lines.keep(())


def test_a_process_keeps_the_ends_of_its_own_nodes():
    lines = laid(("a", "b"), ("b", "a"), ("b", "c"))
    lines.keep(["b"])
    assert set(lines.mouths) == {("b", "a"), ("b", "c")}
    assert set(lines.ears) == {("a", "b")}
    assert set(lines.mouths_of("b")) == {"a", "c"}
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
