"""The table of faults, in the order of `docs/reliability.md`."""

from __future__ import annotations

from follower_humanoid.faults.case import Fault
from follower_humanoid.faults.files import hostile_files

FAULTS: tuple[Fault, ...] = (Fault("files", hostile_files),)
