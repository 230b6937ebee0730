"""Executable: `arm_experiment board|compliance`, an experiment with one arm; `--help` lists the options."""

from __future__ import annotations

import sys

from follower_humanoid.early_stop import stop_at_a_signal
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError


def main(args: list[str] | None = None) -> int:
    """Runs the experiment; returns the exit status."""
    if args is None:  # a program of its own
        stop_at_a_signal()
    try:
        from follower_humanoid.arm_experiment.plan import make_arm_plan

        plan = make_arm_plan(sys.argv[1:] if args is None else args)
        from follower_humanoid.ros.bringup_run import BringupRun

        return BringupRun(plan).run()
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION


if __name__ == "__main__":
    sys.exit(main())
