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
from follower_humanoid.faults.alone import hash_of, joints_alone
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import GraphRun, graph_run
from follower_humanoid.faults.nodes import after_a_miss, end_of, ended_well
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.outcome import SIMULATED_TIME

_PATIENCE = 1800.0  # wall time for a flood [s]
_Flood = tuple[dict[str, Any], list[str]]  # what the neighbour tells, and what went wrong
_REJECTED = re.compile(r"\[([\w.]+)\]: (?:message on|request to) (\S+) re")


def hostile_neighbour(effort: Effort) -> Iterator[Check]:
    """Floods the services, what only nodes should publish, and what people can, one after the other."""
    sizes = {
        "services": effort.count(200, 10_000), "nodes": effort.count(1_000, 20_000),
        "people": effort.count(1_000, 100_000),
    }  # fmt: skip
    for leader, how in (("none", "standing"), ("fig4", "walking"))[: effort.count(1, 2)]:
        with graph_run("--leader", leader, "--duration", "10000") as run:
            started = run.reaches(0.3)
            floods = {kind: _flood(run, kind, count) for kind, count in sizes.items()}
            run.end()
            status, observed = run.status(), end_of(run)
            good = started and status == 0 and ended_well(run)
            observed = f"status {status}, {observed}{after_a_miss(run, good)}"
        yield from _undisturbed(leader, how, floods)
        told, faults = floods["people"]
        what, required = f"flood of people's topics, {how}", "goes on, refused, told once a second"
        yield survived(what, required, _words(told, faults), not faults)
        yield survived(f"after all of this, {how}", "status 0, no orphan, readable bag", observed, good)


def _undisturbed(leader: str, how: str, floods: dict[str, _Flood]) -> Iterator[Check]:
    """Services and forged messages may have no effect: the joints go, bit for bit, where they go without.

    That is computed once the graph has ended, since it takes about as long again.
    """
    without_effect = {"services": "hostile services", "nodes": "forged internal messages"}
    reports = {kind: floods[kind][0]["reports"].get(SIMULATOR, {}) for kind in without_effect}
    until = max((float(report[SIMULATED_TIME]) for report in reports.values() if report), default=0.0)
    alone = joints_alone(leader, until)
    for kind, what in without_effect.items():
        (told, faults), report = floods[kind], reports[kind]
        if not faults and hash_of(alone, float(report[SIMULATED_TIME])) != report["joint_hash"]:
            faults.append("moves otherwise")
        required = "moves bit for bit as without, all refused"
        yield survived(f"{what}, {how}", required, _words(told, faults), not faults)


def _words(told: dict[str, Any], faults: list[str]) -> str:
    words = f"{told['sent']} sent, {told['rate']:.0f}/s, {told['counted']} counted"
    return words + "".join(f"; {fault}" for fault in faults)


def _flood(run: GraphRun, kind: str, count: int) -> _Flood:
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
