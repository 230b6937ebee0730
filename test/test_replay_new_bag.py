"""A run simulated again can be kept: its bag is like the recorder's, and can be simulated again itself."""

from __future__ import annotations

import dataclasses
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from std_msgs.msg import Header

from follower_humanoid.bag.cdr import Cursor
from follower_humanoid.bag.mcap_writer import McapWriter
from follower_humanoid.bag.parameter_events import parameter_event
from follower_humanoid.bag.reader import read_run
from follower_humanoid.graph.record import Adjusted, Holding, Run
from follower_humanoid.graph.repeatable import repeatable
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.nodes.replay import main
from follower_humanoid.replay.again import FAILED, repeat
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.simulated_bag import SimulatedBag

TICKS, CHANGED = 120, 40
PARAMETERS = {"simulator": {"ground.friction": 0.7}}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    programme = tmp_path_factory.mktemp("programme") / "pull.yaml"
    programme.write_text("- {until: 1, left: [0.0, 0.0, 8.0]}\n")
    chain = Chain({"leader": {"programme": str(programme)}, **PARAMETERS})
    try:
        for tick in range(TICKS):
            if tick == CHANGED:
                chain.adjust("arm_controller", {"mode": "auto", "payload": 0.5})
            chain.advance()
    finally:
        chain.close()
    blocks = {name: {"ros__parameters": values} for name, values in PARAMETERS.items()}
    return dataclasses.replace(chain.finish(), about={"parameters.yaml": yaml.safe_dump(blocks)})


@pytest.fixture(scope="module")
def bag(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("again") / "bag"
    assert repeat(repeatable(run), verify=True, keep=partial(SimulatedBag, folder, None)).difference is None
    return folder


def test_it_is_the_run_bit_for_bit(run, bag):
    kept = read_run(bag)
    assert kept.notes == ()
    assert kept.joint_hash() == run.joint_hash()
    assert kept.adjusted == run.adjusted
    assert kept.about["parameters.yaml"] == run.about["parameters.yaml"]
    assert kept.urdf == run.urdf
    for topic in ("odom", "left_hand/applied", "imu"):
        np.testing.assert_array_equal(kept[topic].ticks, run[topic].ticks)
        for name, values in kept[topic].fields.items():
            np.testing.assert_array_equal(values, run[topic].fields[name])
    # No leader is simulated; while it stands no step is planned, and no markers carry no stamp.
    missing = {"leader/left_hand/wrench", "leader/right_hand/wrench", "base/push", "footsteps"}
    assert kept.series.keys() == run.series.keys() - missing


def test_it_can_be_simulated_again(bag, tmp_path, capsys):
    assert main([str(bag), "--simulate", "--verify", "--bag", str(tmp_path / "third")]) == 0
    assert f"identical to the bag: joint positions of {TICKS} ticks" in capsys.readouterr().out
    assert read_run(tmp_path / "third").joint_hash() == read_run(bag).joint_hash()


def test_others_can_read_it(bag):
    with AnyReader([bag]) as reader:
        topics = {connection.topic: connection.msgcount for connection in reader.connections}
        assert topics["/joint_states"] == TICKS
        assert topics["/clock"] == pytest.approx(TICKS / 5, abs=1)
        assert topics["/gait"] == pytest.approx(TICKS / 5, abs=1)
        assert topics["/graph/adjusted"] == 1
        assert reader.duration == pytest.approx(TICKS * 2_000_000, abs=4_000_000)


VALUES = {
    "mode": "auto", "payload": 0.5, "on": True, "count": -7, "numbers": (0.1, -2.0, 3.0),
    "words": ("a", "längere"), "flags": (True, False, True), "whole": (1, -(2**40)), "last": "x",
}  # fmt: skip


def test_changes_are_written_as_the_wire_has_them(run: Run, tmp_path: Path) -> None:
    """Every byte has a meaning: no reader stumbles over what follows, and equal messages are equal bytes."""
    adjusted, holding = Adjusted(41, "arm_controller", VALUES), Holding(41, ("arms/command",))
    written = SimulatedBag(tmp_path / "bag", None, run, RobotModel())
    for _ in range(2):
        written.adjust(adjusted)
        written.hold(holding)
    written.close()
    with AnyReader([tmp_path / "bag"]) as reader:
        datas: dict[str, list[bytes]] = {}
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)  # which wants each byte accounted for
            datas.setdefault(connection.topic, []).append(bytes(data))
    (first, second), (held, held_again) = datas["/graph/adjusted"], datas["/graph/holding"]
    assert first == second
    assert held == held_again

    expected = ParameterEvent(node="arm_controller")
    expected.stamp.nanosec = 41 * 2_000_000
    expected.changed_parameters = [
        Parameter(name, value=list(value) if isinstance(value, tuple) else value).to_parameter_msg()
        for name, value in VALUES.items()
    ]
    assert deserialize_message(first, ParameterEvent) == expected
    cursor = Cursor(first)
    assert parameter_event(cursor) == (41 * 2_000_000, "arm_controller", VALUES)
    assert cursor.position == len(first), "nothing behind the message"
    assert deserialize_message(held, Header).frame_id == "arms/command"
    assert len(held) == 4 + 8 + 4 + len("arms/command") + 1


@pytest.mark.parametrize("flushed", [200, 50])  # [ms]: refused when it is closed; before that, and then too
def test_a_full_disk_ends_it_with_one_line(bag, tmp_path, monkeypatch, capsys, flushed):
    put = McapWriter._put

    def fill(writer: McapWriter, data: bytes) -> None:
        if writer._chunk_count > 1:
            raise OSError(28, "No space left on device")
        put(writer, data)

    monkeypatch.setattr(McapWriter, "_put", fill)
    monkeypatch.setattr("follower_humanoid.bag.writer._FLUSH_NS", flushed * 1_000_000)
    target = tmp_path / "full"
    assert main([str(bag), "--simulate", "--bag", str(target)]) == FAILED
    told = capsys.readouterr().err.splitlines()
    assert told[-1] == f"{target}: No space left on device; what was written before can be read"
    kept = read_run(target)
    assert len(kept["joint_states"]) == pytest.approx(flushed / 2, abs=2)
    assert any("cut off" in note for note in kept.notes)


def test_no_room_for_temporary_files_is_told_as_that(bag, monkeypatch, capsys):
    def refuse(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("follower_humanoid.replay.again.tempfile.TemporaryDirectory", refuse)
    assert main([str(bag), "--simulate"]) == FAILED
    assert capsys.readouterr().err.splitlines()[-1] == "a temporary file: No space left on device"


def test_nothing_is_overwritten_and_what_is_played_is_not_recorded(bag, tmp_path, capsys):
    before = {file: file.stat().st_mtime_ns for file in bag.iterdir()}
    assert main([str(bag), "--simulate", "--bag", str(bag)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert {file: file.stat().st_mtime_ns for file in bag.iterdir()} == before
    assert main([str(bag), "--bag", str(tmp_path / "new")]) == 2
    assert "--bag needs --simulate" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_a_namespace_is_kept(run, tmp_path):
    short = dataclasses.replace(run, series={**run.series, "joint_states": first(run, "joint_states", 20)})
    repeat(repeatable(short), verify=False, keep=partial(SimulatedBag, tmp_path / "bag", "/one/"))
    with AnyReader([tmp_path / "bag"]) as reader:
        parts = {c.topic.split("/")[1] for c in reader.connections}
    assert parts - {"tf", "tf_static"} == {"one"}, "transforms are everybody's"
    assert len(read_run(tmp_path / "bag", "one")["joint_states"]) == 20


def first(run: Run, topic: str, count: int):
    series = run[topic]
    fields = {name: values[:count] for name, values in series.fields.items()}
    return dataclasses.replace(
        series, ticks=series.ticks[:count], stamps=series.stamps[:count], fields=fields
    )
