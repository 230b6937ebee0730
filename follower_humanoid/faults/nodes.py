"""Nodes that are killed, halted or late, in a running graph; starts and stops; the operator's lifecycle."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import PATIENCE, GraphRun, graph_run
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.resources import node_command

CONTROLLERS = tuple(name for name in NODES if name not in ("simulator", "leader"))
_HALT = 2.0  # s
_CYCLE = ("deactivate", "0.3", "activate", "0.3", "deactivate", "cleanup", "configure", "activate", "0.3")
# Standing, and in the middle of a step of fig. 4.
_STANDING, _WALKING = ("--leader", "none"), ("--leader", "fig4")


def lost_nodes(effort: Effort) -> Iterator[Check]:
    """Killed and halted, each node in turn in the long form."""
    brief = effort.brief
    for name in ("wrench_sensing",) if brief else (*NODES, "recorder"):
        for leader, begin in ((_STANDING, 0.3), (_WALKING, 1.5))[: 1 if brief or name == "leader" else 2]:
            yield _killed(name, (_WALKING if name == "leader" else leader), begin)
    for name in ("gait_mapping",) if brief else CONTROLLERS:
        yield _halted(name, _WALKING)
        yield _late(name)
    yield _silent("arm_controller")
    for name in ("leg_controller",) if brief else CONTROLLERS:
        yield _halted_in_real_time(name)
    yield _cycles(effort.count(3, 50))


def hostile_neighbour(effort: Effort) -> Iterator[Check]:
    """Floods a standing and a walking robot with what it cannot use."""
    for leader in (_STANDING, _WALKING)[: effort.count(1, 2)]:
        seconds = str(effort.count(3, 60))
        with graph_run(*leader, "--duration", "20") as run:
            started = run.reaches(0.2)
            words = [sys.executable, "-m", "follower_humanoid.faults.neighbour", seconds]
            done = subprocess.run(
                words, env=run.environment, capture_output=True, text=True, timeout=PATIENCE, check=False
            )
            before = run.time
            went_on = run.over or run.reaches(before + 0.1)
            if not run.over:
                run.end()
            status, warnings = run.status(), run.said.count("rejected")
            good = started and went_on and status == 0 and warnings > 0
            how = "standing" if leader == _STANDING else "walking"
            observed = f"{done.stdout.strip()}; status {status}, {warnings} warnings"
        yield survived(f"flood of unusable wrenches, {how}", "goes on, warnings throttled", observed, good)


def _end_of(run: GraphRun) -> str:
    bag = run.recorded()
    states = 0 if bag is None else len(bag["joint_states"])
    return f"{run.orphans()} orphans, bag with {states} states"


def _ended_well(run: GraphRun) -> bool:
    return run.orphans() == 0 and run.recorded() is not None


def _killed(name: str, options: tuple[str, ...], begin: float) -> Check:
    how = "standing" if options == _STANDING else "walking"
    with graph_run(*options) as run:
        started = run.reaches(begin)
        os.kill(run.child(name), signal.SIGKILL)
        status = run.status()
        named = f"{name}" in run.said and "SIGKILL" in run.said
        bag = name == "recorder" or _ended_well(run)
        good = started and status == 1 and named and run.orphans() == 0 and bag
        observed = f"status {status}, {'named' if named else 'not named'}, {_end_of(run)}"
    return survived(f"SIGKILL to {name}, {how}", "status 1, named, no orphan, readable bag", observed, good)


def _halted(name: str, options: tuple[str, ...]) -> Check:
    with graph_run(*options, "--duration", "3") as run:
        started = run.reaches(0.3)
        _halt(run.child(name), _HALT)
        status = run.status()
        bag = run.recorded()
        whole = bag is not None and not bag.notes
        observed = f"status {status}, bag {'complete' if whole else 'incomplete'}"
    good = started and status == 0 and whole
    return survived(f"SIGSTOP of {name} for {_HALT:g} s", "the world waits, status 0", observed, good)


def _halt(pid: int, seconds: float) -> None:
    os.kill(pid, signal.SIGSTOP)
    time.sleep(seconds)
    os.kill(pid, signal.SIGCONT)


def _late(name: str) -> Check:
    with graph_run(*_WALKING, "--duration", "1", "--without", name) as run:
        time.sleep(_HALT)
        late = subprocess.Popen(node_command(name), env=run.environment, stdout=subprocess.DEVNULL)
        try:
            status = run.status()
        finally:
            late.terminate()
            late.wait(20)
    return survived(f"{name} started 2 s late", "waited for, status 0", f"status {status}", status == 0)


def _silent(name: str) -> Check:
    with graph_run(*_STANDING) as run:
        started = run.reaches(0.3)
        os.kill(run.child(name), signal.SIGSTOP)
        status = run.status()
        told = f"{name}" in run.said and "of tick" in run.said
        good = started and status == 1 and told and _ended_well(run)
        observed = f"status {status}, {'tick and node told' if told else 'not told'}, {_end_of(run)}"
    return survived(f"SIGSTOP of {name} for good", "status 1 after 5 s, tick and node told", observed, good)


def _halted_in_real_time(name: str) -> Check:
    with graph_run(*_STANDING, "--realtime", "--duration", "8") as run:
        started = run.reaches(0.5)
        before = run.time
        _halt(run.child(name), _HALT)
        went_on = run.time > before
        status = run.status()
        good = started and went_on and status == 0
        observed = f"time {'went on' if went_on else 'stood still'}, status {status}"
    return survived(f"SIGSTOP of {name} for 2 s, real time", "drives hold, stays up", observed, good)


def _cycles(count: int) -> Check:
    slowest, faults = 0.0, []
    for number in range(count):
        with graph_run(*_WALKING, *(("--composed",) if number % 2 else ())) as run:
            run.reaches(0.1)
            slowest = max(slowest, run.end(signal.SIGINT if number % 3 else signal.SIGTERM))
            if run.status() != 0 or not _ended_well(run):
                faults.append(f"{number}: status {run.status()}, {_end_of(run)}")
    observed = f"slowest stop {slowest:.1f} s" + "".join(f"; {fault}" for fault in faults[:3])
    return survived(f"{count} starts and stops", "status 0, no orphan, readable bags", observed, not faults)


def lifecycle(effort: Effort) -> Iterator[Check]:
    """Every controller is taken out and brought back by hand while the robot stands."""
    for placement in ((), ("--composed",))[: 1 if effort.brief else 2]:
        with graph_run(*_STANDING, *placement) as run:
            started = run.reaches(0.3)
            for name in CONTROLLERS:
                done = run.operate(name, *_CYCLE)
                good = started and done.returncode == 0 and not run.over
                observed = "stands" if good else (done.stdout + done.stderr).strip()[-200:] or run.said[-200:]
                where = " (one process)" if placement else ""
                yield survived(f"lifecycle of {name}{where}", "each transition, stands", observed, good)
            refused = run.operate("gait_mapping", "configure").returncode != 0 and not run.over
            yield survived("a transition that is not possible", "refused", str(refused), refused)
            run.end()
            status = run.status()
            yield survived("after all of this", "upright, status 0", f"status {status}", status == 0)
