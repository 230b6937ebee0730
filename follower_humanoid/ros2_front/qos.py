"""The QoS options of ros2cli."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSPresetProfiles, QoSProfile, ReliabilityPolicy

from follower_humanoid.command_line import count

_RELIABILITY = ("reliable", "best_effort", "system_default")
_DURABILITY = ("volatile", "transient_local", "system_default")
_HISTORY = ("keep_last", "keep_all", "system_default")
DEPTH = 10


def add_qos_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds `--qos-*`."""
    add = parser.add_argument
    profiles = [key.lower() for key in QoSPresetProfiles.__members__]
    add("--qos-profile", choices=profiles, help="a profile by its name")
    add("--qos-depth", type=count, metavar="N", help=f"messages kept (default: {DEPTH})")
    add("--qos-history", choices=_HISTORY, help="how many messages are kept")
    add("--qos-reliability", choices=_RELIABILITY, help="whether lost messages are sent again")
    add("--qos-durability", choices=_DURABILITY, help="whether later subscribers hear earlier messages")


def chosen_profile(args: argparse.Namespace, default: QoSProfile) -> QoSProfile:
    """The profile that the options ask for, laid over a default."""
    base = QoSPresetProfiles[args.qos_profile.upper()].value if args.qos_profile else default
    return QoSProfile(
        history=HistoryPolicy[args.qos_history.upper()] if args.qos_history else base.history,
        depth=base.depth if args.qos_depth is None else args.qos_depth,
        reliability=ReliabilityPolicy[args.qos_reliability.upper()]
        if args.qos_reliability
        else base.reliability,
        durability=DurabilityPolicy[args.qos_durability.upper()] if args.qos_durability else base.durability,
    )


def matching_profile(publishers: Sequence[Any], depth: int) -> QoSProfile:
    """What hears all of the given publishers, and as reliably as all of them can."""
    profiles = [info.qos_profile for info in publishers]
    reliable = all(p.reliability == ReliabilityPolicy.RELIABLE for p in profiles)
    latched = bool(profiles) and all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
