"""Type support is loaded before nodes are forked."""

import subprocess
import sys

PROGRAM = """
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from follower_humanoid.ros.type_support import load_type_support
kinds = [type(t) for t in (JointState, Trigger, Trigger.Request)]
print([kind._TYPE_SUPPORT is None for kind in kinds])
load_type_support()
print([kind._TYPE_SUPPORT is None for kind in kinds])
"""


def test_types_imported_so_far_are_loaded():
    told = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert told.stdout.splitlines() == ["[True, True, True]", "[False, False, False]"]
