"""Quality of service as rosbag2 writes it: words, and infinite durations as it spells them."""

from __future__ import annotations

from typing import Any

import yaml

# What rmw reports for "no deadline", "lives for ever".
_INFINITE = {"sec": 9223372036, "nsec": 854775807}


def offered_qos(
    reliability: str = "reliable", durability: str = "volatile", depth: int = 10
) -> dict[str, Any]:
    """One offered profile of metadata version 9.

    Args:
        reliability: `reliable` or `best_effort`.
        durability: `volatile` or `transient_local`.
        depth: Messages kept.
    """
    return {
        "history": "keep_last",
        "depth": depth,
        "reliability": reliability,
        "durability": durability,
        "deadline": dict(_INFINITE),
        "lifespan": dict(_INFINITE),
        "liveliness": "automatic",
        "liveliness_lease_duration": dict(_INFINITE),
        "avoid_ros_namespace_conventions": False,
    }


class _PlainDumper(yaml.SafeDumper):
    """rosbag2's YAML reader knows no anchors."""

    def ignore_aliases(self, data: Any) -> bool:
        """Writes equal parts out each time."""
        return True


def plain_yaml(value: Any) -> str:
    """Block-style YAML in the given order, without anchors."""
    return yaml.dump(value, Dumper=_PlainDumper, sort_keys=False, allow_unicode=True, width=1000)
