"""Quality of service as bags of all versions of rosbag2 tell it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from follower_humanoid.core.yaml_file import parse_yaml
from follower_humanoid.errors import ConfigurationError

_LEAST_DEPTH = 10
# Bags before metadata version 9 write rmw's numbers in place of words.
_BEST_EFFORT = ("best_effort", 2)
_TRANSIENT_LOCAL = ("transient_local", 1)


@dataclass(frozen=True)
class Offered:
    """What a player offers in the place of the recorded publishers.

    Attributes:
        reliable: Whether lost messages are sent again.
        latched: Whether later subscribers hear the last messages.
        depth: Messages kept.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = _LEAST_DEPTH


def offered_in(text: str) -> Offered:
    """From a channel's `offered_qos_profiles` (YAML); reliable where it says nothing.

    With several publishers, what the most demanding subscriber could have had.
    """
    try:
        profiles = parse_yaml(text, "offered_qos_profiles") or []
    except ConfigurationError:
        profiles = []
    profiles = [p for p in profiles if isinstance(p, dict)] if isinstance(profiles, list) else []
    if not profiles:
        return Offered()
    return Offered(
        reliable=any(p.get("reliability") not in _BEST_EFFORT for p in profiles),
        latched=all(p.get("durability") in _TRANSIENT_LOCAL for p in profiles),
        depth=max(_LEAST_DEPTH, *(_depth(p.get("depth")) for p in profiles)),
    )


def _depth(value: Any) -> int:
    return min(int(value), 10000) if isinstance(value, int) else 0
