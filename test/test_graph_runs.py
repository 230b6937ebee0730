"""Whole runs, as a user starts them: the same bits in every placement, a whole bag, a clear end."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest
from graph_bench import (
    PATIENCE,
    RESET,
    beside,
    bringup,
    node,
    processes_of,
    run,
    run_script,
    script,
    wait_until,
)

from follower_humanoid.bag.reader import read_run
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.graph.wiring import NODES

TICKS = 300
SECONDS = 0.002 * TICKS
PULL = "- {until: 0.1, right: [3, 0, 0]}\n- {until: 10, left: [6, 2, -10], base: [5, 0, 0]}\n"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    (folder / "pull.yaml").write_text(PULL)
    (folder / "shove.yaml").write_text("- {until: 10, base: [600, 0, 0]}\n")
    return folder


def recorded(folder):
    found = read_run(folder)
    assert found.notes == ()
    return found


@pytest.fixture(scope="module")
def separate(place):
    bag = place / "separate"
    ended = run(place, "--leader", "pull.yaml", "--duration", str(SECONDS), "--bag", str(bag))
    assert ended.process.returncode == 0, ended.complained
    return ended, recorded(bag)


def test_the_bag_holds_every_tick(separate):
    _, bag = separate
    np.testing.assert_array_equal(bag["joint_states"].stamps, 2_000_000 * np.arange(TICKS + 1))
    assert set(bag.about) >= {"parameters.yaml", "programme.yaml", "command"}
    assert bag.about["programme.yaml"] == PULL


def test_it_says_how_it_goes_and_what_it_came_to(separate):
    ended, _ = separate
    assert "real-time factor" in ended.said
    assert "ZMP margin" in ended.said
    summary = ended.said.partition("the run came to this:")[2]
    for words in ("simulated time", "0.600 s", "half-steps", "peak voltage", "bag", "separate"):
        assert words in summary


def test_one_process_and_one_per_node_and_no_ros_at_all_agree_bit_for_bit(place, separate):
    bag = place / "composed"
    ended = run(place, "--leader", "pull.yaml", "--duration", str(SECONDS), "--bag", str(bag), "--composed")
    assert ended.process.returncode == 0, ended.complained
    alone = simulate(str(place / "pull.yaml"), SECONDS)
    assert abs(alone["left_hand/applied"].force).max() > 5.0
    for other in (separate[1], recorded(bag)):
        for topic in ("joint_states", "odom", "left_hand/wrench", "legs/command", "arms/command", "zmp"):
            ticks = other[topic].ticks
            once = np.isin(ticks, alone[topic].ticks)
            for name, values in alone[topic].fields.items():
                np.testing.assert_array_equal(other[topic].fields[name][once], values, f"{topic} {name}")
        for topic in ("balance/reference", "motion/reference", "gait"):  # of which the bag keeps a part
            np.testing.assert_array_equal(other[topic].ticks, separate[1][topic].ticks)
        assert other["joint_states"].position[:TICKS].tobytes() == alone["joint_states"].position.tobytes()


def test_each_node_has_a_process_that_carries_its_name_and_ctrl_c_ends_all(place):
    with bringup(place, "--leader", "none", "--bag", str(place / "interrupted")) as running:
        running.wait_until_it_runs()
        words = " ".join(words for _, words in running.children())
        for name in (*NODES, "recorder"):
            assert (f"/{name} " in words) == (name != "leader")
        running.end(signal.SIGINT)
        assert running.process.returncode == 0
        assert running.children() == []
    assert len(recorded(place / "interrupted")["joint_states"]) > 1


def test_sigterm_ends_a_composed_run_too(place):
    with bringup(place, "--composed", "--bag", "none") as running:
        running.wait_until_it_runs()
        running.end(signal.SIGTERM)
        assert running.process.returncode == 0


@pytest.mark.parametrize(("placement", "processes"), [([], len(NODES)), (["--composed"], 1)])
def test_it_can_be_stopped_while_it_starts(place, placement, processes):
    with bringup(place, "--bag", "none", *placement) as running:
        assert wait_until(lambda: len(running.children()) == processes)
        running.end(signal.SIGINT)
        assert running.process.returncode == 0


def test_what_only_the_simulator_finds_wrong_is_told_once_and_sums_up_nothing(place):
    bag = place / "never"
    words = ("--bag", str(bag), "--ros-args", "-p", "simulator:standing.hip_height:=0.95")
    ended = run(place, *words)
    assert ended.process.returncode == 2
    assert "legs cannot reach the ground" in ended.complained
    assert ended.complained.count("\n") == 1
    assert ended.said == ""
    assert not bag.exists()


def test_a_run_that_is_stopped_before_its_first_tick_sums_up_nothing(place):
    bag = place / "waiting"
    with bringup(place, "--without", "arm_controller", "--bag", str(bag)) as running:
        running.wait_for("t = 0.00 s")
        running.end(signal.SIGINT)
        assert running.process.returncode == 0
    assert running.said.splitlines()[-1] == f"no tick was taken; bag: {bag}"
    assert "the run came to this" not in running.said


def test_a_lost_node_is_named(place):
    bag = place / "lost"
    with bringup(place, "--bag", str(bag)) as running:
        running.wait_until_it_runs()
        os.kill(running.child("gait_mapping"), signal.SIGKILL)
        assert running.wait() == 1
        assert "lost: gait_mapping, killed by SIGKILL" in running.complained
    assert len(recorded(bag)["joint_states"]) > 1


def test_a_node_that_hangs_is_named_with_what_it_owes(place):
    with bringup(place, "--bag", "none", "--ros-args", "-p", "watchdog:=4.0") as running:
        running.wait_until_it_runs()
        os.kill(running.child("arm_controller"), signal.SIGSTOP)
        assert running.wait() == 1
        assert "arms/command of tick" in running.complained
        assert "lost: arm_controller" in running.complained


def test_nothing_outlives_a_killed_bringup(place):
    with bringup(place, "--leader", "none", "--bag", str(place / "orphaned")) as running:
        running.wait_until_it_runs()
        running.process.kill()
        assert wait_until(lambda: not processes_of(running.process.pid))
    assert len(recorded(place / "orphaned")["joint_states"]) > 1


def test_a_fall_is_told_and_the_run_ends_a_second_later(place):
    bag = place / "fallen"
    ended = run(place, "--leader", "shove.yaml", "--bag", str(bag), "--composed")
    assert ended.process.returncode == 3
    assert "the robot fell at" in ended.complained
    fell_at = float(ended.complained.partition("the robot fell at ")[2].split()[0])
    assert recorded(bag).duration == pytest.approx(fell_at + 1.0, abs=0.003)


def test_a_namespace_moves_everything(place):
    bag = place / "namespaced"
    ended = run(
        place, "--leader", "pull.yaml", "--duration", "0.1", "--bag", str(bag), "--namespace", "robots/one"
    )
    assert ended.process.returncode == 0, ended.complained
    assert len(recorded(bag)["joint_states"]) == 51


PUSH = """
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.qos import qos_profile_sensor_data
rclpy.init()
node = rclpy.create_node("person")
publisher = node.create_publisher(WrenchStamped, "base/push", qos_profile_sensor_data)
message = WrenchStamped()
message.wrench.force.y = 3.5
felt = 0
def feel(applied):
    global felt
    felt += applied.wrench.force.y == 3.5
node.create_subscription(WrenchStamped, "base/applied", feel, 100)
node.create_timer(0.02, lambda: publisher.publish(message))
while felt < 150:
    rclpy.spin_once(node)
"""


@pytest.mark.parametrize("leader", ["none", "pull.yaml"])
def test_a_person_can_push_the_base(place, leader):
    bag = place / f"pushed_{leader[:4]}"
    # Never faster than real time, and as long as it takes until the two have found each other.
    options = ("--leader", leader, "--duration", "80", "--realtime", "--composed", "--bag", str(bag))
    with bringup(place, *options) as running:
        run_script(PUSH, running.environment)
        running.end()
        assert running.process.returncode == 0, running.complained
    pushed = (recorded(bag)["base/applied"].force == [0.0, 3.5, 0.0]).all(axis=1)
    first = int(np.argmax(pushed))
    assert pushed[first : first + 20].all()  # it stays applied between two messages
    assert pushed.sum() >= 150


GAIT = """
import rclpy
from sensor_msgs.msg import JointState
rclpy.init()
node = rclpy.create_node("joystick")
publisher = node.create_publisher(JointState, "gait", 10)
names = ["walk_speed", "walk_dir", "step_length", "step_height", "heading"]
message = JointState(name=names, position=[1.0, 3.14159, 0.8, 1.0, 0.0])
node.create_timer(0.05, lambda: publisher.publish(message))
seen = []
node.create_subscription(JointState, "motion/reference", lambda sent: seen.append(sent.position), 10)
def moved():
    return seen and max(abs(now - then) for now, then in zip(seen[-1], seen[0])) > 0.05
while not moved():
    rclpy.spin_once(node)
"""


def test_a_joystick_can_take_the_place_of_gait_mapping(place):
    bag = place / "joystick"
    options = ("--leader", "none", "--without", "gait_mapping", "--duration", "80", "--realtime")
    with bringup(place, *options, "--composed", "--bag", str(bag)) as running:
        run_script(GAIT, running.environment)
        running.end()
        assert running.process.returncode == 0, running.complained
    reference = recorded(bag)["motion/reference"].position
    assert np.ptp(reference, axis=0).max() > 0.01  # it moves for the first step


FILTER = """
import time
import rclpy
from nav_msgs.msg import Odometry
rclpy.init()
node = rclpy.create_node("filter")
subscription = node.create_subscription(Odometry, "odom", lambda message: publisher.publish(message), 1000)
# The run begins once this publisher is found: not before the filter and the simulator know each other.
while not subscription.get_publisher_count():
    time.sleep(0.05)
publisher = node.create_publisher(Odometry, "odom_filtered", 1000)
rclpy.spin(node)
"""


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_a_filter_can_be_put_between_two_nodes_by_a_remap(place, separate, placement):
    bag = place / f"filtered{len(placement)}"
    options = ("--leader", "pull.yaml", "--duration", "0.2", "--bag", str(bag), *placement)
    remap = ("--ros-args", "-r", "wrench_sensing:odom:=odom_filtered")
    with bringup(place, *options, *remap) as running, beside(script(FILTER, running.environment)):
        assert running.wait() == 0, running.complained
    ours, theirs = separate[1]["joint_states"].position, recorded(bag)["joint_states"].position
    assert ours[:101].tobytes() == theirs.tobytes()


def test_a_node_of_ours_started_by_hand_takes_its_place_in_the_lock_step(place, separate):
    bag = place / "by_hand"
    arguments = ("--leader", "pull.yaml", "--duration", str(SECONDS), "--without", "arm_controller")
    with bringup(place, *arguments, "--bag", str(bag)) as running:
        assert wait_until(lambda: len(running.children()) == len(NODES))  # the recorder, but not this one
        by_hand = node("arm_controller", running.environment)
        try:
            assert running.wait() == 0, running.complained
            assert by_hand.wait(PATIENCE) == 0  # of itself: it has no part in another run
        finally:
            by_hand.kill()
    ours, theirs = separate[1]["joint_states"].position, recorded(bag)["joint_states"].position
    assert ours.tobytes() == theirs.tobytes()


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_a_reset_begins_everything_anew_while_time_goes_on(place, placement):
    bag = place / f"reset{len(placement)}"
    # Never faster than real time, and as long as it takes until the asker has started; but it waits for whom
    # a busy machine holds up, else the two halves would differ by a missed command.
    patient = place / "patient.yaml"
    patient.write_text("simulator: {ros__parameters: {hold_after: 10.0}}\n")
    options = ("--leader", "none", "--realtime", "--bag", str(bag))
    with bringup(place, *options, "--params", str(patient), *placement) as running:
        running.wait_until_it_runs()
        run_script(RESET, running.environment)
        running.wait_until_time(running.time + 2.0)
        running.end()
        assert running.process.returncode == 0, running.complained
    states = recorded(bag)["joint_states"]
    np.testing.assert_array_equal(states.stamps, 2_000_000 * np.arange(len(states)))
    position = states.position
    again = [tick for tick in range(5, len(position)) if (position[tick] == position[0]).all()]
    assert len(again) == 1
    rest = position[again[0] :]
    both = min(len(rest), again[0])
    assert rest[:both].tobytes() == position[:both].tobytes()
