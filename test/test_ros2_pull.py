"""A person pulls the running graph with `ros2 topic pub`; the run comes out the same again, bit for bit."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import IO

import numpy as np
import pytest
from graph_bench import PATIENCE, beside, free_domain, wait_until

from follower_humanoid.bag.mcap_file import McapFile
from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.writer import About, BagWriter

ENVIRONMENT = {**os.environ, "ROS_DOMAIN_ID": str(free_domain()), "PATH": "/usr/bin:/bin"}
ROS2 = [sys.executable, "-m", "follower_humanoid.ros2_front.main"]
RUN = [*ROS2, "run", "follower_humanoid"]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run in which a person pulls, lets go, and has the robot put back on its feet."""
    folder = tmp_path_factory.mktemp("pull")
    # Not faster than real time, and until all has been done.
    words = ["bringup", "--leader", "none", "--composed", "--realtime", "--bag", str(folder / "bag")]
    pull = [
        "topic", "pub", "-r", "20", "-w", "2", "/leader/left_hand/wrench",
        "geometry_msgs/msg/WrenchStamped", "{wrench: {force: {x: 5.0}}}",
    ]  # fmt: skip
    with beside(start(*RUN, *words)) as bringup, beside(start(*ROS2, *pull)) as person:
        hear(bringup, ["/left_hand/applied", "geometry_msgs/msg/WrenchStamped"], "x: 5.0", folder / "pulled")
        done = reset()
        hear(bringup, ["/clock", "rosgraph_msgs/msg/Clock"], "nanosec: ", folder / "again")
        for process in (person, bringup):
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 0
    assert "success=True" in done.stdout, done.stdout + done.stderr
    return folder / "bag"


def start(*words: str, output: int | IO[str] = subprocess.DEVNULL) -> subprocess.Popen[bytes]:
    return subprocess.Popen(words, env=ENVIRONMENT, stdout=output)


def finish(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words, env=ENVIRONMENT, capture_output=True, text=True, timeout=PATIENCE, check=False
    )


def reset() -> subprocess.CompletedProcess[str]:
    """Asked for again where the service was not found in the time that the command looks for it."""
    for _ in range(5):
        done = finish(*ROS2, "service", "call", "/reset", "std_srvs/srv/Trigger")
        if done.returncode == 0:
            break
    return done


def hear(bringup: subprocess.Popen[bytes], topic: list[str], text: str, heard: Path) -> None:
    """Looks at a topic of the run until 50 messages contain the text: at least a tenth of a second of it."""
    with heard.open("w") as file, beside(start(*ROS2, "topic", "echo", *topic, output=file)) as echo:

        def ended() -> bool:
            return bringup.poll() is not None or echo.poll() is not None

        assert wait_until(lambda: heard.read_text().count(text) >= 50 or ended()), "not heard"
        assert not ended()


def test_the_robot_is_pulled(bag):
    applied = read_run(bag)["left_hand/applied"].force
    assert np.max(applied[:, 0]) == 5.0
    assert not applied[0].any()


def test_the_run_comes_out_the_same_again(bag):
    done = finish(*RUN, "replay", str(bag), "--simulate", "--verify")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "identical to the bag: joint positions of" in done.stdout
    assert "put back on its feet at" in done.stderr


def test_another_robot_ends_with_status_4_and_says_where(bag, tmp_path):
    altered = tmp_path / "altered"
    rewrite(bag, altered)
    done = finish(*RUN, "replay", str(altered), "--verify")
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
