"""Every controller is taken out and brought back by an operator while the robot stands."""

from __future__ import annotations

from collections.abc import Iterator

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import graph_run
from follower_humanoid.faults.nodes import CONTROLLERS

_CYCLE = "deactivate 0.3 activate 0.3 deactivate cleanup 0.3 configure activate 0.3".split()
_UPRIGHT = 0.8  # height of base_link [m]


def lifecycle(effort: Effort) -> Iterator[Check]:
    """A line per controller, in one process per node and, in the long form, all in one."""
    for options in ((), ("--composed",))[: effort.count(1, 2)]:
        where = " (one process)" if options else ""
        with graph_run("--leader", "none", *options) as run:
            started = run.reaches(0.3)
            for name in CONTROLLERS if started else ():
                done = run.operate(name, *_CYCLE)
                good = done.returncode == 0 and not run.over
                observed = "stands" if good else (done.stdout + done.stderr).strip()[-200:] or run.said[-200:]
                yield survived(f"lifecycle of {name}{where}", "each transition, stands", observed, good)
            refused = run.operate("gait_mapping", "configure").returncode != 0 and not run.over
            yield survived(f"a transition that is not possible{where}", "refused", str(refused), refused)
            run.end()
            status, bag = run.status(), run.recorded()
        height = 0.0 if bag is None else float(bag["odom"].position[-1, 2])
        observed = f"status {status}, base_link at {height:.2f} m" if started else "did not start"
        good = started and status == 0 and height > _UPRIGHT
        yield survived(f"after all of this{where}", "upright, status 0", observed, good)
