"""The motion primitives, by the names the paper gives them."""

from follower_humanoid.gait.primitives.base import ZMP, Primitive, StepContext
from follower_humanoid.gait.primitives.bend import Bend
from follower_humanoid.gait.primitives.incline import Incline
from follower_humanoid.gait.primitives.lean import Lean
from follower_humanoid.gait.primitives.level import Level
from follower_humanoid.gait.primitives.lower import Lower
from follower_humanoid.gait.primitives.stretch import Stretch
from follower_humanoid.gait.primitives.toe import Toe

PRIMITIVES: dict[str, type[Primitive]] = {
    "lean": Lean,
    "incline": Incline,
    "bend": Bend,
    "stretch": Stretch,
    "lower": Lower,
    "level": Level,
    "toe": Toe,
}

__all__ = [
    "PRIMITIVES", "ZMP", "Bend", "Incline", "Lean", "Level", "Lower", "Primitive", "StepContext", "Stretch",
    "Toe",
]  # fmt: skip
