"""What every test may rely on: set before anything imports numpy or rclpy."""

import os
import random
import tempfile

# One thread each: several processes share two cores, and a sum must not depend on how many joined in.
for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

# Robots of other people, and of another test run on this machine, are not ours to command.
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(1, 100)))
os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp(prefix="follower_humanoid_log_"))
