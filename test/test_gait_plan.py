"""What the walker plans ahead is what comes: ZMP, footsteps, touchdown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, WalkerBench, always

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.walk_plan import Plan

TURNING = replace(AHEAD, walk_dir=0.35, heading=0.35)


def zmp_along(start: Array, plan: Plan, time: float) -> Array:
    """The planned ZMP so much later."""
    point = start
    for target, duration in plan.zmp:
        goal = point if target is None else target
        if time < duration:
            return np.asarray(point + (goal - point) * time / duration)
        time -= duration
        point = goal
    return point


@pytest.mark.parametrize("stop", [2.1, 4.0, 99.0])
def test_the_zmp_that_is_planned_is_the_one_that_comes(stop: float) -> None:
    bench = WalkerBench()
    plans = []
    for _ in range(round(7.5 / bench.dt)):
        gait = TURNING if bench.time < stop else STAND
        bench.tick(gait)
        if len(bench.history) % 65 == 0 and not bench.time < stop < bench.time + 3.5:
            plans.append((len(bench.history), bench.walker.plan_ahead(gait)))
    assert len(plans) >= 4
    zmp = [tick.zmp for tick in bench.history]
    for number, plan in plans:
        for ahead in (40, 150, 330):
            if number + ahead < len(zmp):
                wanted = zmp_along(zmp[number - 1], plan, ahead * bench.dt)
                np.testing.assert_allclose(zmp[number + ahead - 1], wanted, atol=8e-3)


def test_planned_footsteps_and_times_are_those_taken() -> None:
    bench = WalkerBench()
    gait = TURNING
    bench.run(4.0, always(gait))
    plan, now, taken = bench.walker.plan_ahead(gait), bench.time, len(bench.walker.taken)
    touchdown = sum(duration for _, duration in plan.zmp[: plan.landing])
    bench.run(7.5, always(gait))
    coming = bench.walker.taken[taken:]
    for planned, (foot, _) in zip(plan.footsteps, coming, strict=False):
        assert planned.side is foot.side
        np.testing.assert_allclose([planned.x, planned.y, planned.yaw], [foot.x, foot.y, foot.yaw], atol=1e-9)
    landed = next(tick.time for tick in bench.landings() if tick.time > now)
    assert landed - now == pytest.approx(touchdown, abs=3 * bench.dt)


def test_with_a_standing_plan_there_are_no_steps_to_come() -> None:
    plan = WalkerBench().walker.plan_ahead(STAND)
    assert plan.footsteps == ()
    assert plan.lifting is None
