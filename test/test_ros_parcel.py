"""Envelopes reach the recorder in the order in which they were sent, a tick of them in one message."""

from __future__ import annotations

import pytest

from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.ros.lines import LARGEST, Lines
from follower_humanoid.ros.parcel import Parcel, unpacked

NODES = ["simulator", "wrench_sensing", "leg_controller"]


@pytest.fixture
def sent():
    return []


def contents(parcels):
    return [[(sender, data) for sender, data, _ in unpacked(parcel)] for parcel in parcels]


def test_one_who_sends_alone_does_not_wait(sent):
    parcel = Parcel(sent.append, alone=True)
    parcel.add("simulator", b"0")
    parcel.add("simulator", b"1")
    assert contents(sent) == [[("simulator", b"0")], [("simulator", b"1")]]


def test_a_tick_of_several_goes_together(sent):
    parcel = Parcel(sent.append, alone=False)
    for tick in range(3):
        for name in NODES if tick != 1 else NODES[:2]:
            parcel.add(name, b"%d" % tick)
    assert contents(sent) == [[(n, b"0") for n in NODES], [(n, b"1") for n in NODES[:2]]]
    parcel.go()
    assert contents(sent)[2] == [(n, b"2") for n in NODES]
    parcel.go()
    assert len(sent) == 3
    times = [at for parcel in sent for _, _, at in unpacked(parcel)]
    assert times == sorted(times)


def test_a_line_takes_any_of_them(sent):
    parcel = Parcel(sent.append, alone=False)
    for name in NODES:
        parcel.add(name, bytes(LARGEST // 2))
    parcel.go()
    assert [len(c) for c in contents(sent)] == [1, 1, 1]
    assert max(map(len, sent)) < LARGEST


def test_nodes_of_one_process_share_a_line_and_a_parcel():
    lines = Lines()
    lines.lay([(name, RECORDER) for name in NODES], composed=True)
    parcels = {lines.parcel_of(name) for name in NODES}
    assert len(parcels) == 1
    (parcel,) = parcels
    for name in NODES:
        parcel.add(name, name.encode())
    parcel.go()
    lines.hear_only(RECORDER, NODES[1:])  # not all that comes this way is wanted
    heard = lines.ear_of(RECORDER, NODES[1]).take()
    assert [sender for sender, _, _ in unpacked(heard)] == NODES
    lines.keep(())


def test_each_process_has_its_own_else():
    lines = Lines()
    lines.lay([(name, RECORDER) for name in NODES])
    assert len({lines.parcel_of(name) for name in NODES}) == len(NODES)
    assert lines.parcel_of("leader") is None
    lines.keep(())


def test_a_hearer_can_say_what_it_leaves_out():
    lines = Lines()
    lines.lay([(name, RECORDER) for name in NODES], composed=True)
    mouths = [lines.mouths[name, RECORDER] for name in NODES]
    assert [mouth.heard_back() for mouth in mouths] == [b"", b"", b""]
    lines.ears[NODES[0], RECORDER].say(b"first")
    lines.ears[NODES[0], RECORDER].say(b"last")
    assert [mouth.heard_back() for mouth in mouths] == [b"last"] * 3
    lines.keep(())
    assert mouths[0].heard_back() == b"last"
