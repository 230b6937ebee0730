"""Composed, the physics has a process of its own: both end together, and nothing else is to be seen of it."""

from __future__ import annotations

import os
import signal
import time
from types import SimpleNamespace

import numpy as np
import pytest
from graph_bench import bringup, run_script, wait_until

from follower_humanoid.bag.reader import read_run
from follower_humanoid.ros.simulator_node import SimulatorNode

TICK_NS = 2_000_000
CHANGE = """
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
rclpy.init()
node = rclpy.create_node("operator")
client = node.create_client(ChangeState, "simulator/change_state")
client.wait_for_service()
for verb in {verbs}:
    request = ChangeState.Request()
    request.transition.id = getattr(Transition, "TRANSITION_" + verb)
    asked = client.call_async(request)
    rclpy.spin_until_future_complete(node, asked)
    assert asked.result().success
"""


def test_the_nodes_do_not_outlive_the_physics(tmp_path):
    bag = tmp_path / "bag"
    with bringup(tmp_path, "--composed", "--bag", str(bag)) as running:
        running.wait_until_it_runs()
        os.kill(running.child("physics"), signal.SIGKILL)
        assert running.wait() == 1
        assert "physics" in running.complained
        assert "Traceback" not in running.complained
    assert len(read_run(bag)["joint_states"]) > 1


def test_the_physics_does_not_outlive_the_nodes(tmp_path):
    with bringup(tmp_path, "--composed", "--bag", "none") as running:
        running.wait_until_it_runs()
        os.kill(running.child("composed"), signal.SIGKILL)
        assert running.wait() == 1
        assert "lost: composed" in running.complained
        assert "Traceback" not in running.complained
        assert running.children() == []


def test_physics_that_hangs_ends_the_run(tmp_path):
    with bringup(tmp_path, "--composed", "--bag", "none", "--ros-args", "-p", "watchdog:=4.0") as running:
        running.wait_until_it_runs()
        os.kill(running.child("physics"), signal.SIGSTOP)
        assert running.wait() == 1
        assert "has been silent for 4 s" in running.complained
        assert "Traceback" not in running.complained


def test_one_processor_has_no_use_for_another_process(tmp_path):
    with bringup(tmp_path, "--composed", "--bag", "none", one_processor=True) as running:
        running.wait_until_it_runs()
        assert [words for _, words in running.children() if "/physics " in words] == []
        running.end(signal.SIGINT)
        assert running.process.returncode == 0


def test_without_a_simulator_there_is_no_physics(tmp_path):
    with bringup(tmp_path, "--composed", "--bag", "none", "--without", "simulator") as running:
        assert wait_until(lambda: "waiting for a publisher of /joint_states" in running.complained)
        assert [words for _, words in running.children() if "/physics " in words] == []


def test_a_pause_leaves_no_gap(tmp_path):
    bag = tmp_path / "bag"
    patient = tmp_path / "patient.yaml"
    patient.write_text("simulator: {ros__parameters: {hold_after: 10.0}}\n")
    options = ("--composed", "--leader", "none", "--realtime", "--bag", str(bag), "--params", str(patient))
    with bringup(tmp_path, *options) as running:
        running.wait_until_it_runs()
        run_script(CHANGE.format(verbs=["DEACTIVATE"]), running.environment)
        run_script(CHANGE.format(verbs=["ACTIVATE"]), running.environment)
        running.wait_until_time(running.time + 1.0)
        running.end()
        assert running.process.returncode == 0, running.complained
    states = read_run(bag)["joint_states"]
    np.testing.assert_array_equal(states.stamps, TICK_NS * np.arange(len(states)))


def test_a_simulator_that_is_cleaned_up_ends_the_run_well(tmp_path):
    with bringup(tmp_path, "--composed", "--leader", "none", "--bag", "none") as running:
        running.wait_until_it_runs()
        run_script(CHANGE.format(verbs=["DEACTIVATE", "CLEANUP"]), running.environment)
        assert running.wait() == 0, running.complained
        assert running.complained == ""


@pytest.mark.parametrize(("under_way", "given_up"), [(True, 0), (False, 1)])
def test_commands_are_not_missed_before_their_state_is_out(under_way, given_up):
    asked = []
    lock = SimpleNamespace(ready=False, topics=("legs/command",), give_up_on=lambda t: asked.append(t) or [])
    node = SimpleNamespace(
        run_ready_steps=lambda: None, running=True, started=True, lock=lock, _stepped=time.monotonic() - 9.0,
        _waiting_for_all=False, _under_way=under_way, run=SimpleNamespace(realtime=True, hold_after=0.25),
    )  # fmt: skip
    SimulatorNode._keep_pace(node)
    assert len(asked) == given_up
