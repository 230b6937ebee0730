"""The same walk through the node graph: how fast, and whether it is the same."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from follower_humanoid.bag.reader import read_run
from follower_humanoid.bench.check import Check, at_least
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.resources import node_command

NAME = "graph"
DURATION = 8.0
COMPARED = 3.0
TIMEOUT = 600.0


def graph_checks() -> Iterator[Check]:
    """Runs fig. 4 with one process per node, without and with a recorder."""
    words = _bringup("--duration", f"{DURATION:g}", "--bag", "none")
    found = re.search(r"real-time factor:\s*([0-9.]+)", words)
    factor = float(found.group(1)) if found else 0.0
    yield at_least("real-time factor, one process per node, 500 Hz", factor, 0.8)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        _bringup("--duration", f"{COMPARED:g}", "--bag", str(bag))
        recorded = read_run(bag)
    ticks = len(recorded["joint_states"])
    direct: Run = simulate("fig4", ticks * recorded.tick)
    same = recorded.joint_hash() == direct.joint_hash()
    words = f"{ticks} ticks, {'identical' if same else 'different'}"
    yield Check("joint positions, graph and ROS-free chain", "identical bit for bit", words, same)


def _bringup(*options: str) -> str:
    """What bringup printed."""
    command = [*node_command("bringup"), "--leader", "fig4", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    return done.stdout + done.stderr
