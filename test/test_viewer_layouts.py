"""Layouts of other tools name topics, joints and frames that exist."""

import json
import re
import xml.etree.ElementTree as ElementTree

import pytest
import yaml

from follower_humanoid.core.topics import TOPICS
from follower_humanoid.resources import share_path
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.launch_options import displays_command

KNOWN = {*TOPICS, "robot_description", "markers", "diagnostics"}
GAIT = {"walk_speed", "walk_dir", "step_length", "step_height", "heading"}


def topic_in(path: str) -> str:
    """The longest known topic that a path begins with."""
    words = path.strip("/").split("/")
    names = ("/".join(words[:count]) for count in range(len(words), 0, -1))
    found = next((name for name in names if name in KNOWN), None)
    assert found, path
    return found


def leaves(value):
    """Every text within lists and mappings, names included."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from leaves(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from leaves(inner)
    elif isinstance(value, str):
        yield value


@pytest.fixture(scope="module")
def robot():
    return RobotModel()


def test_rviz_shows_robot_and_markers_in_the_world(robot):
    layout = yaml.safe_load(share_path("config/rviz/follower.rviz").read_text())["Visualization Manager"]
    assert layout["Global Options"]["Fixed Frame"] == "world"
    topics = {
        display[key]["Value"]
        for display in layout["Displays"]
        for key in ("Topic", "Description Topic")
        if key in display
    }
    assert {"robot_description", "markers"} <= topics <= KNOWN
    robot.frame_id(layout["Views"]["Current"]["Target Frame"])


def test_foxglove_names_topics_and_frames_that_exist(robot):
    layout = json.loads(share_path("config/foxglove/follower.json").read_text())
    panels = layout["configById"]
    for text in leaves(panels):
        if text.startswith("/"):
            topic_in(re.split(r"[.\[]", text)[0])
    for frame in panels["3D!follower"]["transforms"]:
        assert frame == "frame:world" or robot.frame_id(frame.removeprefix("frame:"))
    assert {text for text in leaves(layout["layout"]) if "!" in text} == set(panels)


def test_plotjuggler_names_curves_that_exist(robot):
    root = ElementTree.parse(share_path("config/plotjuggler/follower.xml")).getroot()
    curves = [curve.get("name") for curve in root.iter("curve")]
    assert len(curves) > 30
    for curve in curves:
        topic = topic_in(curve)
        rest = curve.strip("/").removeprefix(topic).strip("/").split("/")
        if topic.endswith("/command"):
            assert rest[0] in robot.joint_names
            assert rest[1] == "effort"
        elif topic == "gait":
            assert rest[0] in GAIT


def test_displays_need_no_page():
    words = displays_command("left")
    assert words[-2:] == ["-r", "__ns:=/left"]
    assert "page:=false" in words
