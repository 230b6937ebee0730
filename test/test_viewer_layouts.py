"""Layouts of other tools name topics, joints and frames that exist."""

import importlib
import json
import re
import xml.etree.ElementTree as ElementTree

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from follower_humanoid.core.topics import TOPICS
from follower_humanoid.resources import share_path
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
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


def type_of(topic: str) -> type:
    """ROS message class of a topic."""
    if topic in TOPICS:
        return Codec(topic, RobotModel()).message_type
    return {"robot_description": String, "markers": MarkerArray, "diagnostics": DiagnosticArray}[topic]


def resolve(path: str) -> str:
    """ROS type of what a path such as `/odom.pose.pose.position.x` names."""
    words = re.findall(r"[^.\[\]]+", path)
    topic = topic_in(words[0])
    assert words[0] == f"/{topic}"
    kind = type_of(topic)
    for word in words[1:]:
        if word.isdigit():
            continue
        text = kind.get_fields_and_field_types()[word]
        element = re.sub(r"^sequence<(.+?)(?:, \d+)?>$|\[\d+\]$", r"\1", text)
        package, _, name = element.partition("/")
        kind = getattr(importlib.import_module(f"{package}.msg"), name) if name else element
    return kind if isinstance(kind, str) else kind.__name__


def test_foxglove_plots_numbers(robot):
    panels = json.loads(share_path("config/foxglove/follower.json").read_text())["configById"]
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", ())]
    assert len(paths) > 15
    assert {resolve(path) for path in paths} == {"double"}
    volts = [robot.joint_names[index] for index in robot.groups.legs]
    for path in panels["Plot!volts"]["paths"]:
        number = int(re.search(r"\[(\d+)\]", path["value"]).group(1))
        side, _, rest = path["label"].partition(" ")
        assert volts[number] == f"{side[0]}_{rest.replace(' ', '_')}"


def test_foxglove_shows_in_3d_what_it_can_draw():
    drawn = {"MarkerArray", "PolygonStamped", "PointStamped", "String"}
    topics = json.loads(share_path("config/foxglove/follower.json").read_text())["configById"]["3D!follower"]
    assert {type_of(topic_in(topic)).__name__ for topic in topics["topics"]} <= drawn


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
