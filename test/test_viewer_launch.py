"""The launch file, with ROS 2's `launch` or a stand-in for it: its arguments are bringup's options."""

import runpy

import launch_stand_in
import pytest
from graph_bench import environment

from follower_humanoid.resources import node_command, share_path
from follower_humanoid.ros.launch_options import SWITCHES, WORDS

try:
    from launch.launch_description_sources import get_launch_description_from_python_launch_file
except ImportError:
    get_launch_description_from_python_launch_file = None

FILE = str(share_path("launch/bringup.launch.py"))


@pytest.fixture
def describe(monkeypatch):
    """Reads the launch file."""
    launch_stand_in.installed(monkeypatch)
    return lambda: runpy.run_path(FILE)["generate_launch_description"]()


def test_nothing_given_is_a_plain_bringup_and_its_end_ends_the_launch(describe):
    context = launch_stand_in.launched(describe(), {})
    (only,) = context.processes
    assert only.cmd == node_command("bringup")
    assert context.shutdown is None
    only.on_exit[0].execute(context)
    assert context.shutdown == "the run is over"


def test_every_argument_reaches_bringup(describe):
    given = {name: f"{name}_value" for name in WORDS} | dict.fromkeys(SWITCHES, "true")
    (only,) = launch_stand_in.launched(describe(), given).processes
    options = only.cmd[len(node_command("bringup")) :]
    for name in WORDS:
        assert options[options.index(f"--{name}") + 1] == f"{name}_value"
    assert {f"--{name}" for name in SWITCHES} <= set(options)
    assert len(options) == 2 * len(WORDS) + len(SWITCHES)


def test_a_switch_is_true_or_false(describe):
    with pytest.raises(RuntimeError, match="composed"):
        launch_stand_in.launched(describe(), {"composed": "perhaps"})


@pytest.mark.parametrize("view", ["true", "false"])
def test_rviz_comes_with_its_layout_and_somebody_who_publishes_for_it(describe, view):
    given = {"rviz": "true", "view": view, "namespace": "one"}
    bringup, rviz, *displays = launch_stand_in.launched(describe(), given).processes
    assert "--namespace" in bringup.cmd
    assert rviz.cmd[:2] == ["rviz2", "-d"]
    assert rviz.cmd[2] == str(share_path("config/rviz/follower.rviz"))
    assert rviz.cmd[-1] == "__ns:=/one"
    assert len(displays) == (view == "false")
    assert all("page:=false" in process.cmd for process in displays)


def test_the_process_it_starts_runs(describe, tmp_path):
    given = {"leader": "none", "duration": "0.2", "bag": "none", "composed": "true"}
    context = launch_stand_in.launched(describe(), given)
    done = launch_stand_in.run(context.processes[0], context, cwd=tmp_path, env=environment())
    assert done.returncode == 0, done.stderr
    assert "simulated time" in done.stdout
    assert context.shutdown == "the run is over"


@pytest.mark.skipif(
    get_launch_description_from_python_launch_file is None, reason="ROS 2's launch is not installed"
)
def test_the_real_launch_takes_it():
    description = get_launch_description_from_python_launch_file(FILE)
    arguments = {argument.name for argument in description.get_launch_arguments()}
    assert arguments == {*WORDS, *SWITCHES, "rviz"}
