"""Bringup's own node: leads the others through their lifecycle and listens to their diagnostics."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.task import Future

from follower_humanoid.graph.graph_config import RECORDER, VIEWER
from follower_humanoid.graph.wiring import ARM_TASK, NODES
from follower_humanoid.ros.qos import DIAGNOSTICS
from follower_humanoid.ros.quiet import quiet_stderr

_REPORTING = frozenset({*NODES, ARM_TASK.name, RECORDER, VIEWER})
_ANSWER_TIME = 3.0  # an answer can be lost while its writer does not know us yet [s]
_REACHED = {
    Transition.TRANSITION_CONFIGURE: (State.PRIMARY_STATE_INACTIVE, State.PRIMARY_STATE_ACTIVE),
    Transition.TRANSITION_ACTIVATE: (State.PRIMARY_STATE_ACTIVE,),
}


class _Request:
    """One transition of one node, repeated until it is known to have happened."""

    def __init__(self, director: Director, node: str, transition: int) -> None:
        self.node = node
        self._transition = transition
        self._change, self._get = director.clients_of(node)
        self._future: Any = None
        self._sent_at = 0.0
        self._asking_state = False
        self.done = False

    def advance(self) -> None:
        """Sends, looks for the answer, asks again."""
        if self.done or not self._change.service_is_ready() or not self._get.service_is_ready():
            return
        if self._future is not None and self._future.done():
            self._take(self._future.result())
        elif self._future is None:
            self._send(False)
        elif time.monotonic() - self._sent_at > _ANSWER_TIME:
            self._send(True)

    def _send(self, ask_state: bool) -> None:
        self._sent_at, self._asking_state = time.monotonic(), ask_state
        if ask_state:
            self._future = self._get.call_async(GetState.Request())
        else:
            request = ChangeState.Request()
            request.transition.id = self._transition
            self._future = self._change.call_async(request)

    def _take(self, answer: Any) -> None:
        self._future = None
        if self._asking_state:
            self.done = answer.current_state.id in _REACHED[self._transition]
        elif answer.success:
            self.done = True
        else:  # the node ends itself and says why; until then there is nothing to ask for
            self._sent_at, self._asking_state = time.monotonic(), True
            self._future = Future()


class Director:
    """Lifecycle and diagnostics of the graph.

    Attributes:
        values: Node → key → text, as last reported.
        heard_at: Node → wall time of its last diagnostics (monotonic) [s].
    """

    def __init__(self) -> None:
        """Makes the node; rclpy is running already."""
        self.node = Node("bringup", enable_rosout=False, start_parameter_services=False)
        self.values: dict[str, dict[str, str]] = {}
        self.heard_at: dict[str, float] = {}
        self._namespace = self.node.get_namespace().rstrip("/")
        self._clients: dict[str, tuple[Any, Any]] = {}
        # Everybody's topic: what is no such message must not reach the middleware's own reader.
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, DIAGNOSTICS, raw=True)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self._requests: list[_Request] = []

    @property
    def domain(self) -> int:
        """ROS domain, as rcl reads it from the environment."""
        return int(self.node.context.get_domain_id())

    @property
    def namespace(self) -> str:
        """Namespace of the graph, without a leading slash."""
        return self._namespace.strip("/")

    def clients_of(self, node: str) -> tuple[Any, Any]:
        """Lifecycle clients of a node, made once."""
        if node not in self._clients:
            change = self.node.create_client(ChangeState, f"{node}/change_state")
            get = self.node.create_client(GetState, f"{node}/get_state")
            self._clients[node] = (change, get)
        return self._clients[node]

    def more_than(self, own: int, nodes: Iterable[str]) -> list[str]:
        """Those nodes that run more often than so many times in this namespace."""
        space = self._namespace or "/"
        running = [name for name, where in self.node.get_node_names_and_namespaces() if where == space]
        return [name for name in nodes if running.count(name) > own]

    def begin(self, nodes: Sequence[str], transition: int) -> None:
        """Asks nodes for a transition."""
        self._requests = [_Request(self, node, transition) for node in nodes]

    def unanswered(self) -> list[str]:
        """Nodes that have not made the transition yet; asks on."""
        for request in self._requests:
            request.advance()
        return [request.node for request in self._requests if not request.done]

    def spin(self, seconds: float) -> None:
        """Handles messages for a while."""
        self._executor.spin_until_future_complete(Future(), timeout_sec=seconds)

    def close(self) -> None:
        """Ends the node."""
        self._executor.shutdown()
        self.node.destroy_node()

    def _hear(self, data: bytes) -> None:
        for name, values in reports_in(data, self.node.get_namespace()).items():
            self.values[name] = values
            self.heard_at[name] = time.monotonic()


def reports_in(data: bytes, namespace: str) -> dict[str, dict[str, str]]:
    """What nodes of this package in a namespace say in a message on `/diagnostics`, by node.

    Others use the topic too, and a name is quickly taken twice: the hardware id tells ours apart.
    """
    try:
        with quiet_stderr():
            message = deserialize_message(data, DiagnosticArray)
    except Exception:  # rclpy has no common type for what it cannot read
        return {}
    prefix = f"{namespace.rstrip('/')}/"
    return {
        status.name.removeprefix(prefix): {pair.key: pair.value for pair in status.values}
        for status in message.status
        if status.hardware_id == namespace and status.name.removeprefix(prefix) in _REPORTING
    }
