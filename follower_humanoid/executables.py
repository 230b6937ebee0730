"""The table of executables: `setup.py` installs from it, `ros2 run follower_humanoid NAME` finds them.

An executable NAME is the module `follower_humanoid.nodes.NAME` with a function `main(args=None)`
that returns the exit status. Imports nothing of the package: `setup.py` reads this file on its own.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

EXECUTABLES: tuple[str, ...] = (
    "simulator",
    "wrench_sensing",
    "gait_mapping",
    "motion_composition",
    "zmp_balance",
    "leg_controller",
    "arm_controller",
    "leader",
    "arm_task",
    "recorder",
    "composed",
    "bringup",
    "report",
    "arm_experiment",
    "replay",
    "viewer",
)


def console_script(name: str) -> str:
    """Name of the executable in `bin/`, which it shares with every other package."""
    return f"follower_humanoid_{name}"


def run(file: str) -> None:
    """Runs the executable that a file is named after, and ends the process with its exit status.

    Args:
        file: Path of `lib/follower_humanoid/NAME` or `scripts/exe/NAME`.
    """
    main = importlib.import_module(f"follower_humanoid.nodes.{Path(file).name}").main
    sys.exit(main())
