"""Hostile files: an error in one line, never a crash, and nothing outside their folder."""

from __future__ import annotations

import random
import struct
from contextlib import suppress

import pytest
from bag_messages import write_bag
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from follower_humanoid.bag.reader import read_run
from follower_humanoid.core.config import build
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.faults.files import tried_files
from follower_humanoid.faults.hostile_files import KINDS, HostileBag, HostileUrdf
from follower_humanoid.faults.short_bag import short_bag
from follower_humanoid.gait.composition import MotionComposition
from follower_humanoid.graph.repeatable import repeatable
from follower_humanoid.graph.resimulate import Repetition
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.leader.leader import LeaderConfig
from follower_humanoid.plant.simulator import Simulator, SimulatorConfig
from follower_humanoid.robot.model import RobotModel


@pytest.mark.parametrize("kind", KINDS)
def test_hostile_files_are_read_or_refused(kind):
    outcome = tried_files(kind, 30, seed=0)
    assert outcome.findings == []
    assert outcome.read + outcome.refused == 30
    assert outcome.refused > 5


def test_a_reader_that_fails_is_found(monkeypatch):
    # The worker is a process of its own: what it makes of a bad file is seen from here.
    outcome = tried_files("no such kind", 1, seed=0)
    assert outcome.findings


def test_the_same_seed_gives_the_same_file(tmp_path):
    files = [HostileBag(tmp_path / str(n)).content(5, random.Random("seed")) for n in range(2)]
    assert files[0] == files[1]


@pytest.mark.parametrize("path", ["../secret.yaml", "a/../../secret.yaml", "with\0null"])
def test_a_relative_path_in_a_parameter_stays_in_its_folder(path):
    for config, name in ((LeaderConfig, "programme"), (MotionComposition.Config, "sequence")):
        with pytest.raises(ConfigurationError, match=name):
            build(config, {name: path})


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot/>', "document type"),
        ("<robot>" + "<link>" * 100_000, "nested too deeply"),
        ("<robot>", "malformed"),
        ("", "malformed"),
        ("<robot><link name='a'><inertial><mass value='nan'/></inertial></link></robot>", "mass value"),
        ("<robot><limit lower='1e300'/></robot>", "limit lower"),
        ("<robot><link name='a&#10;b'/></robot>", "without spaces"),
        ("<robot><joint name='a\n\nb'/></robot>", "without spaces"),
        ("<robot><joint name='a'><child link='a\tb'/></joint></robot>", "without spaces"),
        ("<robot><mesh filename='/etc/passwd'/></robot>", "outside its own folder"),
        ("<robot><mesh filename='a/../../b.stl'/></robot>", "outside its own folder"),
        ("x" * 3_000_000, "larger than"),
    ],
)
def test_a_hostile_robot_description_is_refused_in_one_line(tmp_path, text, reason):
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=reason) as error:
        RobotModel(str(path))
    assert "\n" not in str(error.value)


def test_a_device_is_no_robot_description():
    with pytest.raises(ConfigurationError, match="not a file"):
        RobotModel("/dev/zero")


def test_soles_that_carry_nothing_are_refused_in_words(tmp_path):
    # A leg is moved off to the side by a displaced origin: what the springs need has no solution then.
    path = tmp_path / "robot.urdf"
    hostile = HostileUrdf(tmp_path)
    path.write_bytes(hostile.content(2283, random.Random("URDF 7 2283")))
    with pytest.raises(ConfigurationError) as error:
        hostile.read(path)
    assert "\n" not in str(error.value)


def test_a_simulator_that_cannot_begin_leaves_no_physics_server(monkeypatch):
    closed = []
    monkeypatch.setattr("follower_humanoid.plant.world.World.close", lambda world: closed.append(world))
    config = build(SimulatorConfig, {"standing.hip_height": 1.0})
    with pytest.raises(ConfigurationError):
        Simulator(config, RobotModel(), 0.002)
    assert len(closed) == 1


def test_a_chunk_that_unpacks_to_a_gigabyte_is_left_out(tmp_path):
    path = tmp_path / "bomb.mcap"
    path.write_bytes(HostileBag(tmp_path / "whole").content(1, random.Random(0)))
    run = read_run(path)
    assert any("more than the" in note for note in run.notes)
    assert len(run["joint_states"]) > 0


def test_a_message_without_any_byte_is_left_out(tmp_path):
    path = write_bag(tmp_path / "bag", 20) / "bag_0.mcap"
    empty = struct.pack("<BQHIQQ", 0x05, 22, 1, 0, 1, 1)
    data = path.read_bytes()
    begin = 8 + 9 + struct.unpack_from("<Q", data, 9)[0]
    path.write_bytes(data[:begin] + empty + data[begin:])
    assert len(read_run(path)["joint_states"]) == 20


def test_joints_without_names_are_left_out_and_told(tmp_path):
    nameless, seen = bytes(serialize_message(JointState())), []

    def damage(data):
        """Takes the place of the first motion/contacts and of the first gait."""
        try:
            names = tuple(deserialize_message(data, JointState).name)
        except Exception:
            return data
        if names in seen or len(names) > 10:
            return data
        seen.append(names)
        return nameless

    run = read_run(short_bag(tmp_path / "bag", damage))
    assert len(seen) > 1
    assert any("cannot be decoded" in note for note in run.notes)


@pytest.mark.parametrize("number", [316, 4731])
def test_damage_that_was_not_survived_once(tmp_path, number):
    path = tmp_path / "bag.mcap"
    hostile = HostileBag(tmp_path / "whole")
    path.write_bytes(hostile.content(number, random.Random(f"MCAP 7 {number}")))
    with suppress(ConfigurationError):  # it may be refused
        hostile.read(path)


def test_a_path_in_a_bag_is_not_followed(tmp_path):
    run = simulate("none", 0.02)
    secret = tmp_path / "secret.yaml"
    secret.write_text("phases: 3\n")
    run.about["parameters.yaml"] = f"motion_composition: {{ros__parameters: {{sequence: {secret}}}}}\n"
    with pytest.raises(ConfigurationError, match="carries no sequence"):
        Repetition(repeatable(run), tmp_path)
