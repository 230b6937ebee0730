"""The table of faults, in the order of `docs/reliability.md`."""

from __future__ import annotations

from follower_humanoid.faults.case import Fault
from follower_humanoid.faults.falling import falling
from follower_humanoid.faults.files import hostile_files
from follower_humanoid.faults.limits import beyond_limits
from follower_humanoid.faults.messages import hostile_messages
from follower_humanoid.faults.network import network
from follower_humanoid.faults.nodes import hostile_neighbour, lifecycle, lost_nodes
from follower_humanoid.faults.soak import soak

FAULTS: tuple[Fault, ...] = (
    Fault("messages", hostile_messages),
    Fault("neighbour", hostile_neighbour),
    Fault("nodes", lost_nodes),
    Fault("lifecycle", lifecycle),
    Fault("limits", beyond_limits),
    Fault("falling", falling),
    Fault("network", network),
    Fault("files", hostile_files),
    Fault("soak", soak),
)
