"""Which network the graph uses: by default nobody but this machine can reach it.

`ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST` limits who is looked for, but Fast DDS still listens on every
interface. The profile binds to the loopback interface; the variable, set on top of it, would undo that.
Participants of this machine match all the same, whatever their range.
"""

from __future__ import annotations

import os

from follower_humanoid.resources import share_path

_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_SUBNET = "SUBNET"


def choose_network(open_to_others: bool) -> None:
    """Sets the environment of this process and of those that it starts.

    A Fast DDS profile of the user's own stays as it is.

    Args:
        open_to_others: True where other machines shall reach the graph.
    """
    if any(name in os.environ for name in _PROFILES):
        return
    profile = share_path(f"config/network/{'open' if open_to_others else 'loopback'}.xml")
    os.environ.update(dict.fromkeys(_PROFILES, str(profile)))
    if open_to_others:
        os.environ[_RANGE] = _SUBNET
    else:
        for name in (_RANGE, "ROS_LOCALHOST_ONLY"):
            os.environ.pop(name, None)


def asked_to_be_open() -> bool:
    """Whether the environment says so, for a node that is started alone."""
    return os.environ.get(_RANGE) == _SUBNET
