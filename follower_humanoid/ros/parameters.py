"""ROS parameters made from configuration dataclasses: name, type, meaning, unit and range in one place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from follower_humanoid.core.config import ParameterInfo, build, parameters_of
from follower_humanoid.errors import ConfigurationError

ConfigT = TypeVar("ConfigT")
_UNBOUNDED = 1.7e308


def descriptor_of(info: ParameterInfo, read_only: bool) -> ParameterDescriptor:
    """What `ros2 param describe` shows."""
    unit = f" [{info.unit}]" if info.unit else ""
    descriptor = ParameterDescriptor(name=info.name, description=info.meaning + unit, read_only=read_only)
    if info.choices:
        descriptor.additional_constraints = "one of: " + ", ".join(info.choices)
    if info.low is None and info.high is None:
        return descriptor
    if isinstance(info.default, tuple):
        descriptor.additional_constraints = f"each {info.low} to {info.high}"
    elif isinstance(info.default, float):
        low = -_UNBOUNDED if info.low is None else float(info.low)
        high = _UNBOUNDED if info.high is None else float(info.high)
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
    else:
        low_int = -(2**63) if info.low is None else int(info.low)
        high_int = 2**63 - 1 if info.high is None else int(info.high)
        descriptor.integer_range = [IntegerRange(from_value=low_int, to_value=high_int, step=1)]
    return descriptor


def declare(node: Node, config_class: type[ConfigT], adjustable: bool = False) -> ConfigT:
    """Declares every parameter of a configuration and returns the configuration.

    Args:
        node: Whose parameters.
        config_class: Dataclass made with `core.config.parameter`.
        adjustable: False makes all of them read-only.

    Raises:
        ConfigurationError: A value given for a parameter cannot be used.
    """
    values = {}
    for info in parameters_of(config_class):
        if node.has_parameter(info.name):  # two configurations of a node may share one
            values[info.name] = node.get_parameter(info.name).value
            continue
        given = _given(node, info)
        values[info.name] = info.checked(given, node.get_name())
        value = values[info.name]
        node.declare_parameter(
            info.name,
            list(value) if isinstance(value, tuple) else value,
            descriptor_of(info, info.read_only or not adjustable),
            ignore_override=True,
        )
    return build(config_class, values, node.get_name())


def _given(node: Node, info: ParameterInfo) -> Any:
    """The value from command line or file, else the default.

    Declared untyped for a moment, since a typed declaration refuses `5` for a number like 5.0 and
    lets nan through.
    """
    default = list(info.default) if isinstance(info.default, tuple) else info.default
    parameter = node.declare_parameter(info.name, default, ParameterDescriptor(dynamic_typing=True))
    node.undeclare_parameter(info.name)
    return parameter.value


class LiveConfig:
    """Lets a running component take over parameters that are not read-only.

    A change is applied all or not at all; a refused one names parameter, value and bound.
    """

    def __init__(self, node: Node, config: Any, apply: Callable[[Any, list[Parameter]], None]) -> None:
        """Args: the node, its component's configuration, and what takes over a new one and what is new."""
        self._config_class = type(config)
        self._node = node
        self._apply = apply
        self._infos: Mapping[str, ParameterInfo] = {info.name: info for info in parameters_of(type(config))}
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take_over)

    def _values(self, changed: list[Parameter]) -> dict[str, Any]:
        values = {name: self._node.get_parameter(name).value for name in self._infos}
        values.update({p.name: p.value for p in changed if p.name in self._infos})
        return values

    def _check(self, changed: list[Parameter]) -> SetParametersResult:
        try:
            build(self._config_class, self._values(changed), self._node.get_name())
        except ConfigurationError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_over(self, changed: list[Parameter]) -> None:
        own = [parameter for parameter in changed if parameter.name in self._infos]
        if own:
            self._apply(build(self._config_class, self._values([])), own)
