"""A running graph, standing and walking, beside a hostile neighbour."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from typing import Any

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import GraphRun, graph_run
from follower_humanoid.graph.simulate import TICK, simulate

_PATIENCE = 1800.0  # wall time for a flood [s]
_REJECTED = re.compile(r"\[([\w.]+)\]: message on (\S+) rejected")


def hostile_neighbour(effort: Effort) -> Iterator[Check]:
    """Floods what people can publish, what only nodes should, and the services."""
    for leader in ("none", "fig4")[: effort.count(1, 2)]:
        how = "standing" if leader == "none" else "walking"
        yield _flooded("people", effort.count(2_000, 100_000), leader, f"flood of people's topics, {how}")
        yield _flooded("nodes", effort.count(2_000, 20_000), leader, f"forged internal messages, {how}")
        yield _flooded("services", effort.count(800, 10_000), leader, f"hostile services, {how}")


def _flooded(kind: str, count: int, leader: str, what: str) -> Check:
    required = "goes on, refused, told once a second"
    undisturbed = kind != "people"  # a person may pull a little
    if undisturbed:
        required = "moves bit for bit as without, all refused"
    with graph_run("--leader", leader, "--duration", "10000") as run:
        if not run.reaches(0.3):
            return survived(what, required, f"did not start: {run.said[-200:]}", False)
        told, failure = _flood(run, kind, count)
        went_on = not run.over and run.reaches(run.time + 0.1)
        run.end()
        status = run.status()
        words = run.said
    if failure or not went_on or status:
        return survived(what, required, f"status {status}; {failure or words[-300:]}", False)
    faults = list(told["accepted"])
    reports = told["reports"]
    most = max(Counter(_REJECTED.findall(words)).values(), default=0)
    rejected = sum(int(report.get("rejected_messages", 0)) for report in reports.values())
    if kind != "services" and rejected == 0:
        faults.append("nothing counted")
    if most > told["seconds"] + 3:
        faults.append(f"{most} warnings about one topic")
    if undisturbed and not _moves_as_alone(leader, reports.get("simulator", {})):
        faults.append("moves otherwise")
    observed = f"{told['sent']} sent, {told['rate']:.0f}/s, {rejected} counted, {most} warnings at most"
    return survived(what, required, observed + "".join(f"; {fault}" for fault in faults), not faults)


def _flood(run: GraphRun, kind: str, count: int) -> tuple[dict[str, Any], str]:
    """What the neighbour tells, and what went wrong with it."""
    words = [sys.executable, "-m", "follower_humanoid.faults.neighbour", kind, str(count)]
    done = subprocess.run(
        words, env=run.environment, capture_output=True, text=True, timeout=_PATIENCE, check=False
    )
    if done.returncode:
        return {}, f"the neighbour failed: {done.stderr[-300:]}"
    told: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return told, ""


def _moves_as_alone(leader: str, report: dict[str, str]) -> bool:
    """Whether the joints went, up to a report, where they go without ROS and without a neighbour."""
    states = round(float(report["simulated_time [s]"]) / TICK) + 1
    alone = simulate(leader, states * TICK)["joint_states"].position[:states]
    return hashlib.sha256(alone.astype("<f8").tobytes()).hexdigest() == report["joint_hash"]
