"""The HTML page carries everything it shows, and shows what was recorded."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from report_run import SWINGS, walking

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.page import write_page
from follower_humanoid.pictures.player import SCRIPT
from follower_humanoid.pictures.scene import scene, visual_shapes
from follower_humanoid.pictures.style import views
from follower_humanoid.robot.model import RobotModel


@pytest.fixture(scope="module")
def run() -> Run:
    return walking()


class Page(HTMLParser):
    """What a page refers to and which elements it leaves open."""

    VOID = frozenset({"meta", "img", "input", "br"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.references += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def floats(packed: str, *shape: int) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed), "<f4").reshape(shape)


def page_of(run: Run, path: Path, label: str = "walk") -> str:
    picture = path.with_name("picture.png")
    picture.write_bytes(b"\x89PNG")
    write_page(path, views([(label, run)]), [("Picture", picture)], ["a note & more"])
    return path.read_text(encoding="utf-8")


def test_nothing_is_fetched_from_elsewhere(run: Run, tmp_path: Path) -> None:
    page = Page(page_of(run, tmp_path / "page.html"))
    assert page.open == []
    assert page.references
    assert all(reference.startswith("data:image/png;base64,") for reference in page.references)
    assert "http" not in SCRIPT


def test_names_cannot_break_out(run: Run, tmp_path: Path) -> None:
    evil = "</script><script>alert(1)</script>"
    told = dataclasses.replace(run, about={"command": evil})
    text = page_of(told, tmp_path / "page.html", evil)
    assert "alert(1)</script>" not in text
    assert Page(text).open == []
    data = json.loads(re.search(r'id="runs">(.*?)</script>', text, re.DOTALL)[1])
    assert data[0]["label"] == evil


def test_the_scene_puts_links_where_they_were(run: Run) -> None:
    (view,) = views([("walk", run)])
    made = scene(view)
    poses = floats(made["poses"], made["frames"], made["links"], 7)
    frame = made["frames"] // 2
    tick = round((made["start"] + frame * made["step"]) / run.tick)
    robot = RobotModel()
    data = robot.pin_model.createData()
    q = np.concatenate(
        (run["odom"].position[tick], run["odom"].quat_xyzw[tick], run["joint_states"].position[tick])
    )
    pin.framesForwardKinematics(robot.pin_model, data, q)
    names = list(dict.fromkeys(shape.link for shape in visual_shapes(robot.urdf)))
    for index, name in enumerate(names):
        placement = data.oMf[robot.frame_id(name)]
        np.testing.assert_allclose(poses[frame, index, :3], placement.translation, atol=1e-5)
        quat = pin.Quaternion(placement.rotation).coeffs()
        assert abs(poses[frame, index, 3:] @ quat) == pytest.approx(1.0, abs=1e-6)


def test_footprints_appear_when_the_foot_lands(run: Run) -> None:
    (view,) = views([("walk", run)])
    appear = sorted(print_["from"] for print_ in scene(view)["prints"])
    np.testing.assert_allclose(appear, [-1.0, -1.0, *(landed for _, _, landed, *_ in SWINGS)], atol=0.011)


def test_every_visual_of_the_robot_is_shown() -> None:
    urdf = RobotModel().urdf
    shapes = visual_shapes(urdf)
    assert len(shapes) == urdf.count("<visual>")
    assert {shape.kind for shape in shapes} == {"box", "cylinder", "sphere"}
    assert all(max(shape.size) > 0 for shape in shapes)


def test_origins_turn_as_in_urdf() -> None:
    urdf = """<robot name="r"><link name="a"><visual><origin xyz="1 2 3" rpy="0.3 -0.4 1.1"/>
      <geometry><box size="1 1 1"/></geometry></visual></link></robot>"""
    (shape,) = visual_shapes(urdf)
    np.testing.assert_allclose(shape.rotation, pin.rpy.rpyToMatrix(0.3, -0.4, 1.1), atol=1e-15)
    assert shape.position == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    "urdf",
    ["<robot", '<robot><link><visual><geometry><box size="a b c"/></geometry></visual></link></robot>'],
)
def test_a_malformed_urdf_is_told(urdf: str) -> None:
    with pytest.raises(ConfigurationError, match="malformed"):
        visual_shapes(urdf)


PROBE = """
const nothing = () => ({addColorStop() {}});
const pen = new Proxy({}, {get: (target, name) => target[name] ?? nothing});
const element = (more) => Object.assign({addEventListener() {}, value: "1", textContent: ""}, more);
const canvas = element({width: 960, height: 560, getContext: () => pen});
let filled = 0;
pen.fill = () => { filled += 1; };
const root = {canvas, "select.run": null};
root.querySelector = (what) => what in root ? root[what] : (root[what] = element({}));
const player = new Player(root, JSON.parse(require("fs").readFileSync(0, "utf8")));
const front = player.project([player.target[0], player.target[1], player.target[2]]);
const above = player.project([player.target[0], player.target[1], player.target[2] + 0.5]);
player.frame = player.run.frames - 1; filled = 0; player.draw();
console.log(JSON.stringify({front, above, filled, clock: root["output"].textContent}));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node to run the page's script")
def test_the_player_draws_the_last_frame(run: Run, tmp_path: Path) -> None:
    (tmp_path / "probe.js").write_text(SCRIPT + PROBE)
    data = json.dumps([scene(view) for view in views([("walk", run)])])
    done = subprocess.run(
        ["node", tmp_path / "probe.js"], input=data, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    told: dict[str, Any] = json.loads(done.stdout)
    assert told["front"][:2] == pytest.approx([480, 280])
    assert told["above"][0] == pytest.approx(480)
    assert told["above"][1] < 280
    assert told["filled"] > 50
    assert told["clock"] == "7.00 s"
