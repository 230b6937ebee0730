"""Services that refuse what they cannot read: by itself, rclpy ends the process over a strange request."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import ParameterType, SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node

from follower_humanoid.errors import FollowerError

Answer = Callable[[Any, Any], Any]
_LONGEST_REASON, _LONGEST_NAME = 200, 60  # characters


class RequestError(FollowerError):
    """A request that cannot be met: names the service and the reason."""

    def __init__(self, service: str, error: Exception) -> None:
        words = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_REASON]
        super().__init__(f"request to {service} refused: {words}")
        self.topic = service


def make_careful(node: Node, refuse: Callable[[Exception], None]) -> None:
    """Wraps every service that a node has so far.

    Args:
        node: Whose services.
        refuse: Told of each request that went wrong.
    """
    for service in node.services:
        untyped: Any = service
        untyped.callback = careful(
            untyped.srv_name, untyped.srv_type, untyped.callback, refuse, node.has_parameter
        )


def careful(
    name: str,
    kind: type,
    answer: Answer,
    refuse: Callable[[Exception], None],
    has_parameter: Callable[[str], bool] = lambda _: True,
) -> Answer:
    """What answers instead: the same, but an error becomes a refusal.

    Args:
        name: Of the service.
        kind: Its type.
        answer: What answers.
        refuse: Told of each error.
        has_parameter: Whether the node has a parameter; no other can be set.
    """

    def answered(request: Any, response: Any) -> Any:
        try:
            for parameter in getattr(request, "parameters", ()):
                if not has_parameter(parameter.name):
                    raise ValueError(f"no parameter '{parameter.name[:_LONGEST_NAME]}'")
                if parameter.value.type == ParameterType.PARAMETER_NOT_SET:
                    raise ValueError(f"{parameter.name} cannot be undeclared")
            return answer(request, response)
        except Exception as error:  # whatever a stranger asks must not end the robot's run
            refused = RequestError(name, error)
            refuse(refused)
            if kind is SetParametersAtomically:
                response.result = SetParametersResult(successful=False, reason=str(refused))
            elif kind is SetParameters:
                response.results = [SetParametersResult(successful=False, reason=str(refused))]
            return response

    def answered_one_by_one(request: Any, response: Any) -> Any:
        """Each parameter counts for itself: one that cannot be read leaves the others as they are."""
        for parameter in request.parameters:
            single = SetParameters.Request(parameters=[parameter])
            response.results.extend(answered(single, SetParameters.Response()).results)
        return response

    return answered_one_by_one if kind is SetParameters else answered
