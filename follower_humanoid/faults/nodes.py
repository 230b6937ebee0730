"""Nodes that are killed, halted or late, each in turn, while the robot stands and while it walks."""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Iterator

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.alone import hash_alone
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import GraphRun, graph_run, wait_until
from follower_humanoid.graph.graph_config import LEADER, RECORDER
from follower_humanoid.graph.wiring import NODES, SIMULATOR
from follower_humanoid.resources import node_command

CONTROLLERS = tuple(name for name in NODES if name not in (SIMULATOR, LEADER))
_EVERYONE = (*NODES, RECORDER)
_HALT = 2.0  # s
# Simulated, of a run that is disturbed and goes on [s]. What a run says of its time can be two seconds old:
# one that is halted must not have come to its end meanwhile, on a fast machine either.
_SECONDS = 8.0
_LATE_SECONDS = 0.5
# Of bringup, and when to disturb: standing, and in the middle of the first step of fig. 4 [s].
_WAYS = {"standing": (("--leader", "none"), 0.3), "walking": (("--leader", "fig4"), 1.2)}
FELL = 3  # exit status


def lost_nodes(effort: Effort) -> Iterator[Check]:
    """Killed, halted and late: each node in turn in the long form, standing and walking."""
    brief = effort.brief
    for how in ("walking",) if brief else tuple(_WAYS):
        for name in ("wrench_sensing",) if brief else _EVERYONE:
            if name != LEADER or how == "walking":  # standing there is no leader
                yield _killed(name, how)
        for name in ("gait_mapping",) if brief else _EVERYONE:
            if name != LEADER or how == "walking":
                yield _halted(name, how)
                yield _late(name, how)
        for name in ("leg_controller",) if brief else CONTROLLERS:
            yield _halted_in_real_time(name, "standing" if brief else how)
    for name in () if brief else CONTROLLERS:
        yield _started_by_hand(name)
    yield _silent("arm_controller")


def end_of(run: GraphRun) -> str:
    """What is left of a run."""
    bag = run.recorded()
    states = 0 if bag is None else len(bag["joint_states"])
    return f"{run.orphans()} orphans, bag with {states} states"


def after_a_miss(run: GraphRun, good: bool) -> str:
    """What the run said last, where it did not do what it should."""
    return "" if good else f"; said: {run.last_words}"


def ended_well(run: GraphRun) -> bool:
    """Whether nothing is left but a bag that can be read."""
    return run.orphans() == 0 and run.recorded() is not None


def _killed(name: str, how: str) -> Check:
    options, begin = _WAYS[how]
    with graph_run(*options) as run:
        started = run.reaches(begin) and run.send(name, signal.SIGKILL)
        status = run.status() if started else -1
        named = f"{name}" in run.said and "SIGKILL" in run.said
        good = started and status == 1 and named and ended_well(run)
        observed = f"status {status}, {'named' if named else 'not named'}, {end_of(run)}"
        observed += after_a_miss(run, good)
    return survived(f"SIGKILL to {name}, {how}", "status 1, named, no orphan, readable bag", observed, good)


def _same_walk(run: GraphRun, how: str, seconds: float) -> tuple[bool, str]:
    """Whether a run came to its end with a whole bag, having moved as if nothing had been, and in words."""
    status, bag, held = run.status(), run.recorded(), run.held_ticks()
    whole = bag is not None and not bag.notes
    same = bag is not None and bag.joint_hash() == hash_alone(_WAYS[how][0][1], seconds)
    words = f"status {status}, bag {'complete' if whole else 'incomplete'}"
    words += f", moves {'' if same else 'not '}as alone" + (f", held for {held} ticks" if held else "")
    good = status == 0 and whole and same and held == 0
    return good, words + after_a_miss(run, good)


def _halted(name: str, how: str) -> Check:
    options, begin = _WAYS[how]
    with graph_run(*options, "--duration", f"{_SECONDS:g}") as run:
        started = run.reaches(begin) and run.halt(name, _HALT)
        good, observed = _same_walk(run, how, _SECONDS)
        observed += "" if started else ", not halted"
    what = f"SIGSTOP of {name} for {_HALT:g} s, {how}"
    return survived(what, "the world waits, status 0, same motion", observed, started and good)


def _late(name: str, how: str) -> Check:
    options, _ = _WAYS[how]
    with graph_run(*options, "--duration", f"{_LATE_SECONDS:g}") as run:
        found = wait_until(lambda: run.over or run.child(name) is not None)
        held = found and run.halt(name, _HALT)  # before it has begun to be a node
        good, observed = _same_walk(run, how, _LATE_SECONDS)
    return survived(
        f"{name} starts 2 s late, {how}", "waited for, status 0, same motion", observed, held and good
    )


def _started_by_hand(name: str) -> Check:
    options, _ = _WAYS["walking"]
    with graph_run(*options, "--duration", f"{_LATE_SECONDS:g}", "--without", name) as run:
        time.sleep(_HALT)
        late = subprocess.Popen(node_command(name), env=run.environment, stdout=subprocess.DEVNULL)
        try:
            good, observed = _same_walk(run, "walking", _LATE_SECONDS)
        finally:
            late.terminate()
            late.wait(20)
    return survived(f"{name} started 2 s later by hand", "waited for, status 0, same motion", observed, good)


def _silent(name: str) -> Check:
    with graph_run(*_WAYS["standing"][0]) as run:
        started = run.reaches(0.3) and run.send(name, signal.SIGSTOP)
        status = run.status() if started else -1
        told = f"{name}" in run.said and "of tick" in run.said
        good = started and status == 1 and told and ended_well(run)
        observed = f"status {status}, {'tick and node told' if told else 'not told'}, {end_of(run)}"
        observed += after_a_miss(run, good)
    return survived(f"SIGSTOP of {name} for good", "status 1 after 5 s, tick and node told", observed, good)


def _halted_in_real_time(name: str, how: str) -> Check:
    options, begin = _WAYS[how]
    with graph_run(*options, "--realtime", "--duration", "5") as run:
        started = run.reaches(begin) and run.halt(name, _HALT)
        status, pause, held = run.status(), run.longest_pause(), run.held_ticks()
        may_be = (0,) if how == "standing" else (0, FELL)
        # Drives that hold are time that goes on. How long it stood still depends on the machine too.
        good = started and held > 0 and status in may_be and ended_well(run)
        observed = f"held for {held} ticks, longest pause {pause:.2f} s, status {status}, {end_of(run)}"
        observed += after_a_miss(run, good)
    required = "drives hold, stays up" if how == "standing" else "drives hold, may fall, ends well"
    return survived(f"SIGSTOP of {name} for 2 s, real time, {how}", required, observed, good)
