"""The viewer beside a running graph: leading it by the page, and what its end means to the other."""

import json
import os
import re
import signal
import subprocess
import sys

import pytest
from graph_bench import PATIENCE, beside, bringup, wait_until
from viewer_browser import Browser, needs_browser

from follower_humanoid.robot.model import RobotModel

# Patience for a browser that draws without a graphics card, and longer than a lost page is given to let go.
HOLD = 60.0
VIEWER = f"""
viewer:
  ros__parameters: {{port: 0, shadows: false, rate: 10.0, pull.patience: {HOLD}}}
"""

# Notes the forces that a topic carries, one JSON list a line.
LISTENER = """
import json, rclpy
from geometry_msgs.msg import WrenchStamped
rclpy.init()
node = rclpy.create_node("listener")
def hear(message):
    f = message.wrench.force
    print(json.dumps([f.x, f.y, f.z]), flush=True)
node.create_subscription(WrenchStamped, "leader/left_hand/wrench", hear, 10)
rclpy.spin(node)
"""


# Waits for the description, as one who comes late, and for markers that show the feet's forces.
OTHER_TOOL = """
import json, rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray
rclpy.init()
node = rclpy.create_node("other_tool")
found = {}
def described(message):
    found["description"] = message.data
def marked(message):
    shown = {m.ns for m in message.markers if m.action == m.ADD}
    if "foot_force" in shown:
        found["namespaces"] = sorted({m.ns for m in message.markers})
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "robot_description", described, latched)
node.create_subscription(MarkerArray, "markers", marked, 10)
while len(found) < 2:
    rclpy.spin_once(node)
print(json.dumps([found["description"], found["namespaces"]]))
"""


def address_in(text: str) -> str | None:
    found = re.search(r"viewer: (http://127\.0\.0\.1:\d+)", text)
    return found and found.group(1)


@pytest.fixture(scope="module")
def browser():
    browser = Browser()
    yield browser
    browser.close()


@needs_browser
def test_a_dragged_hand_makes_it_step_and_a_lost_page_lets_go(tmp_path, browser):
    (tmp_path / "viewer.yaml").write_text(VIEWER)
    heard = tmp_path / "heard.txt"
    arguments = ("--composed", "--leader", "none", "--bag", "none", "--view", "--params", "viewer.yaml")
    with bringup(tmp_path, *arguments) as run, heard.open("w") as file:

        def read(pattern: str) -> bool:
            assert run.process.poll() is None, run.complained
            return re.search(pattern, browser.text()) is not None

        def forces() -> list[list[float]]:
            return [json.loads(line) for line in heard.read_text().splitlines()]

        with beside(subprocess.Popen([sys.executable, "-c", LISTENER], env=run.environment, stdout=file)):
            run.wait_until_it_runs()
            assert wait_until(lambda: address_in(run.complained))
            address = address_in(run.complained)
            # Closed, not left: a browser may keep a page that was left, connection and all.
            with browser.second_window():
                browser.open(address)
                browser.wait(lambda: read("Standing"))
                # The camera looks from the right and the front: to the right of the picture is forward.
                browser.grab("/world/handles/left_hand", (25, 12))
                browser.wait(lambda: read("Walking, led by the left hand"))
                browser.wait(lambda: read(r"half-steps\s+[1-9]"))
                # Else the listener would miss the end of it.
                assert wait_until(lambda: any(map(any, forces())))
            assert wait_until(lambda: not any(forces()[-1]), HOLD / 2)
            assert max(f[0] for f in forces()) > 2.0
            assert all(sum(x * x for x in f) ** 0.5 <= 20.0 + 1e-6 for f in forces())
            browser.open(address)
            browser.wait(lambda: read("Standing|Coming to a stand"))
            run.end()
            assert run.process.returncode == 0, run.complained
            assert "The viewer was stopped" in browser.text()


def test_other_tools_get_description_and_markers_and_the_run_goes_on_without_its_viewer(tmp_path):
    (tmp_path / "viewer.yaml").write_text(VIEWER)
    arguments = ("--composed", "--leader", "none", "--bag", "none", "--view", "--params", "viewer.yaml")
    with bringup(tmp_path, *arguments) as run:
        run.wait_until_it_runs()
        assert wait_until(lambda: address_in(run.complained))
        told = subprocess.run(
            [sys.executable, "-c", OTHER_TOOL],
            env=run.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        assert told.returncode == 0, told.stderr
        description, namespaces = json.loads(told.stdout)
        assert description == RobotModel().urdf
        assert {"foot_force", "support_polygon", "com", "zmp", "dcm"} <= set(namespaces)
        viewer, graph = (os.getpriority(os.PRIO_PROCESS, run.child(name)) for name in ("viewer", "composed"))
        assert viewer > graph  # a higher niceness: it goes after those who work
        os.kill(run.child("viewer"), signal.SIGKILL)
        lines = len(run.said.splitlines())
        assert wait_until(lambda: len(run.said.splitlines()) > lines + 1)
        assert run.process.poll() is None
        run.end()
        assert run.process.returncode == 0, run.complained
