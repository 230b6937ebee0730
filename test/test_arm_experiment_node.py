"""The experiments as a user starts them: exit codes, the bag, the same bits as without ROS, live modes."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest
from graph_bench import PATIENCE

from follower_humanoid.arm_experiment.simulate import simulate_arm
from follower_humanoid.bag.reader import read_run
from follower_humanoid.resources import node_command


def start(folder, *args: str) -> subprocess.CompletedProcess[str]:
    command = [*node_command("arm_experiment"), *args]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=PATIENCE)


@pytest.mark.parametrize("name", ["board", "compliance"])
def test_as_nodes_it_is_the_same_bit_for_bit_as_without_ros(tmp_path, name):
    done = start(tmp_path, name, "--duration", "1.3", "--bag", str(tmp_path / "bag"))
    assert done.returncode == 0, done.stderr
    recorded, alone = read_run(tmp_path / "bag"), simulate_arm(name, 1.3)
    assert recorded.notes == ()
    for topic in ("joint_states", "left_hand/wrench", "left_hand/target", "arms/command"):
        once = np.isin(recorded[topic].ticks, alone[topic].ticks)
        for field, values in alone[topic].fields.items():
            np.testing.assert_array_equal(recorded[topic].fields[field][once], values, f"{topic} {field}")
    led = [sample.names[0] for sample in recorded["arms/mode"].samples]
    switched = "left_hand/gravity_compensation" in led
    assert switched == (name == "compliance")
    assert recorded.about["command"].startswith(f"arm_experiment {name}")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("wall",), "board, compliance"),
        (("board", "--speed", "1"), "arm_experiment"),
        (("compliance", "--ros-args", "-p", "arm_task:compliance.target:=[0.9, 0.2, 0.4]"), "out of reach"),
        (("board", "--ros-args", "-p", "arm_task:board.side:=0.5"), "out of reach"),
        (("board", "--ros-args", "-p", "arm_controller:stiffness:=[0.0, 1.0, 1.0]"), "stiffness"),
    ],
)
def test_bad_usage_ends_with_2_and_one_line_and_writes_nothing(tmp_path, args, words):
    done = start(tmp_path, *args)
    assert done.returncode == 2
    assert words in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_report_draws_the_arm(tmp_path):
    from follower_humanoid.pictures.report import make_report

    run = simulate_arm("compliance", 1.3)
    report = make_report([("push", run)], tmp_path)
    assert {file.name for file in report.files} >= {"arm_sticks.png", "hand_force.png", "elbow.png"}
    assert report.notes == ()
    assert not report.has_steps
    assert not (tmp_path / "steps.csv").exists()
    assert "alf-step" not in (tmp_path / "report.html").read_text()
