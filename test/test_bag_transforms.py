"""Every bag carries the robot's description and its transforms, and they are those of the state."""

import hashlib
import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from follower_humanoid.bag.about import about_run
from follower_humanoid.bag.definitions import definition
from follower_humanoid.bag.recorder import Arrival, Recording, recorded_topics
from follower_humanoid.bag.transforms import PERIOD, TF_TYPE
from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.core.samples import Joints, Odometry
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec

TICK = 2_000_000
TICKS = 100


@pytest.fixture(scope="module")
def robot():
    return RobotModel()


@pytest.fixture(scope="module")
def states(robot):
    """A posture per tick."""
    rng = np.random.default_rng(5)
    zero = np.zeros(3)
    made = []
    for _ in range(TICKS):
        quat = rng.normal(size=4)
        odometry = Odometry(rng.normal(size=3), quat / np.linalg.norm(quat), zero, zero)
        position = rng.uniform(robot.lower, robot.upper)
        made.append((odometry, Joints(position, np.zeros(45), np.zeros(45))))
    return made


@pytest.fixture(scope="module")
def messages(tmp_path_factory, robot, states):
    """Topic → decoded messages of a bag of these postures."""
    folder = tmp_path_factory.mktemp("bags") / "bag"
    topics = {topic.name: topic for topic in recorded_topics()}
    codecs = {name: Codec(name, robot) for name in ("odom", "joint_states")}
    with BagWriter(folder, about_run("", {}, 0.002), 0) as writer:
        recording = Recording(writer, 100.0, TICK, lambda topic: (f"/ns/{topic.name}", []), robot.urdf)
        for tick, state in enumerate(states):
            for name, sample in zip(("odom", "joint_states"), state, strict=True):
                data = codecs[name].encode(sample, tick * TICK)
                recording.take(Arrival(topics[name], data, tick * TICK, tick * TICK))
            recording.flush()
    found = {}
    with next(folder.glob("*.mcap")).open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


def matrix(transform) -> np.ndarray:
    t, q = transform.transform.translation, transform.transform.rotation
    return np.array(pin.XYZQUATToSE3(np.array([t.x, t.y, t.z, q.x, q.y, q.z, q.w])).homogeneous)


def test_the_description_is_the_urdf_in_the_robots_namespace(messages, robot):
    assert [message.data for message in messages["/ns/robot_description"]] == [robot.urdf]


def test_transforms_lead_from_the_world_to_every_frame(messages, robot, states):
    fixed = {t.child_frame_id: t for t in messages["/tf_static"][0].transforms}
    data = robot.pin_model.createData()
    for message in messages["/tf"]:
        stamp = message.transforms[0].header.stamp
        odometry, joints = states[(stamp.sec * 10**9 + stamp.nanosec) // TICK]
        pin.framesForwardKinematics(robot.pin_model, data, robot.configuration(odometry, joints.position))
        tree = fixed | {t.child_frame_id: t for t in message.transforms}
        for frame in ("base_link", "head", "l_gripper", "r_contact_6", "gaze"):
            found, name = np.eye(4), frame
            while name != "world":
                found = matrix(tree[name]) @ found
                name = tree[name].header.frame_id
            np.testing.assert_allclose(
                found, data.oMf[robot.frame_id(frame)].homogeneous, atol=1e-9, err_msg=frame
            )


def test_transforms_come_fifty_times_a_second(messages):
    stamps = [m.transforms[0].header.stamp for m in messages["/tf"]]
    times = [stamp.sec * 10**9 + stamp.nanosec for stamp in stamps]
    np.testing.assert_array_equal(np.diff(times), PERIOD)
    assert len(times) == TICKS * TICK // PERIOD


def test_the_hash_of_the_transforms_type_follows_from_its_definition():
    # REP 2016: SHA-256 of the description as JSON, of types in alphabetical order.
    path = Path(sys.prefix, "share", "geometry_msgs", "msg", "TransformStamped.json")
    if not path.is_file():
        pytest.skip("geometry_msgs does not lie in this environment")
    known = json.loads(path.read_text())["type_description_msg"]

    def plain(description):
        keys = ("type_id", "capacity", "string_capacity", "nested_type_name")
        fields = [{"name": f["name"], "type": {k: f["type"][k] for k in keys}} for f in description["fields"]]
        return {"type_name": description["type_name"], "fields": fields}

    sequence = {"type_id": 145, "capacity": 0, "string_capacity": 0}
    kind = {**sequence, "nested_type_name": "geometry_msgs/msg/TransformStamped"}
    described = {
        "type_description": {"type_name": TF_TYPE, "fields": [{"name": "transforms", "type": kind}]},
        "referenced_type_descriptions": sorted(
            map(plain, [*known["referenced_type_descriptions"], known["type_description"]]),
            key=lambda entry: entry["type_name"],
        ),
    }
    digest = hashlib.sha256(json.dumps(described).encode()).hexdigest()
    assert definition(TF_TYPE).type_hash == f"RIHS01_{digest}"
