"""A person pulls the running graph with `ros2 topic pub`; the run comes out the same again, bit for bit."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from graph_bench import free_domain

from follower_humanoid.bag.mcap_file import McapFile
from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.writer import About, BagWriter

ENVIRONMENT = {**os.environ, "ROS_DOMAIN_ID": str(free_domain()), "PATH": "/usr/bin:/bin"}
ROS2 = [sys.executable, "-m", "follower_humanoid.ros2_front.main"]
RUN = [*ROS2, "run", "follower_humanoid"]
DURATION = 5.0  # in real time at most, so that the commands below come before its end


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run in which a person pulls, lets go, and has the robot put back on its feet."""
    folder = tmp_path_factory.mktemp("pull") / "bag"
    words = ["bringup", "--leader", "none", "--composed", "--realtime", "--duration", str(DURATION)]
    words += ["--bag", str(folder)]
    with subprocess.Popen([*RUN, *words], env=ENVIRONMENT, stdout=subprocess.DEVNULL) as bringup:
        pull = [
            *ROS2, "topic", "pub", "-r", "20", "-w", "2", "/leader/left_hand/wrench",
            "geometry_msgs/msg/WrenchStamped", "{wrench: {force: {x: 5.0}}}",
        ]  # fmt: skip
        with subprocess.Popen(pull, env=ENVIRONMENT, stdout=subprocess.DEVNULL) as person:
            wait_for_time(bringup, 0.5)
            reset = [*ROS2, "service", "call", "/reset", "std_srvs/srv/Trigger"]
            done = subprocess.run(reset, env=ENVIRONMENT, capture_output=True, text=True, check=False)
            bringup.wait(200.0)
            person.send_signal(signal.SIGINT)
            assert person.wait(10.0) == 0
    assert "success=True" in done.stdout, done.stdout + done.stderr
    assert bringup.returncode == 0
    return folder


def wait_for_time(bringup: subprocess.Popen[bytes], time_wanted: float) -> None:
    """Looks at the clock until the run has come that far."""
    words = ["topic", "echo", "/clock", "rosgraph_msgs/msg/Clock", "--field", "clock"]
    with subprocess.Popen([*ROS2, *words], env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as clock:
        assert clock.stdout is not None
        seconds = 0.0
        deadline = time.monotonic() + 120.0
        while seconds < time_wanted and bringup.poll() is None and time.monotonic() < deadline:
            name, _, value = clock.stdout.readline().partition(": ")
            if name == "sec":
                seconds = float(value)
            elif name == "nanosec":
                seconds = int(seconds) + float(value) * 1e-9
        clock.terminate()


def test_the_robot_is_pulled(bag):
    applied = read_run(bag)["left_hand/applied"].force
    assert np.max(applied[:, 0]) == 5.0
    assert not applied[0].any()


def test_the_run_comes_out_the_same_again(bag):
    done = subprocess.run(
        [*RUN, "replay", str(bag), "--simulate", "--verify"],
        env=ENVIRONMENT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "identical to the bag: joint positions of" in done.stdout
    assert "put back on its feet at" in done.stderr


def test_another_robot_ends_with_status_4_and_says_where(bag, tmp_path):
    altered = tmp_path / "altered"
    rewrite(bag, altered)
    words = [*RUN, "replay", str(altered), "--verify"]
    done = subprocess.run(words, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert done.returncode == 4, done.stdout + done.stderr
    assert "differs first at tick" in done.stderr
    assert "joint " in done.stderr
    assert "rad apart" in done.stderr


def rewrite(source: Path, target: Path) -> None:
    """The same bag, but of a robot on softer soles."""
    run = read_run(source)
    texts = dict(run.about)
    tick = texts.pop("tick")
    texts["parameters.yaml"] = texts["parameters.yaml"].replace(
        "soles.stiffness: 100000.0", "soles.stiffness: 90000.0"
    )
    assert texts["parameters.yaml"] != run.about["parameters.yaml"]
    file = McapFile(next(source.glob("*.mcap")))
    with BagWriter(target, About(run.urdf, texts, {"tick": tick}), time.time_ns()) as writer:
        channels: dict[int, int] = {}
        for messages in file.chunks():
            for message in messages:
                if message.channel not in channels:
                    info = file.channels[message.channel]
                    channels[message.channel] = writer.add_topic(info.topic, info.type_name, [])
                writer.write(
                    channels[message.channel], message.data, message.received, message.published
                )
