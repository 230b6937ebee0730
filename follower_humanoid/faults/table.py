"""The table of faults, in the order of `docs/reliability.md`."""

from __future__ import annotations

from follower_humanoid.faults.case import Fault
from follower_humanoid.faults.falling import falling
from follower_humanoid.faults.files import hostile_files
from follower_humanoid.faults.limits import beyond_limits
from follower_humanoid.faults.messages import hostile_messages

FAULTS: tuple[Fault, ...] = (
    Fault("messages", hostile_messages),
    Fault("limits", beyond_limits),
    Fault("falling", falling),
    Fault("files", hostile_files),
)
