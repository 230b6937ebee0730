"""Bags that are cut off, broken, empty or of others: what is there is read, the rest is said in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag_messages import ABOUT, START, TICK_NS, TOPICS, arrivals, point, record, write_bag
from mcap.writer import Writer

from follower_humanoid.bag.mcap_writer import McapWriter
from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.recorder import Arrival
from follower_humanoid.bag.writer import About, BagWriter
from follower_humanoid.errors import ConfigurationError


def refusal(path: Path) -> str:
    """What reading complains of; empty where something was read."""
    try:
        read_run(path)
    except ConfigurationError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("ticks", [200, 2000])
def test_a_recorder_that_was_killed_leaves_all_but_the_last_moment(tmp_path: Path, ticks: int) -> None:
    writer = BagWriter(tmp_path / "killed", ABOUT, START)
    record(writer, arrivals(ticks))  # 0.4 s or 4 s, and never closed
    run = read_run(tmp_path / "killed")
    assert len(run["joint_states"]) >= ticks - 110
    assert run.urdf == "<robot/>"
    assert any("cut off" in note for note in run.notes)
    writer.close()


@pytest.mark.parametrize("keep", [0.3, 0.6, 0.9, 0.999])
def test_a_truncated_file_gives_its_beginning(tmp_path: Path, keep: float) -> None:
    whole = (write_bag(tmp_path / "whole", 2500) / "whole_0.mcap").read_bytes()
    part = tmp_path / "part.mcap"
    part.write_bytes(whole[: int(keep * len(whole))])
    run = read_run(part)
    np.testing.assert_array_equal(run["joint_states"].ticks, np.arange(len(run["joint_states"])))
    assert len(run["joint_states"]) >= 0.5 * keep * 2500


def test_every_truncation_is_read_or_told(tmp_path: Path) -> None:
    whole = (write_bag(tmp_path / "short", 40) / "short_0.mcap").read_bytes()
    part = tmp_path / "part.mcap"
    for length in range(0, len(whole), 97):
        part.write_bytes(whole[:length])
        assert "\n" not in refusal(part)


def test_a_broken_chunk_is_left_out(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "broken", 2500) / "broken_0.mcap"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    run = read_run(path)
    assert 1000 < len(run["joint_states"]) < 2500
    assert any("broken" in note for note in run.notes)
    assert any("ticks are missing" in note for note in run.notes)


def test_many_broken_records_are_told_in_one_line(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "broken", 4000) / "broken_0.mcap"
    data = bytearray(path.read_bytes())
    for place in range(len(data) // 8, len(data) * 7 // 8, len(data) // 16):
        data[place] ^= 0xFF
    path.write_bytes(data)
    told = [note for note in read_run(path).notes if "broken" in note]
    assert len(told) == 1
    assert "records are broken and left out" in told[0]


def test_rubbish_never_ends_in_a_traceback(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    whole = (write_bag(tmp_path / "whole", 60) / "whole_0.mcap").read_bytes()
    path = tmp_path / "rubbish.mcap"
    for _ in range(150):
        data = bytearray(whole)
        for place in rng.integers(8, len(data), 12):
            data[place] = int(rng.integers(256))
        path.write_bytes(data)
        assert "\n" not in refusal(path)


def _file(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def test_what_is_no_bag_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "old").mkdir()
    _file(tmp_path / "old" / "old_0.db3", b"SQLite format 3\0")
    cases = {
        tmp_path / "nowhere": "does not exist",
        tmp_path / "folder": "holds no .mcap file",
        tmp_path / "old": "only MCAP can be read",
        _file(tmp_path / "empty.mcap", b""): "is empty",
        _file(tmp_path / "text.mcap", b"hello, this is a text"): "is not an MCAP file",
        _file(tmp_path / "magic.mcap", b"\x89MCAP0\r\n"): "breaks off in its header",
    }
    for path, message in cases.items():
        with pytest.raises(ConfigurationError, match=message) as caught:
            read_run(path)
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)


def test_a_bag_of_something_else_is_told_with_what_it_holds(tmp_path: Path) -> None:
    made = [Arrival(TOPICS["com"], point(0), START, START)]
    with pytest.raises(ConfigurationError, match="holds no joint_states of a follower; it holds /com"):
        read_run(write_bag(tmp_path / "other", made=made))


def test_a_file_of_ros_1_is_told(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros1")
        writer.finish()
    with pytest.raises(ConfigurationError, match="not of ROS 2"):
        read_run(path)


def test_messages_of_the_wrong_form_are_counted(tmp_path: Path) -> None:
    made = [*arrivals(10), Arrival(TOPICS["odom"], b"\x00\x01\x00\x00abc", START + 10 * TICK_NS, START)]
    run = read_run(write_bag(tmp_path / "form", made=made))
    assert any(note.startswith("odom: 1 messages cannot be decoded") for note in run.notes)
    assert len(run["odom"]) == 10


@pytest.mark.parametrize("name", ["joint_states", "odom"])
def test_a_bag_whose_robot_cannot_be_decoded_is_told(tmp_path: Path, name: str) -> None:
    rubbish = b"\x00\x01\x00\x00abc"
    made = [a._replace(data=rubbish) if a.topic.name == name else a for a in arrivals(10)]
    bag = write_bag(tmp_path / "rubbish", made=made)
    with pytest.raises(ConfigurationError, match=f"{bag}: none of its 10 {name} can be decoded"):
        read_run(bag)


def bag_with_tick(folder: Path, tick: str, count: int = 10) -> Path:
    with BagWriter(folder, About("<robot/>", {}, {"tick": tick}), START) as writer:
        record(writer, arrivals(count))
    return folder


@pytest.mark.parametrize(
    "tick", ["inf", "-inf", "nan", "0", "-0.0", "1e-12", "-0.002", "1e300", "1e100", "soon", ""]
)
def test_a_tick_that_cannot_be_is_told_in_one_line(tmp_path: Path, tick: str) -> None:
    told = refusal(bag_with_tick(tmp_path / "tick", tick))
    assert f"bag {tmp_path / 'tick'}: control tick '{tick}'" in told
    assert "\n" not in told


def test_a_tick_is_taken_as_it_was_recorded(tmp_path: Path) -> None:
    assert read_run(bag_with_tick(tmp_path / "half", "0.001")).tick == 0.001
    assert read_run(bag_with_tick(tmp_path / "shortest", "1e-9")).tick == 1e-9


def test_without_a_tick_it_is_the_commonest_distance_of_two_states(tmp_path: Path) -> None:
    for count in (1, 10):
        with BagWriter(tmp_path / str(count), About("<robot/>"), START) as writer:
            record(writer, arrivals(count))
    assert read_run(tmp_path / "10").tick == 0.002
    with pytest.raises(ConfigurationError, match=f"bag {tmp_path / '1'}: .*a single joint state"):
        read_run(tmp_path / "1")


def refuse(*_: object) -> None:
    raise OSError(28, "No space left on device")


def test_a_full_disk_leaves_what_was_flushed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    writer = BagWriter(tmp_path / "full", About(), START)
    channel = writer.add_topic("/com", TOPICS["com"].type_name, [])
    writer.write(channel, point(0), START, START)
    monkeypatch.setattr(writer._stream, "write", refuse)
    with pytest.raises(OSError, match="No space"):
        writer.close()
    writer.close()
    assert not (tmp_path / "full" / "metadata.yaml").exists()


def fill_the_disk(folder: Path, patch: pytest.MonkeyPatch, then: Exception | None = None) -> None:
    """Ends a recording whose disk is full, perhaps by an error of its own."""
    with BagWriter(folder, About(), START) as writer:
        patch.setattr(writer._stream, "write", refuse)
        if then is not None:
            raise then


def test_a_full_disk_is_told_with_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OSError, match="No space") as caught:
        fill_the_disk(tmp_path / "full", monkeypatch)
    assert caught.value.filename == str(tmp_path / "full")


def test_an_error_is_not_hidden_by_one_of_closing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigurationError, match="what it comes from"):
        fill_the_disk(tmp_path / "full", monkeypatch, ConfigurationError("what it comes from"))


def test_a_disk_that_is_full_at_once_leaves_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(McapWriter, "flush", refuse)
    with pytest.raises(ConfigurationError, match="cannot be made: No space left on device"):
        BagWriter(tmp_path / "full", ABOUT, START)
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_too_long_for_the_file_leaves_no_folder(tmp_path: Path) -> None:
    folder = tmp_path / ("n" * 251)  # a folder may be called that, its file is called a little longer
    with pytest.raises(ConfigurationError, match="cannot be made: File name too long"):
        BagWriter(folder, About(), START)
    assert list(tmp_path.iterdir()) == []
