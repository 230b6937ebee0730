"""What a walk is made from and what comes out of it: timing in, plan ahead out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from follower_humanoid.core.config import parameter
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.preview import ZmpLeg


@dataclass(frozen=True)
class WalkerConfig:
    """Timing and the choices between two half-steps."""

    half_step_time: float = parameter(3.1, "nominal half-step time (walk_speed = step_length)", "s", 0.3, 10)
    shortest_half_step: float = parameter(0.5, "no half-step is made faster than this", "s", 0.2, 3)
    swing_height: float = parameter(
        0.05, "nominal height of the swing foot (step_height = 1)", "m", 0.01, 0.2
    )
    freeze: float = parameter(0.8, "share of the swing after which the landing place is kept", "", 0.1, 1)
    stand_forward: float = parameter(0.03, "ZMP of standing ahead of the ankles", "m", -0.05, 0.12)
    stand_time: float = parameter(1.2, "time to bring the ZMP between the feet", "s", 0.2, 5)
    first_transfer: float = parameter(0.9, "shortest double support out of standing", "s", 0.0, 5)
    load_time: float = parameter(0.10, "time over which a foot takes or leaves its load", "s", 0.0, 1)
    hurried_load_time: float = parameter(0.03, "the same while recovering from a push", "s", 0, 1)
    hurried_transfer: float = parameter(
        0.5, "part of its time that a double support takes before a step that must catch", "", 0.1, 1
    )
    early_touchdown: float = parameter(
        0.85, "share of the swing after which contact ends it while recovering", "", 0.5, 1
    )
    patience: float = parameter(0.15, "longest wait of a foot for the DCM, in half-steps", "", 0, 1)
    preview: float = parameter(4.0, "how far ahead the ZMP is planned", "s", 1, 10)
    touchdown_load: float = parameter(30.0, "normal force that counts as contact", "N", 5, 200)


class Plan(NamedTuple):
    """What is to come.

    Attributes:
        zmp: Pieces of the ZMP plan from now on.
        landing: How many of them pass until the next touchdown.
        lift_off: How many of them pass until the next lift-off.
        lifting: The foot that leaves the ground then, where it stands; None when no step follows.
        footsteps: The coming landing poses.
    """

    zmp: list[ZmpLeg]
    landing: int = 0
    lift_off: int = 0
    lifting: FootPose | None = None
    footsteps: tuple[FootPose, ...] = ()
