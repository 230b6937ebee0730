"""How much the graph costs beside its physics: `benchmark --speed`.

Everything is a ratio to bare physics, measured in the same run: kinds of run take turns, medians count.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from follower_humanoid.bench.check import Check, at_least, at_most
from follower_humanoid.bench.machine import own_lateness
from follower_humanoid.bench.placement import Listener, Placed
from follower_humanoid.bench.spent import Spent, spent_of
from follower_humanoid.bench.tape import Cost, Tape
from follower_humanoid.graph.simulate import TICK, Chain

LEADER = "fig4"
PLACEMENTS: dict[str, tuple[str, ...]] = {"composed": ("--composed",), "one process per node": ()}
_LONGEST_START = {"composed": 3.0, "one process per node": 6.0}
_FACTOR, _RATIO, _RECORDING, _LATENESS = 1.3, 3.0, 1.15, 0.002


@dataclass
class Costs:
    """What was measured, a list entry per repetition.

    Attributes:
        bare, chain: Per tick.
        nodes: Node → CPU per tick of its component in the ROS-free chain [s].
        spent: What the chain's ticks are spent on.
        placed, recorded: Placement → runs without and with a bag.
        paced: Placement → run in real time.
        joint_hash: Of the chain's joint positions.
        own_lateness: Of a loop that computes for half of each tick, in real time, alone on the machine [s].
    """

    bare: list[Cost] = field(default_factory=list)
    chain: list[Cost] = field(default_factory=list)
    nodes: dict[str, list[float]] = field(default_factory=dict)
    spent: list[Spent] = field(default_factory=list)
    placed: dict[str, list[Placed]] = field(default_factory=dict)
    recorded: dict[str, list[Placed]] = field(default_factory=dict)
    paced: dict[str, Placed] = field(default_factory=dict)
    joint_hash: str = ""
    own_lateness: float = 0.0


def measure(seconds: float, repeats: int, say: Callable[[str], None]) -> Costs:
    """Runs everything. Args: simulated time of a run [s], how often, and where to tell of the progress."""
    ticks = round(seconds / TICK)
    costs = Costs()
    say("recording the torques and forces of the fig. 4 run")
    tape = Tape(LEADER, ticks, TICK)
    options = ("--leader", LEADER, "--duration", f"{seconds:g}")
    listener = Listener()
    try:
        for turn in range(repeats):
            say(f"turn {turn + 1} of {repeats}")
            costs.bare.append(tape.play())
            costs.chain.append(_run_chain(ticks, costs))
            costs.spent.append(_spent(ticks))
            for name, placement in PLACEMENTS.items():
                placed = listener.run(TICK, *options, *placement)
                costs.placed.setdefault(name, []).append(placed)
                recorded = listener.run(TICK, *options, *placement, recorded=True)
                costs.recorded.setdefault(name, []).append(recorded)
        say("in real time")
        for name, placement in PLACEMENTS.items():
            costs.paced[name] = listener.run(TICK, *options, "--realtime", *placement)
        costs.own_lateness = own_lateness(TICK, 0.5, ticks)
    finally:
        listener.close()
    return costs


def _run_chain(ticks: int, costs: Costs) -> Cost:
    """The ROS-free chain, with a clock around every component."""
    chain = Chain({"leader": {"programme": LEADER}}, TICK)
    spent = dict.fromkeys(chain.components, 0.0)
    for name, component in chain.components.items():
        for method in ("step", "advance"):
            if hasattr(component, method):
                setattr(component, method, _clocked(name, getattr(component, method), spent))
    try:
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(ticks):
            chain.advance()
        cost = Cost((time.perf_counter() - wall) / ticks, (time.process_time() - cpu) / ticks)
        chain.advance()  # a run of the graph ends with one more state
        costs.joint_hash = chain.finish().joint_hash()
    finally:
        chain.close()
    for name, seconds in spent.items():
        costs.nodes.setdefault(name, []).append(seconds / ticks)
    return cost


def _spent(ticks: int) -> Spent:
    chain = Chain({"leader": {"programme": LEADER}}, TICK)
    try:
        return spent_of(chain, ticks)
    finally:
        chain.close()


def _clocked(name: str, call: Callable[..., Any], spent: dict[str, float]) -> Callable[..., Any]:
    def clocked(*arguments: Any) -> Any:
        before = time.process_time()
        try:
            return call(*arguments)
        finally:
            spent[name] += time.process_time() - before

    return clocked


def checks(costs: Costs) -> Iterator[Check]:
    """Required against measured."""
    bare = median(cost.wall for cost in costs.bare)
    for name, runs in costs.placed.items():
        wall = median(run.wall for run in runs)
        yield at_most(f"{name}: wall time per tick, bare physics = 1", wall / bare, _RATIO)
        yield at_least(f"{name}: real-time factor", TICK / wall, _FACTOR)
        recorded = median(run.wall for run in costs.recorded[name])
        yield at_most(f"{name}: with recording, without = 1", recorded / wall, _RECORDING)
        start = median(run.start_up for run in runs)
        yield at_most(f"{name}: start to first tick", start, _LONGEST_START[name], "s")
        late = costs.paced[name].simulator("lateness_p99 [s]")
        yield at_most(f"{name}: lateness of 99 % of ticks in real time", late, _LATENESS, "ms", 1e3)
    for name, runs in costs.placed.items():
        every = [*runs, *costs.recorded[name], costs.paced[name]]
        same = all(run.values["simulator"]["joint_hash"] == costs.joint_hash for run in every)
        words = f"{len(every)} runs, {'identical' if same else 'different'}"
        yield Check(f"{name}: joint positions and ROS-free chain", "identical bit for bit", words, same)


def as_numbers(costs: Costs) -> dict[str, Any]:
    """Everything for the JSON file, in SI units; medians over the repetitions."""
    bare = median(cost.wall for cost in costs.bare)
    rows = {
        "bare physics": _row(bare, bare, median(cost.cpu for cost in costs.bare)),
        "simulate": _row(median(c.wall for c in costs.chain), bare, median(c.cpu for c in costs.chain)),
    }
    for name, runs in costs.placed.items():
        rows[name] = _row(median(r.wall for r in runs), bare, median(r.total_cpu for r in runs))
        rows[name] |= {
            "start_up": median(r.start_up for r in runs),
            "tick_p50": median(r.simulator("tick_time_p50 [s]") for r in runs),
            "tick_p99": median(r.simulator("tick_time_p99 [s]") for r in runs),
            "memory": runs[-1].memory,
            "messaging": messaging_share(runs, costs.nodes),
        }
    return {
        "rows": rows, "nodes": node_table(costs), "spent": spent_table(costs),
        "machine": {"lateness_p99": costs.own_lateness},
    }  # fmt: skip


def _row(wall: float, bare: float, cpu: float) -> dict[str, Any]:
    return {"wall": wall, "ratio": wall / bare, "cpu": cpu}


def messaging_share(runs: list[Placed], nodes: Mapping[str, list[float]]) -> float:
    """Part of the CPU that is not spent in the components, 0…1."""
    maths = sum(median(spent) for spent in nodes.values())
    return 1.0 - maths / median(run.total_cpu for run in runs)


def node_table(costs: Costs) -> dict[str, dict[str, float]]:
    """Node → CPU per tick of its component alone, and of its whole process [s]."""
    runs = costs.placed["one process per node"]
    return {
        name: {"component": median(spent), "process": median(run.cpu.get(name, 0.0) for run in runs)}
        for name, spent in costs.nodes.items()
    }


def spent_table(costs: Costs) -> dict[str, float]:
    """Part of the chain → wall time per tick [s]."""
    runs = [spent.parts() for spent in costs.spent]
    return {part: median(run[part] for run in runs) for part in runs[0]}


def table(costs: Costs) -> str:
    """For the eye: µs per tick."""
    numbers = as_numbers(costs)
    lines = [f"  {'':<24}{'wall µs':>9}{'CPU µs':>9}{'× bare':>8}{'p50 µs':>9}{'p99 µs':>9}{'messaging':>11}"]
    for name, row in numbers["rows"].items():
        line = f"  {name:<24}{row['wall'] * 1e6:>9.0f}{row['cpu'] * 1e6:>9.0f}{row['ratio']:>8.2f}"
        if "messaging" in row:
            line += f"{row['tick_p50'] * 1e6:>9.0f}{row['tick_p99'] * 1e6:>9.0f}{row['messaging']:>11.0%}"
        lines.append(line)
    lines.append(f"\n  {'CPU µs per tick':<24}{'component':>10}{'process':>9}{'memory MB':>11}")
    memory = numbers["rows"]["one process per node"]["memory"]
    for name, row in numbers["nodes"].items():
        size = memory.get(name, 0) / 1e6
        lines.append(f"  {name:<24}{row['component'] * 1e6:>10.0f}{row['process'] * 1e6:>9.0f}{size:>11.0f}")
    composed = numbers["rows"]["composed"]["memory"].get("composed", 0) / 1e6
    lines.append(f"  {'composed':<24}{'':>10}{'':>9}{composed:>11.0f}")
    bare = numbers["rows"]["bare physics"]["wall"]
    parts = (f"{part} {wall * 1e6:.0f} ({wall / bare:.1f} × bare)" for part, wall in numbers["spent"].items())
    lines.append(f"\n  what simulate spends its wall µs on: {', '.join(parts)}")
    late = numbers["machine"]["lateness_p99"] * 1e3
    lines.append(f"  a loop that only computes for half of each tick is late by {late:.1f} ms (99 %)")
    return "\n".join(lines)
