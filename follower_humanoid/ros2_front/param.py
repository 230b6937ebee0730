"""`ros2 param ...`: through the parameter services that every node has."""

from __future__ import annotations

import argparse
import re
import sys
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import get_parameter_value, parameter_value_to_python

from follower_humanoid.ros2_front.graph import (
    add_discovery_arguments,
    call,
    discover,
    find_node,
    full_name,
    graph_node,
    node_names,
)
from follower_humanoid.ros2_front.messages import plain, yaml_text
from follower_humanoid.ros2_front.verbs import CommandError, Verb

_WORDS = {
    ParameterType.PARAMETER_BOOL: "Boolean value is:",
    ParameterType.PARAMETER_INTEGER: "Integer value is:",
    ParameterType.PARAMETER_DOUBLE: "Double value is:",
    ParameterType.PARAMETER_STRING: "String value is:",
    ParameterType.PARAMETER_BYTE_ARRAY: "Byte values are:",
    ParameterType.PARAMETER_BOOL_ARRAY: "Boolean values are:",
    ParameterType.PARAMETER_INTEGER_ARRAY: "Integer values are:",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "Double values are:",
    ParameterType.PARAMETER_STRING_ARRAY: "String values are:",
}


def _node_argument(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("node_name", help="e.g. /simulator")


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("node_name", nargs="?", help="(default: all nodes)")
    parser.add_argument("--include-hidden-nodes", action="store_true", help="hidden nodes too")
    parser.add_argument("--filter", metavar="REGEX", help="only names that match")
    parser.add_argument("--param-prefixes", nargs="+", default=[], metavar="PREFIX", help="only these")


def _list(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        if args.node_name:
            find_node(node, args.node_name)
            nodes = [full_name(args.node_name)]
        else:
            discover(node, args)
            services = dict(node.get_service_names_and_types())
            nodes = [
                name
                for name in node_names(node, args.include_hidden_nodes)
                if f"{name}/list_parameters" in services  # a node may do without parameter services
            ]
        for name in nodes:
            try:
                listed = _names(node, name, args.param_prefixes)
            except CommandError as error:
                if args.node_name:
                    raise
                print(error, file=sys.stderr)
                continue
            if args.filter:
                listed = [entry for entry in listed if re.search(args.filter, entry)]
            if not args.node_name:
                print(f"{name}:")
            for entry in listed:
                print(f"  {entry}")
    return 0


def _names(node: Node, name: str, prefixes: list[str] | None = None) -> list[str]:
    request = ListParameters.Request(prefixes=prefixes or [])
    return sorted(call(node, ListParameters, f"{name}/list_parameters", request).result.names)


def _values(node: Node, name: str, names: list[str]) -> list[Any]:
    response = call(node, GetParameters, f"{name}/get_parameters", GetParameters.Request(names=names))
    return list(response.values)


def _get_arguments(parser: argparse.ArgumentParser) -> None:
    _node_argument(parser)
    parser.add_argument("parameter_name", help="e.g. ground.friction")
    parser.add_argument("--hide-type", action="store_true", help="only the value")


def _get(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        find_node(node, args.node_name)
        name = full_name(args.node_name)
        values = _values(node, name, [args.parameter_name])
        if not _is_set(values):
            raise _unknown(node, name, args.parameter_name)
        value = _python(values[0])
        print(value if args.hide_type else f"{_WORDS[values[0].type]} {value}")
    return 0


def _is_set(values: list[Any]) -> bool:
    return bool(values) and values[0].type != ParameterType.PARAMETER_NOT_SET


def _unknown(node: Node, name: str, parameter: str) -> CommandError:
    return CommandError(f"{name} has no parameter '{parameter}'; valid: {', '.join(_names(node, name))}")


def _python(value: ParameterValue) -> Any:
    return plain(parameter_value_to_python(value))


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    _node_argument(parser)
    parser.add_argument("parameter_name", help="e.g. ground.friction")
    parser.add_argument("value", help="YAML")


def _set(args: argparse.Namespace) -> int:
    value = get_parameter_value(args.value)
    with graph_node(args) as node:
        find_node(node, args.node_name)
        name = full_name(args.node_name)
        known = _values(node, name, [args.parameter_name])
        # `5` is meant as 5.0 where the parameter is a number with a point.
        if known and known[0].type == ParameterType.PARAMETER_DOUBLE:
            if value.type == ParameterType.PARAMETER_INTEGER:
                number = float(value.integer_value)
                value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=number)
        elif known and known[0].type == ParameterType.PARAMETER_DOUBLE_ARRAY:
            if value.type == ParameterType.PARAMETER_INTEGER_ARRAY:
                numbers = [float(v) for v in value.integer_array_value]
                value = ParameterValue(
                    type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=numbers
                )
        elif known and known[0].type == ParameterType.PARAMETER_STRING:
            value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=args.value)
        request = SetParameters.Request(parameters=[Parameter(name=args.parameter_name, value=value)])
        result = call(node, SetParameters, f"{name}/set_parameters", request).results[0]
        if not result.successful and not _is_set(known):
            raise _unknown(node, name, args.parameter_name)
        if not result.successful:
            raise CommandError(f"Setting parameter failed: {result.reason}")
        print(f"Set parameter successful{f': {result.reason}' if result.reason else ''}")
    return 0


def _dump(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        find_node(node, args.node_name)
        name = full_name(args.node_name)
        names = _names(node, name)
        values = {n: _python(v) for n, v in zip(names, _values(node, name, names), strict=True)}
        print(yaml_text({name: {"ros__parameters": _nested(values)}}), end="")
    return 0


def _nested(values: dict[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *above, last = name.split(".")
        branch = tree
        for part in above:
            branch = branch.setdefault(part, {})
        branch[last] = value
    return tree


def _describe_arguments(parser: argparse.ArgumentParser) -> None:
    _node_argument(parser)
    parser.add_argument("parameter_names", nargs="+", help="e.g. ground.friction")


def _describe(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        find_node(node, args.node_name)
        request = DescribeParameters.Request(names=args.parameter_names)
        response = call(
            node, DescribeParameters, f"{full_name(args.node_name)}/describe_parameters", request
        )
        for descriptor in response.descriptors:
            kind = _WORDS.get(descriptor.type, "not set").split(" value")[0].lower()
            print(f"Parameter name: {descriptor.name}\n  Type: {kind}")
            print(f"  Description: {descriptor.description}\n  Constraints:")
            print(f"    Read only: {str(descriptor.read_only).lower()}")
            for bounds in (*descriptor.floating_point_range, *descriptor.integer_range):
                print(f"    Min value: {bounds.from_value}\n    Max value: {bounds.to_value}")
            if descriptor.additional_constraints:
                print(f"    Additional constraints: {descriptor.additional_constraints}")
    return 0


VERBS = (
    Verb("list", "Names of parameters", _list, _list_arguments),
    Verb("get", "Value of a parameter", _get, _get_arguments),
    Verb("set", "Change a parameter", _set, _set_arguments),
    Verb("describe", "Meaning and range of parameters", _describe, _describe_arguments),
    Verb("dump", "All parameters of a node as YAML", _dump, _node_argument),
)
