"""The joint positions of a run are the same bits however it is run: placement, load, pace, recording."""

from __future__ import annotations

import subprocess
import sys

import pytest
from graph_bench import environment

from follower_humanoid.bench.placement import Listener
from follower_humanoid.graph.simulate import TICK, simulate

TICKS = 150
pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def listener():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", environment()["ROS_DOMAIN_ID"])
        made = Listener()
        yield made
        made.close()


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


def joint_hash(listener, *options, **how):
    told = listener.run(TICK, "--leader", "fig4", "--duration", f"{TICK * TICKS:g}", *options, **how)
    return told.values["simulator"]["joint_hash"]


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_without_a_recorder_beside_others_that_want_the_cores(listener, chain, hogs, placement):
    assert joint_hash(listener, *placement) == chain


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_in_real_time(listener, chain, placement):
    assert joint_hash(listener, "--realtime", *placement) == chain


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_with_a_recorder(listener, chain, placement):
    assert joint_hash(listener, *placement, recorded=True) == chain
