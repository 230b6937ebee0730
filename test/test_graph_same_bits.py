"""The joint positions of a run are the same bits however it is run: placement, load, pace, recording."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from graph_bench import run

from follower_humanoid.graph.simulate import TICK, simulate

TICKS = 150


@pytest.fixture(scope="module")
def chain():
    return simulate("fig4", TICK * (TICKS + 1)).joint_hash()


@pytest.fixture
def hogs():
    """Something else that wants both cores."""
    processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    yield
    for process in processes:
        process.kill()
        process.wait()


def joint_hash(folder, bag, *options):
    ended = run(folder, "--leader", "fig4", "--duration", f"{TICK * TICKS:g}", "--bag", bag, *options)
    assert ended.process.returncode == 0, ended.complained
    return re.findall(r"joint hash: +([0-9a-f]{64})", ended.said)[-1]


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_without_a_recorder_beside_others_that_want_the_cores(tmp_path, chain, hogs, placement):
    assert joint_hash(tmp_path, "none", *placement) == chain


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_in_real_time(tmp_path, chain, placement):
    patient = ("--ros-args", "-p", "simulator:hold_after:=10.0")  # a busy machine may hold a controller up
    assert joint_hash(tmp_path, "none", "--realtime", *placement, *patient) == chain


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_with_a_recorder(tmp_path, chain, placement):
    assert joint_hash(tmp_path, "bag", *placement) == chain
