"""What a player takes from a bag: whole, cut off, of others."""

from __future__ import annotations

import struct
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import pytest
from bag_messages import START, TICK_NS, TOPICS, arrivals, write_bag
from graph_bench import PATIENCE
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from follower_humanoid.bag.recorder import Arrival
from follower_humanoid.core.cdr import clock_bytes
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.replay.events import CLOCK, READING_AHEAD, Event, events, with_clock
from follower_humanoid.replay.index import index_bag
from follower_humanoid.replay.offered import Offered, offered_in
from follower_humanoid.replay.player import Player, PlayOptions

STORE = get_typestore(Stores.ROS2_JAZZY)


def foreign_bag(
    folder: Path,
    count: int = 20,
    storage: StoragePlugin = StoragePlugin.MCAP,
    beside: Mapping[str, Sequence[int]] = MappingProxyType({}),
) -> Path:
    """A bag that other software wrote: `/chatter` every 10 ms, and other topics at the given [ms]."""
    text = STORE.types["std_msgs/msg/String"]
    moments = {"/chatter": [10 * number for number in range(count)], **beside}
    with Writer(folder, version=9, storage_plugin=storage) as writer:
        topics = {
            name: writer.add_connection(name, "std_msgs/msg/String", typestore=STORE) for name in moments
        }
        for moment, name in sorted((moment, name) for name, own in moments.items() for moment in own):
            data = STORE.serialize_cdr(text(data=f"hello at {moment}"), "std_msgs/msg/String")
            writer.write(topics[name], START + moment * 1_000_000, bytes(data))
    return folder


def test_the_index_tells_topics_counts_and_times(tmp_path):
    index = index_bag(write_bag(tmp_path / "bag", 100))
    assert index.topics["/joint_states"].type_name == "sensor_msgs/msg/JointState"
    assert index.topics["/joint_states"].count == 100
    assert index.begin == START
    assert index.duration == pytest.approx(99 * 0.002, abs=1e-4)
    assert index.notes == []


def test_a_bag_that_was_cut_off_is_played_as_far_as_it_goes(tmp_path):
    bag = write_bag(tmp_path / "bag", 3000)
    file = next(bag.glob("*.mcap"))
    data = file.read_bytes()
    file.write_bytes(data[: len(data) * 2 // 3])
    index = index_bag(bag)
    count = index.topics["/joint_states"].count
    assert 0 < count < 3000
    assert any("cut off" in note for note in index.notes)
    played = list(events(index, frozenset({"/joint_states"})))
    assert len(played) == count


def test_events_come_in_order_from_the_start_that_was_asked_for(tmp_path):
    index = index_bag(write_bag(tmp_path / "bag", 200))
    played = list(events(index, frozenset({"/odom", "/com"}), START + 100 * TICK_NS))
    assert {event.topic for event in played} == {"/odom", "/com"}
    assert played[0].time >= START + 100 * TICK_NS
    times = [event.time for event in played]
    assert times == sorted(times)
    assert sum(event.topic == "/odom" for event in played) == 100


def test_leaving_a_playback_ends_the_reading_ahead(tmp_path):
    index = index_bag(write_bag(tmp_path / "bag", 2000))
    before = set(threading.enumerate())
    stream = events(index, frozenset(index.topics))
    next(stream)
    (reading,) = (t for t in set(threading.enumerate()) - before if t.name == READING_AHEAD)
    assert reading.is_alive(), "the bag is longer than what is read ahead"
    stream.close()
    reading.join(PATIENCE)
    assert not reading.is_alive()


def test_a_clock_is_made_from_the_times_of_receipt():
    messages = [Event(1_000_000_000 + n * 7_000_000, "/a", b"") for n in range(4)]
    played = list(with_clock(messages, 10_000_000))
    clocks = [event for event in played if event.topic == CLOCK]
    assert [event.time - 1_000_000_000 for event in clocks] == [0, 10_000_000, 20_000_000]
    assert clocks[1].data == struct.pack("<4siI", b"\x00\x01\x00\x00", 1, 10_000_000)
    assert [event for event in played if event.topic == "/a"] == messages


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_a_bag_of_others_is_played_with_a_clock_of_ours(tmp_path, storage):
    index = index_bag(foreign_bag(tmp_path / "foreign", storage=storage))
    assert index.duration == pytest.approx(0.19)
    assert index.topics["/chatter"].count == 20
    player = Player(index, PlayOptions(tmp_path / "foreign", rate=100.0), index.topics)
    assert player.makes_clock
    sent: list[str] = []
    player.run(lambda topic, data: sent.append(topic))
    assert sent.count("/chatter") == 20
    assert sent.count("/clock") == 20


def test_topics_are_chosen_and_the_clock_goes_with_them(tmp_path):
    bag = write_bag(tmp_path / "bag", 20)
    index = index_bag(bag)
    assert Player(index, PlayOptions(bag, topics=("odom",)), index.topics).topics == {"/odom"}
    without = Player(index, PlayOptions(bag, without=("/odom",)), index.topics).topics
    assert without == index.topics.keys() - {"/odom"}
    with pytest.raises(UnknownNameError, match=r"^bag .*bag: no topic '/nothing'; valid: .*/odom"):
        Player(index, PlayOptions(bag, topics=("/nothing",)), index.topics)
    for option in ("--start", "--start-offset"):
        with pytest.raises(ConfigurationError, match=f"^{option} 5: bag .* ends after"):
            Player(index, PlayOptions(bag, start=5.0, start_option=option), index.topics)
    with pytest.raises(ConfigurationError, match="nothing that can be played"):
        Player(index, PlayOptions(bag), ())


def test_a_start_behind_a_single_message_is_refused(tmp_path):
    index = index_bag(foreign_bag(tmp_path / "one", 1))
    assert index.duration == 0.0
    Player(index, PlayOptions(tmp_path / "one"), index.topics)
    with pytest.raises(ConfigurationError, match="ends after"):
        Player(index, PlayOptions(tmp_path / "one", start=0.5), index.topics)


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize(
    ("topics", "start", "duration", "told"),
    [
        (("early", "earlier"), 0.1, None, "^--start 0.1: bag .* holds no /earlier, /early after 0.040 s"),
        (("early",), 0.0401, 0.1, "^--start 0.0401: bag .* holds no /early after 0.040 s"),
        (("late",), 0.01, 0.1, "^--start 0.01: bag .* holds no /late until 0.180 s, after the 0.1 s to play"),
        (("late",), 0.0, 0.1, "^bag .* holds no /late until 0.180 s, after the 0.1 s to play"),
        (("silent",), 0.0, None, "^bag .* holds no /silent$"),
        (("silent",), 0.1, None, "^--start 0.1: bag .* holds no /silent$"),
        (("late",), 0.18, None, ""),
        (("late",), 0.1, 0.08, ""),
        (("early",), 0.04, None, ""),
        (("early", "late"), 0.1, None, ""),
        ((), 0.18, None, ""),
    ],
)
def test_when_nothing_is_left_to_play_a_loop_does_not_begin(tmp_path, storage, topics, start, duration, told):
    beside = {"/early": [20, 40], "/earlier": [10], "/late": [180], "/silent": []}
    bag = foreign_bag(tmp_path / "bag", storage=storage, beside=beside)
    index = index_bag(bag)
    options = PlayOptions(bag, 50.0, loop=True, topics=topics, start=start, duration=duration)
    if told:
        with pytest.raises(ConfigurationError, match=told):
            Player(index, options, index.topics)
        return
    player = Player(index, options, index.topics)
    player.run(lambda topic, data: player.pace.stop() if topic != "/clock" else None)
    assert player.sent >= 1


def test_a_clock_alone_is_not_played(tmp_path):
    moments = [START + tick * TICK_NS for tick in range(40)]
    clock = [Arrival(TOPICS["clock"], clock_bytes(moment), moment, moment) for moment in moments]
    bag = write_bag(tmp_path / "bag", made=sorted([*arrivals(20), *clock], key=lambda a: a.received))
    index = index_bag(bag)
    with pytest.raises(ConfigurationError, match=r"holds no /com after 0\.03. s"):
        Player(index, PlayOptions(bag, loop=True, topics=("com",), start=0.05), index.topics)
    assert Player(index, PlayOptions(bag, topics=("clock",), start=0.05), index.topics).topics == {"/clock"}


def test_a_loop_goes_on_until_stopped(tmp_path):
    bag = write_bag(tmp_path / "bag", 20)
    index = index_bag(bag)
    player = Player(index, PlayOptions(bag, rate=50.0, loop=True, topics=("odom",)), index.topics)

    def send(topic: str, data: bytes) -> None:
        if player.sent > 20 * 5:
            player.pace.stop()

    player.run(send)
    assert player.sent > 100


def test_a_part_of_the_time_is_played(tmp_path):
    bag = write_bag(tmp_path / "bag", 100)
    index = index_bag(bag)
    options = PlayOptions(bag, rate=50.0, topics=("odom",), start=0.05, duration=0.1, clock=0.0)
    player = Player(index, options, index.topics)
    player.run(lambda topic, data: None)
    assert player.sent == 50


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        ("", Offered()),
        ("no: [yaml", Offered()),
        ("5", Offered()),
        ("- {reliability: best_effort, durability: volatile, depth: 50}", Offered(False, False, 50)),
        ("- {reliability: reliable, durability: transient_local, depth: 1}", Offered(True, True, 10)),
        ("- {history: 1, depth: 7, reliability: 2, durability: 1}", Offered(False, True, 10)),
        ("- {reliability: 1, durability: 2}\n- {reliability: 2, durability: 1}", Offered(True, False, 10)),
    ],
)
def test_quality_of_service_of_old_and_new_bags(text, offered):
    assert offered_in(text) == offered


def test_what_is_no_bag_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="does not exist"):
        index_bag(tmp_path / "nowhere")
    (tmp_path / "zero.mcap").touch()
    with pytest.raises(ConfigurationError, match="is empty"):
        index_bag(tmp_path / "zero.mcap")
    (tmp_path / "junk.db3").write_bytes(b"junk" * 1000)
    with pytest.raises(ConfigurationError, match="cannot be read"):
        index_bag(tmp_path / "junk.db3")
    (tmp_path / "junk.mcap").write_bytes(b"junk" * 100)
    with pytest.raises(ConfigurationError, match="not an MCAP file"):
        index_bag(tmp_path / "junk.mcap")
