"""Executable: `arm_experiment board|compliance`, an experiment with one arm; `--help` lists the options."""

from __future__ import annotations

import sys

from follower_humanoid.arm_experiment.plan import make_arm_plan
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.ros.managed_node import BAD_CONFIGURATION


def main(args: list[str] | None = None) -> int:
    """Runs the experiment; returns the exit status."""
    try:
        plan = make_arm_plan(sys.argv[1:] if args is None else args)
        from follower_humanoid.ros.bringup_run import BringupRun

        return BringupRun(plan).run()
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION


if __name__ == "__main__":
    sys.exit(main())
