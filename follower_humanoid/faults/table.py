"""The table of faults, in the order of `docs/reliability.md`."""

from __future__ import annotations

from follower_humanoid.faults.case import Fault
from follower_humanoid.faults.cycles import cycles
from follower_humanoid.faults.falling import falling
from follower_humanoid.faults.files import hostile_files
from follower_humanoid.faults.floods import hostile_neighbour
from follower_humanoid.faults.lifecycle import lifecycle
from follower_humanoid.faults.limits import beyond_limits
from follower_humanoid.faults.messages import hostile_messages
from follower_humanoid.faults.network import network
from follower_humanoid.faults.nodes import lost_nodes
from follower_humanoid.faults.side_by_side import side_by_side
from follower_humanoid.faults.soak import soak

FAULTS: tuple[Fault, ...] = (
    Fault("messages", hostile_messages),
    Fault("neighbour", hostile_neighbour),
    Fault("nodes", lost_nodes),
    Fault("cycles", cycles),
    Fault("lifecycle", lifecycle),
    Fault("limits", beyond_limits),
    Fault("falling", falling),
    Fault("network", network),
    Fault("files", hostile_files),
    Fault("side-by-side", side_by_side),
    Fault("soak", soak),
)
