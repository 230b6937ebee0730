"""Samples survive the trip through a message bit for bit; messages of strangers are checked."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from geometry_msgs.msg import PointStamped, WrenchStamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from follower_humanoid.core import samples
from follower_humanoid.core.cdr import NANOSECONDS, clock_bytes, stamp_of
from follower_humanoid.core.samples import Side
from follower_humanoid.core.topics import PEOPLE, TOPICS
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.cdr import CdrWriter
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.validation import MessageError

# A sum of squares of the largest numbers overflows; it only decides whether to look more closely.
pytestmark = pytest.mark.filterwarnings("ignore:overflow")

ROBOT = RobotModel()
STAMP = 12_345 * 2_000_000 + 3 * NANOSECONDS
EXTREMES = np.array([0.0, -0.0, 5e-324, -1.7976931348623157e308, 1e-308, 0.1, -1 / 3, 1e17])


def numbers(rng, *shape):
    """Doubles of every size, none of them round."""
    values = rng.normal(size=shape) * 10.0 ** rng.integers(-300, 300, size=shape)
    flat = values.reshape(-1)
    flat[: min(len(flat), 3)] = rng.choice(EXTREMES, min(len(flat), 3))
    return values


def sample_of(topic, rng):
    kind = topic.kind
    if kind is samples.Joints:
        n = {"all": 45, "legs": len(ROBOT.groups.legs), "arms": len(ROBOT.groups.arms)}[topic.joints]
        return samples.Joints(*(numbers(rng, n) for _ in range(3)))
    if kind is samples.Wrench:
        return samples.Wrench(numbers(rng, 3), numbers(rng, 3), "torso" if topic.name in PEOPLE else "")
    if kind is samples.Odometry:
        return samples.Odometry(numbers(rng, 3), numbers(rng, 4), numbers(rng, 3), numbers(rng, 3))
    if kind is samples.Inertial:
        return samples.Inertial(numbers(rng, 4), numbers(rng, 3), numbers(rng, 3))
    if kind is samples.Point:
        return samples.Point(numbers(rng, 3))
    if kind is samples.Gait:
        return samples.Gait(*numbers(rng, 5).tolist())
    if kind is samples.ContactPlan:
        return samples.ContactPlan(*numbers(rng, 2).tolist())
    if kind is samples.PrimitiveStates:
        n = int(rng.integers(0, 5))
        names = tuple(f"lean_{i}" for i in range(n))
        return samples.PrimitiveStates(names, tuple(rng.uniform(size=n).tolist()))
    if kind is samples.Polygon:
        return samples.Polygon(rng.normal(size=(int(rng.integers(0, 9)), 3)))
    steps = tuple(
        samples.Footstep(
            Side.LEFT if i % 2 else Side.RIGHT, rng.normal(size=3), float(rng.uniform(-3, 3)), i < 2, i != 1
        )
        for i in range(int(rng.integers(0, 6)))
    )
    return samples.Footsteps(steps)


def same_bits(one, other):
    if isinstance(one, np.ndarray):
        return one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, float):
        return np.float64(one).tobytes() == np.float64(other).tobytes()
    return one == other


@pytest.mark.parametrize("name", TOPICS)
@pytest.mark.parametrize("seed", range(5))
def test_round_trip(name, seed):
    topic = TOPICS[name]
    sample = sample_of(topic, np.random.default_rng(seed))
    codec = Codec(name, ROBOT)
    data = codec.encode(sample, STAMP)
    back = codec.decode(data)
    if topic.kind is samples.Polygon:  # the message has single precision
        np.testing.assert_allclose(back.vertices, sample.vertices, rtol=1e-6)
        return
    if topic.kind is samples.Footsteps:  # the message has a quaternion for the yaw
        for one, other in zip(sample.steps, back.steps, strict=True):
            assert (one.side, one.taken, one.counted) == (other.side, other.taken, other.counted)
            assert same_bits(one.position, other.position)
            assert other.yaw == pytest.approx(one.yaw, abs=1e-12)
        return
    for field in type(sample).__slots__:
        assert same_bits(getattr(sample, field), getattr(back, field)), field


def alike(one, other):
    """The same bits, in samples and in samples within samples."""
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if hasattr(one, "__slots__") and dataclasses.is_dataclass(one):
        return all(alike(getattr(one, field), getattr(other, field)) for field in type(one).__slots__)
    return same_bits(one, other)


@pytest.mark.parametrize("name", ["footsteps", "primitives", "support_polygon"])
def test_a_message_like_the_one_before_it_is_the_same_sample_as_for_someone_who_sees_it_first(name):
    codec = Codec(name, ROBOT)
    for seed in range(40):
        data = codec.encode(sample_of(TOPICS[name], np.random.default_rng(seed)), STAMP + seed)
        slow = Codec(name, ROBOT).decode(data)
        assert alike(codec.decode(data), slow)
        assert alike(codec.decode(data), slow)  # now at the latest it has been seen before


def test_a_message_like_the_one_before_it_is_checked_for_numbers_too():
    codec = Codec("support_polygon", ROBOT)
    vertices = np.zeros((4, 3))
    codec.decode(codec.encode(samples.Polygon(vertices), 0))
    vertices[2, 1] = np.nan
    with pytest.raises(MessageError, match="not finite"):
        codec.decode(codec.encode(samples.Polygon(vertices), 0))


@pytest.mark.parametrize("name", TOPICS)
def test_bytes_are_the_message_that_ros_would_send(name):
    codec = Codec(name, ROBOT)
    data = codec.encode(sample_of(TOPICS[name], np.random.default_rng(2)), STAMP)
    message = deserialize_message(data, codec.message_type)
    assert bytes(CdrWriter(message).data) == data
    header = message.markers[0].header if hasattr(message, "markers") else message.header
    assert header.frame_id == TOPICS[name].frame or TOPICS[name].kind is samples.Wrench
    assert header.stamp.sec * NANOSECONDS + header.stamp.nanosec == STAMP
    again = deserialize_message(serialize_message(message), codec.message_type)
    assert again == message


def test_encoding_again_leaves_earlier_bytes_alone():
    codec = Codec("odom", ROBOT)
    rng = np.random.default_rng(0)
    first = codec.encode(sample_of(TOPICS["odom"], rng), 1)
    copy = bytes(first)
    codec.encode(sample_of(TOPICS["odom"], rng), 2)
    assert first == copy


def test_decoded_arrays_are_ordinary():
    codec = Codec("joint_states", ROBOT)
    back = codec.decode(codec.encode(sample_of(TOPICS["joint_states"], np.random.default_rng(0)), 1))
    assert back.position.flags.aligned
    assert back.position.flags.c_contiguous
    assert back.position.dtype == np.float64


@pytest.mark.parametrize("stamp", [0, 2_000_000, NANOSECONDS - 2_000_000, 86_400 * NANOSECONDS + 4_000_000])
def test_stamp_is_exact(stamp):
    codec = Codec("zmp", ROBOT)
    assert stamp_of(codec.encode(samples.Point(np.zeros(3)), stamp)) == stamp
    assert stamp_of(clock_bytes(stamp)) == stamp


def joint_message(names, **arrays):
    return JointState(name=list(names), **{key: list(value) for key, value in arrays.items()})


def foreign(topic, message):
    return Codec(topic, ROBOT).decode(serialize_message(message))


def test_names_in_another_order_are_sorted():
    order = np.random.default_rng(1).permutation(45)
    names = [ROBOT.joint_names[i] for i in order]
    values = np.arange(45.0)
    message = joint_message(names, position=values[order], velocity=-values[order], effort=2 * values[order])
    sample = foreign("joint_states", message)
    np.testing.assert_array_equal(sample.position, values)
    np.testing.assert_array_equal(sample.velocity, -values)
    np.testing.assert_array_equal(sample.effort, 2 * values)


def test_references_may_leave_out_the_effort():
    zeros = np.zeros(45)
    sample = foreign("motion/reference", joint_message(ROBOT.joint_names, position=zeros, velocity=zeros))
    assert not sample.effort.any()


def test_commands_may_leave_out_their_references_which_are_then_unknown():
    names = [ROBOT.joint_names[i] for i in ROBOT.groups.arms]
    sample = foreign("arms/command", joint_message(names, effort=np.ones(14)))
    assert np.isnan(sample.position).all()


def test_gait_without_heading_looks_where_it_goes():
    message = joint_message(["step_height", "walk_dir", "step_length", "walk_speed"], position=[4, 3, 2, 1])
    assert foreign("gait", message) == samples.Gait(1.0, 3.0, 2.0, 4.0, 3.0)


@pytest.mark.parametrize("frame", ["", "l_sole", "robot/l_sole"])
def test_frames_that_mean_the_same(frame):
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.force.z = 7.0
    assert foreign("left_foot/wrench", message).force[2] == 7.0


def test_a_person_names_the_frame():
    message = WrenchStamped()
    message.header.frame_id = "torso"
    assert foreign("base/push", message).frame == "torso"


def long_joints(**changes):
    fields = {"position": np.zeros(45), "velocity": np.zeros(45), "effort": np.zeros(45), **changes}
    return joint_message(fields.pop("names", ROBOT.joint_names), **fields)


NAMES = list(ROBOT.joint_names)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (long_joints(names=[NAMES[1], *NAMES[1:]]), f"given twice: {NAMES[1]}"),
        (long_joints(names=["tail", *NAMES[1:]]), "unknown name: tail"),
        (joint_message(NAMES[1:], position=np.zeros(44)), f"name missing: {NAMES[0]}"),
        (long_joints(position=np.zeros(44)), "position has 44 entries for 45 names"),
        (long_joints(velocity=[]), "velocity has 0 entries for 45 names"),
        (long_joints(position=[np.nan] + [0.0] * 44), "not finite"),
    ],
)
def test_unusable_joints_are_refused(message, reason):
    with pytest.raises(MessageError, match=reason) as error:
        foreign("joint_states", message)
    assert "joint_states" in str(error.value)


def test_a_complaint_about_many_names_is_short():
    names = [f"tail_{n}" for n in range(20_000)]
    with pytest.raises(MessageError, match="given twice") as error:
        foreign("joint_states", long_joints(names=[*names, *names]))
    assert "19995 more" in str(error.value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["joint_states", "odom", "left_foot/wrench", "gait", "zmp_reference"])
def test_our_own_layout_is_checked_for_numbers_too(name, value):
    sample = sample_of(TOPICS[name], np.random.default_rng(0))
    first = type(sample).__slots__[0]
    old = getattr(sample, first)
    if isinstance(old, np.ndarray):
        old[-1] = value
    else:
        sample = type(sample)(value, *[0.0] * (len(type(sample).__slots__) - 1))
    codec = Codec(name, ROBOT)
    with pytest.raises(MessageError, match="not finite"):
        codec.decode(codec.encode(sample, 0))


def test_huge_numbers_are_still_numbers():
    codec = Codec("zmp", ROBOT)
    huge = np.full(3, 1e300)
    np.testing.assert_array_equal(codec.decode(codec.encode(samples.Point(huge), 0)).xyz, huge)


def test_another_frame_is_refused():
    message = PointStamped()
    message.header.frame_id = "odom"
    with pytest.raises(MessageError, match="frame 'odom'; needs 'world'"):
        foreign("zmp_reference", message)


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 60])
def test_rubbish_is_refused(data):
    with pytest.raises(MessageError, match="joint_states"):
        Codec("joint_states", ROBOT).decode(data)
