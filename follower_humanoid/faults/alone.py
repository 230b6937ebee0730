"""Where the joints go when nothing disturbs them: without ROS, in this process."""

from __future__ import annotations

import hashlib
from functools import cache

from follower_humanoid.graph.simulate import TICK, simulate


@cache
def hash_alone(leader: str, seconds: float) -> str:
    """SHA-256 over all joint positions from time 0 to a time [s], as `Run.joint_hash` has it of a bag."""
    states = round(seconds / TICK) + 1
    alone = simulate(leader, states * TICK)["joint_states"].position[:states]
    return hashlib.sha256(alone.astype("<f8").tobytes()).hexdigest()
