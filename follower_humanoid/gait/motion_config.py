"""Parameters of motion composition, those of its parts included."""

from __future__ import annotations

from dataclasses import dataclass, field

from follower_humanoid.core.config import parameter
from follower_humanoid.gait.capture import CaptureConfig
from follower_humanoid.gait.changes import ChangesConfig
from follower_humanoid.gait.feet import FootstepConfig
from follower_humanoid.gait.limits import GaitLimits
from follower_humanoid.gait.walk_plan import WalkerConfig
from follower_humanoid.gait.whole_body import BodyConfig


@dataclass(frozen=True)
class CompositionConfig:
    """Parameters of motion composition."""

    sequence: str = parameter(
        "", "file with the sequence of primitives; empty: the package's half-step", path=True
    )
    dcm_preview: bool = parameter(True, "the reference DCM knows the ZMP to come; off: it is above the ZMP")
    dcm_convergence: float = parameter(
        4.0, "rate at which the reference DCM joins a changed plan", "1/s", 0.5, 20
    )
    zmp_reach: float = parameter(
        0.03, "largest ZMP shift to join a changed plan, one foot carrying", "m", 0, 0.1
    )
    zmp_reach_double: float = parameter(0.09, "the same, both feet carrying", "m", 0, 0.2)
    recovery_convergence: float = parameter(
        10.0, "the same rate while recovering from a push", "1/s", 0.5, 40
    )
    recovery_reach: float = parameter(
        0.3, "largest ZMP shift asked for while recovering, one foot carrying; the soles' edge cuts it", "m",
        0, 0.5,
    )  # fmt: skip
    recovery_reach_double: float = parameter(0.2, "the same, both feet carrying", "m", 0, 0.5)
    walker: WalkerConfig = field(default_factory=WalkerConfig)
    footsteps: FootstepConfig = field(default_factory=FootstepConfig)
    limits: GaitLimits = field(default_factory=GaitLimits)
    changes: ChangesConfig = field(default_factory=ChangesConfig)
    capture: CaptureConfig = field(default_factory=CaptureConfig)
    body: BodyConfig = field(default_factory=BodyConfig)
