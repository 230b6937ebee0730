"""How control ticks are divided into steps of the physics; free of the physics, so that anybody may ask."""

from __future__ import annotations

import math

from follower_humanoid.errors import ConfigurationError

_WHOLE = 1e-6  # a number of steps this near to a whole one is meant to be it


def physics_steps(tick: float, physics_step: float) -> int:
    """Physics steps in a control tick, 1 at least.

    Args:
        tick: Control tick [s].
        physics_step: Physics step [s], above 0.

    Raises:
        ConfigurationError: The tick is no whole number of physics steps.
    """
    ratio = tick / physics_step
    steps = round(ratio) if math.isfinite(ratio) else 0
    if steps < 1 or abs(ratio - steps) > _WHOLE:
        nearest = f", such as {tick / math.ceil(ratio)} s" if 0.0 < ratio < math.inf else ""
        raise ConfigurationError(
            f"physics_step = {physics_step} s: the control tick of {tick} s must be a whole number of "
            f"physics steps; valid: the tick divided by 1, 2, 3, …{nearest}"
        )
    return steps
