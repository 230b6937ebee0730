"""An operator at the lifecycle services: `python -m follower_humanoid.faults.operator NODE WORD...`.

The words are transitions (`deactivate`, `cleanup`, `configure`, `activate`) or a time to wait [s]. Prints a
line per transition; ends with 1 at the first that was refused or not answered.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.node import Node
from rclpy.utilities import try_shutdown

_ANSWER_TIME = 20.0
_TRANSITIONS = {
    "configure": Transition.TRANSITION_CONFIGURE,
    "cleanup": Transition.TRANSITION_CLEANUP,
    "activate": Transition.TRANSITION_ACTIVATE,
    "deactivate": Transition.TRANSITION_DEACTIVATE,
}


def main(args: Sequence[str]) -> int:
    """Asks for one transition after the other."""
    rclpy.init()
    node = Node("operator")
    try:
        client = node.create_client(ChangeState, f"{args[0]}/change_state")
        if not client.wait_for_service(_ANSWER_TIME):
            print(f"{args[0]} has no lifecycle services", flush=True)
            return 1
        for word in args[1:]:
            if word not in _TRANSITIONS:
                time.sleep(float(word))
            elif not _asked(node, client, word):
                print(f"{args[0]} did not {word}", flush=True)
                return 1
            else:
                print(f"{args[0]}: {word}", flush=True)
        return 0
    finally:
        node.destroy_node()
        try_shutdown()


def _asked(node: Node, client: Any, word: str) -> bool:
    request = ChangeState.Request()
    request.transition.id = _TRANSITIONS[word]
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=_ANSWER_TIME)
    return bool(future.done() and future.result().success)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
