"""A run simulated again can be kept: its bag is like the recorder's, and can be simulated again itself."""

from __future__ import annotations

import dataclasses
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader

from follower_humanoid.bag.reader import read_run
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.resimulate import repeatable
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.nodes.replay import main
from follower_humanoid.replay.again import repeat
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
