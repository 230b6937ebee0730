"""Where the joints go when nothing disturbs them: without ROS, in this process."""

from __future__ import annotations

import hashlib
from functools import cache

from follower_humanoid.core.samples import Array
from follower_humanoid.graph.simulate import TICK, simulate


def hash_alone(leader: str, seconds: float) -> str:
    """SHA-256 over all joint positions from time 0 to a time [s], as `Run.joint_hash` has it of a bag."""
    return hash_of(joints_alone(leader, seconds), seconds)


@cache
def joints_alone(leader: str, seconds: float) -> Array:
    """Joint positions from time 0 to a time [s], shape (ticks, joints) [rad]."""
    states = round(seconds / TICK) + 1
    return simulate(leader, states * TICK)["joint_states"].position[:states]


def hash_of(joints: Array, seconds: float) -> str:
    """SHA-256 over joint positions [rad] up to a time [s]."""
    return hashlib.sha256(joints[: round(seconds / TICK) + 1].astype("<f8").tobytes()).hexdigest()
