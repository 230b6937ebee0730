"""A hostile operator: impossible parameters, impossible transitions, questions about nothing."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.node import Node

from follower_humanoid.core.config import ParameterInfo
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.node_configs import node_parameters
from follower_humanoid.graph.wiring import NODES

_PER_REQUEST = 20
_QUESTIONS = 3  # an answer can be lost while its writer does not know the new client yet
_DOUBLES = (float("nan"), float("inf"), -float("inf"), 1e300, -1e300, 1.7e308)
_INTEGERS = (2**63 - 1, -(2**63), -1)
_TEXTS = ("", "nan", "x" * 5000, "../../etc/passwd", "\u202e\n", "a\0b")
_NAMES = ("", "nowhere", ".", "motor..resistance", "x" * 5000, "qos_overrides.x", "\n", "use_sim_time.x")
_NO_TRANSITIONS = (0, 8, 9, 77, 255)


def hostile_value(rng: random.Random) -> ParameterValue:
    """Any type, any size."""
    kind = rng.randrange(8)
    many = rng.randrange(6)
    if kind == 0:
        return ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=rng.choice(_DOUBLES))
    if kind == 1:
        return ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=rng.choice(_INTEGERS))
    if kind == 2:
        return ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=rng.choice(_TEXTS))
    if kind == 3:
        values = [rng.choice(_DOUBLES) for _ in range(many)]
        return ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=values)
    if kind == 4:
        texts = [rng.choice(_TEXTS) for _ in range(many)]
        return ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=texts)
    if kind == 5:
        return ParameterValue(type=ParameterType.PARAMETER_BYTE_ARRAY, byte_array_value=[b"\xff"] * many)
    if kind == 6:  # asks to undeclare
        return ParameterValue(type=ParameterType.PARAMETER_NOT_SET)
    return ParameterValue(type=rng.choice((77, 255)), double_value=float("nan"))


def _may_be(info: ParameterInfo, value: ParameterValue) -> bool:
    """Whether a value is one that the parameter may have: those are no fault."""
    kinds = {
        ParameterType.PARAMETER_DOUBLE: "double_value",
        ParameterType.PARAMETER_INTEGER: "integer_value",
        ParameterType.PARAMETER_STRING: "string_value",
        ParameterType.PARAMETER_DOUBLE_ARRAY: "double_array_value",
    }
    if value.type not in kinds:
        return False
    try:
        info.checked(getattr(value, kinds[value.type]))
    except ConfigurationError:
        return False
    return True


class Operator:
    """Troubles every node in turn."""

    def __init__(self, node: Node, wait: Callable[[Any], None], rng: random.Random) -> None:
        """Args: who asks, what waits for an answer, and of all that is random."""
        self._node, self._wait, self._rng = node, wait, rng
        self._infos = {name: node_parameters(name) for name in NODES}
        self._accepted: list[str] = []

    def trouble(self, count: int) -> tuple[int, list[str]]:
        """Sets so many parameters, and asks the rest in between.

        Returns:
            How many orders it gave, and what was obeyed or left without an answer or a reason.
        """
        offered = {service for service, _ in self._node.get_service_names_and_types()}
        names = [name for name in NODES if f"/{name}/set_parameters" in offered]
        if not names:
            return 0, ["nobody offers services"]
        given, number = 0, 0
        while given < count:
            name = names[number % len(names)]
            given += self._set(name, atomically=number % 16 >= 8)
            if number % 40 < len(names):
                given += self._ask(name)
            number += 1
        return given, self._accepted

    def _parameter(self, name: str) -> Parameter:
        rng = self._rng
        infos = self._infos[name]
        while True:
            wanted, value = rng.choice((*infos, *_NAMES)), hostile_value(rng)
            if wanted not in infos or not _may_be(infos[wanted], value):
                return Parameter(name=wanted, value=value)

    def _set(self, name: str, atomically: bool) -> int:
        asked = [self._parameter(name) for _ in range(_PER_REQUEST)]
        if atomically:
            request: Any = SetParametersAtomically.Request(parameters=asked)
            answer = self._call(SetParametersAtomically, f"{name}/set_parameters_atomically", request)
            results = [] if answer is None else [answer.result]
        else:
            request = SetParameters.Request(parameters=asked)
            answer = self._call(SetParameters, f"{name}/set_parameters", request)
            results = [] if answer is None else answer.results
        for parameter, result in zip(asked, results, strict=False):
            if result.successful or not result.reason:
                words = "accepted" if result.successful else "refused without a reason"
                self._accepted.append(f"{name}: {parameter.name[:40]} = {parameter.value} {words}"[:300])
        return len(asked)

    def _ask(self, name: str) -> int:
        change = ChangeState.Request()
        change.transition.id = self._rng.choice(_NO_TRANSITIONS)
        change.transition.label = self._rng.choice(("", "nonsense", "x" * 5000))
        answer = self._call(ChangeState, f"{name}/change_state", change)
        if answer is not None and answer.success:
            self._accepted.append(f"{name}: transition {change.transition.id} accepted")
        names = list(_NAMES)
        self._call(GetParameters, f"{name}/get_parameters", GetParameters.Request(names=names))
        self._call(DescribeParameters, f"{name}/describe_parameters", DescribeParameters.Request(names=names))
        listed = ListParameters.Request(prefixes=names, depth=2**64 - 1)
        self._call(ListParameters, f"{name}/list_parameters", listed)
        return 4

    def _call(self, kind: Any, service: str, request: Any) -> Any:
        client = self._node.create_client(kind, service)
        try:
            if not client.wait_for_service(20.0):
                self._accepted.append(f"{service} is not there")
                return None
            for _ in range(_QUESTIONS):
                future = client.call_async(request)
                self._wait(future)
                if future.done():
                    return future.result()
            self._accepted.append(f"{service} does not answer")
            return None
        finally:
            self._node.destroy_client(client)
