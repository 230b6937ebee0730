"""Nodes of one bringup hear one another by lines; everybody else, and the bag, must not notice."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest
from graph_bench import PATIENCE, bringup, change_state, node, run, run_script, wait_until
from mcap.reader import make_reader

from follower_humanoid.bag.reader import read_run

PULL = "- {until: 10, right: [3, 0, 0]}\n"
TICK_NS = 2_000_000


@pytest.fixture
def place(tmp_path):
    (tmp_path / "pull.yaml").write_text(PULL)
    return tmp_path


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_the_leaders_wrenches_are_in_the_bag_under_another_name_too(place, placement):
    options = ("--leader", "pull.yaml", "--duration", "0.4", "--bag", str(place / "bag"), *placement)
    ended = run(place, *options, "--ros-args", "-r", "leader/right_hand/wrench:=pulled")
    assert ended.process.returncode == 0, ended.complained
    (file,) = (place / "bag").glob("*.mcap")
    with file.open("rb") as stream:
        statistics = make_reader(stream).get_summary()
        counts = {
            channel.topic: statistics.statistics.channel_message_counts.get(number, 0)
            for number, channel in statistics.channels.items()
        }
    assert counts["/pulled"] >= 41
    assert counts["/pulled"] == counts["/leader/left_hand/wrench"]


LISTENER = """
import rclpy
from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import UInt8MultiArray
rclpy.init()
node = rclpy.create_node("listener")
heard = set()
def hear(kind, topic):
    node.create_subscription(kind, topic, lambda _: heard.add(topic), 10)
hear(WrenchStamped, "leader/right_hand/wrench")
hear(WrenchStamped, "left_hand/wrench")
for name in ("simulator", "leader", "motion_composition"):
    hear(UInt8MultiArray, "graph/" + name)
while len(heard) < 5:
    rclpy.spin_once(node, timeout_sec=0.5)
"""


@pytest.mark.parametrize("recording", [True, False])
def test_a_stranger_hears_what_the_nodes_tell_one_another(place, recording):
    bag = str(place / "bag") if recording else "none"
    with bringup(place, "--leader", "pull.yaml", "--duration", "600", "--bag", bag) as running:
        running.wait_until_it_runs()
        run_script(LISTENER, running.environment)
        running.end()


def test_a_recorder_that_was_halted_at_the_end_has_everything(place):
    bag = place / "bag"
    options = ("--leader", "none", "--duration", "3", "--realtime", "--bag", str(bag))
    with bringup(place, *options) as running:
        running.wait_until_it_runs()
        os.kill(running.child("recorder"), signal.SIGSTOP)
        assert running.wait() == 0, running.complained
    run_of_bag = read_run(bag)
    assert run_of_bag.notes == ()
    np.testing.assert_array_equal(run_of_bag["joint_states"].stamps, TICK_NS * np.arange(1501))
    assert {run_of_bag[topic].ticks[-1] for topic in ("legs/command", "arms/command", "zmp")} == {1500}


def test_a_node_started_by_hand_is_heard_although_the_recorder_leaves(place):
    options = ("--leader", "none", "--duration", "600", "--bag", str(place / "bag"))
    with bringup(place, *options, "--without", "leg_controller") as running:
        by_hand = node("leg_controller", running.environment)
        try:
            running.wait_until_it_runs()
            change_state("recorder", running.environment, "deactivate", "cleanup")
            told = running.said
            assert wait_until(lambda: running.said.count("t = ") > told.count("t = ") + 3)
            running.end()
            assert running.process.returncode == 0, running.complained
            times = [float(line.split()[2]) for line in running.said.splitlines() if line.startswith("t = ")]
            assert times[-1] > times[-2] > times[-3]
        finally:
            by_hand.terminate()
            by_hand.wait(PATIENCE)
