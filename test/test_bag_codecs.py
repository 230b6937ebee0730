"""The reader decodes what the graph encodes, sample for sample."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_messages import ABOUT, START, TICK_NS, TOPICS, joint_state, odometry, record

from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.recorder import Arrival
from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.core import samples
from follower_humanoid.core import topics as table
from follower_humanoid.core.samples import Side
from follower_humanoid.graph.record import Run
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.formats import format_of


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def recorded(folder: Path, robot: RobotModel, topic: str, collected: list[Any]) -> Run:
    """A bag with one sample of a topic every 10 ms."""
    codec = Codec(topic, robot)
    made = []
    for number, sample in enumerate(collected):
        tick = 5 * number
        received = START + tick * TICK_NS
        made.append(Arrival(TOPICS["joint_states"], joint_state(tick), received, received))
        made.append(Arrival(TOPICS["odom"], odometry(tick), received, received))
        made.append(Arrival(TOPICS[topic], codec.encode(sample, tick * TICK_NS), received + 1, received))
    with BagWriter(folder, ABOUT, START) as writer:
        record(writer, made)
    return read_run(folder)


def test_message_types_are_those_of_the_graph(robot: RobotModel) -> None:
    for name, topic in table.TOPICS.items():
        message = format_of(topic, robot).message_type
        package = message.__module__.partition(".")[0]
        assert TOPICS[name].type_name == f"{package}/msg/{message.__name__}"


def test_numbers_of_every_kind_come_back(tmp_path: Path, robot: RobotModel) -> None:
    rng = np.random.default_rng(2)
    cases: dict[str, list[Any]] = {
        "legs/command": [samples.Joints(*rng.standard_normal((3, 31))) for _ in range(4)],
        "motion/base": [
            samples.Odometry(
                *rng.standard_normal((1, 3)), rng.standard_normal(4), *rng.standard_normal((2, 3))
            )
            for _ in range(4)
        ],
        "left_hand/wrench": [samples.Wrench(*rng.standard_normal((2, 3))) for _ in range(4)],
        "zmp": [samples.Point(rng.standard_normal(3)) for _ in range(4)],
        "motion/contacts": [samples.ContactPlan(*rng.random(2)) for _ in range(4)],
        "gait": [samples.Gait(*rng.random(5)) for _ in range(4)],
    }
    for topic, collected in cases.items():
        series = recorded(tmp_path / topic.replace("/", "_"), robot, topic, collected)[topic]
        for name, values in series.fields.items():
            expected = [getattr(sample, name) for sample in collected]
            np.testing.assert_array_equal(values, expected, err_msg=f"{topic}.{name}")


def test_footsteps_come_back(tmp_path: Path, robot: RobotModel) -> None:
    steps = (
        samples.Footstep(Side.LEFT, np.array([0.5, 0.09, 0.0]), 0.3, True),
        samples.Footstep(Side.RIGHT, np.array([1.0, -0.09, 0.0]), -2.5, False),
        samples.Footstep(Side.LEFT, np.array([1.0, 0.09, 0.0]), math.pi / 2, False, counted=False),
    )
    series = recorded(
        tmp_path / "steps", robot, "footsteps", [samples.Footsteps(steps), samples.Footsteps(())]
    )
    (read,) = series["footsteps"].samples
    for step, back in zip(steps, read.steps, strict=True):
        assert (back.side, back.taken, back.counted) == (step.side, step.taken, step.counted)
        np.testing.assert_array_equal(back.position, step.position)
        assert back.yaw == pytest.approx(step.yaw, abs=1e-12)


def test_primitives_and_polygons_of_any_number_come_back(tmp_path: Path, robot: RobotModel) -> None:
    states = [
        samples.PrimitiveStates(("lean", "bend"), (0.25, 1.0)),
        samples.PrimitiveStates((), ()),
        samples.PrimitiveStates(("lower",), (0.0,)),
    ]
    assert list(recorded(tmp_path / "p", robot, "primitives", states)["primitives"].samples) == states
    shapes = [samples.Polygon(np.arange(3.0 * n).reshape(n, 3)) for n in (6, 0, 9)]
    read = recorded(tmp_path / "s", robot, "support_polygon", shapes)["support_polygon"].samples
    for shape, back in zip(shapes, read, strict=True):
        np.testing.assert_array_equal(back.vertices, shape.vertices)
