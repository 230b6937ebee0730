"""A heading beyond ±π: the swing foot turns the short way."""

from __future__ import annotations

from dataclasses import replace

import pytest
from gait_bench import AHEAD, WalkerBench

from follower_humanoid.gait.feet import wrap_angle


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_turning_across_pi_the_foot_turns_the_short_way(sign: float) -> None:
    bench = WalkerBench()
    fastest = 0.0
    for _ in range(9000):
        turn = wrap_angle(sign * min(0.09 * bench.time, 3.5))
        tick = bench.tick(replace(AHEAD, walk_dir=turn, heading=turn))
        if tick.landed is not None:
            foot = bench.walker.feet[tick.landed]
            bench.walker.anchor(tick.landed, replace(foot, yaw=wrap_angle(foot.yaw)))  # as measured: atan2
        half = bench.walker.half_step
        if half is not None:
            fastest = max(fastest, abs(float(half.swing.attitude.velocity[0])))
    assert fastest < 0.6
