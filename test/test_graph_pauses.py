"""A simulator that is paused leaves nothing out, and one that is cleaned up ends the run well."""

from __future__ import annotations

import numpy as np
from graph_bench import bringup, run_script

from follower_humanoid.bag.reader import read_run

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
