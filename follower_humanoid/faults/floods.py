"""A running graph, standing and walking, beside a hostile neighbour."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from typing import Any

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.alone import hash_alone
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import GraphRun, graph_run
from follower_humanoid.faults.nodes import end_of, ended_well

_PATIENCE = 1800.0  # wall time for a flood [s]
_REJECTED = re.compile(r"\[([\w.]+)\]: (?:message on|request to) (\S+) re")


def hostile_neighbour(effort: Effort) -> Iterator[Check]:
    """Floods the services, what only nodes should publish, and what people can, one after the other."""
    for leader, how in (("none", "standing"), ("fig4", "walking"))[: effort.count(1, 2)]:
        with graph_run("--leader", leader, "--duration", "10000") as run:
            started = run.reaches(0.3)
            count = effort.count(400, 10_000)
            yield _undisturbed(run, "services", count, leader, f"hostile services, {how}")
            count = effort.count(2_000, 20_000)
            yield _undisturbed(run, "nodes", count, leader, f"forged internal messages, {how}")
            count = effort.count(2_000, 100_000)
            yield _flooded(run, "people", count, f"flood of people's topics, {how}")
            run.end()
            status, observed = run.status(), end_of(run)
            good = started and status == 0 and ended_well(run)
        required = "status 0, no orphan, readable bag"
        yield survived(f"after all of this, {how}", required, f"status {status}, {observed}", good)


def _undisturbed(run: GraphRun, kind: str, count: int, leader: str, what: str) -> Check:
    """Nothing of it may have any effect: the joints go, bit for bit, where they go without a neighbour."""
    required = "moves bit for bit as without, all refused"
    told, faults = _flood(run, kind, count)
    simulator = told["reports"].get("simulator", {})
    if not faults and not _moves_as_alone(leader, simulator):
        faults.append("moves otherwise")
    return survived(what, required, _words(told, faults), not faults)


def _flooded(run: GraphRun, kind: str, count: int, what: str) -> Check:
    told, faults = _flood(run, kind, count)
    return survived(what, "goes on, refused, told once a second", _words(told, faults), not faults)


def _words(told: dict[str, Any], faults: list[str]) -> str:
    words = f"{told['sent']} sent, {told['rate']:.0f}/s, {told['counted']} counted"
    return words + "".join(f"; {fault}" for fault in faults)


def _flood(run: GraphRun, kind: str, count: int) -> tuple[dict[str, Any], list[str]]:
    """What the neighbour tells, and what went wrong."""
    told: dict[str, Any] = {"sent": 0, "rate": 0.0, "seconds": 0.0, "counted": 0, "reports": {}}
    words = [sys.executable, "-m", "follower_humanoid.faults.neighbour", kind, str(count)]
    said_before = len(run.said)
    if run.over:
        return told, ["the graph is not there"]
    done = subprocess.run(
        words, env=run.environment, capture_output=True, text=True, timeout=_PATIENCE, check=False
    )
    if done.returncode:
        return told, [f"the neighbour failed: {done.stderr[-300:]}"]
    told |= json.loads(done.stdout.strip().splitlines()[-1])
    faults = list(told["accepted"])
    told["counted"] = sum(int(report.get("rejected_messages", 0)) for report in told["reports"].values())
    if told["counted"] == 0:
        faults.append("nothing counted")
    most = max(Counter(_REJECTED.findall(run.said[said_before:])).values(), default=0)
    if not 0 < most <= told["seconds"] + 5.0:
        faults.append(f"{most} warnings about one topic in {told['seconds']:.0f} s")
    if not run.reaches(run.time + 0.1):
        faults.append(f"does not go on: {run.said[-200:]}")
    return told, faults


def _moves_as_alone(leader: str, report: dict[str, str]) -> bool:
    """Whether the joints went, up to a report, where they go without ROS and without a neighbour."""
    return hash_alone(leader, float(report["simulated_time [s]"])) == report["joint_hash"]
