"""The control tick of a run, looked at before anything is started."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.graph_config import GraphConfig
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.plant.physics_steps import physics_steps


def check_ticks(parameters: Mapping[str, Mapping[str, Any]], nodes: Iterable[str], where: str) -> None:
    """One tick for all nodes, a whole number of physics steps.

    Args:
        parameters: Node → dotted name → value.
        nodes: Those that run.
        where: What has set the parameters.

    Raises:
        ConfigurationError: Nodes would count different ticks, or the physics cannot keep theirs.
    """
    ticks = {name: parameters.get(name, {}).get("tick", GraphConfig.tick) for name in nodes}
    if not ticks:
        return
    common = Counter(ticks.values()).most_common(1)[0][0]
    for name, tick in ticks.items():
        if tick != common:
            raise ConfigurationError(
                f"{where}: {name}: tick = {tick} s: valid: one for all nodes, as the {common} s of the others"
            )
    step = parameters.get(SIMULATOR, {}).get("physics_step")
    if SIMULATOR not in ticks or step is None:
        return
    try:
        physics_steps(common, step)
    except ConfigurationError as error:
        raise ConfigurationError(f"{where}: {SIMULATOR}: {error}") from None
