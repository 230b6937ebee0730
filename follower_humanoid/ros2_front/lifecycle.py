"""`ros2 lifecycle ...`."""

from __future__ import annotations

import argparse

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from rclpy.node import Node

from follower_humanoid.ros2_front.graph import (
    add_discovery_arguments,
    call,
    discover,
    find_node,
    full_name,
    graph_node,
    wait_for,
)
from follower_humanoid.ros2_front.verbs import CommandError, Verb

_SERVICE = "/get_state"


def _lifecycle_nodes(node: Node) -> list[str]:
    return sorted(
        name.removesuffix(_SERVICE)
        for name, types in node.get_service_names_and_types()
        if name.endswith(_SERVICE) and "lifecycle_msgs/srv/GetState" in types
    )


def _known(node: Node, name: str) -> str:
    find_node(node, name)
    wanted = full_name(name)
    if wait_for(lambda: wanted if wanted in _lifecycle_nodes(node) else None, 2.0) is None:
        listed = ", ".join(_lifecycle_nodes(node)) or "none"
        raise CommandError(f"'{wanted}' is no lifecycle node; there are: {listed}")
    return wanted


def _nodes(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        discover(node, args)
        for name in _lifecycle_nodes(node):
            print(name)
    return 0


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("node_name", help="e.g. /simulator")
    parser.add_argument("-a", "--all", action="store_true", help="those of every state, not of this one only")


def _list(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        name = _known(node, args.node_name)
        for entry in _transitions(node, name, args.all):
            print(f"- {entry.transition.label} [{entry.transition.id}]")
            print(f"\tStart: {entry.start_state.label}\n\tGoal: {entry.goal_state.label}")
    return 0


def _transitions(node: Node, name: str, everything: bool = False) -> list[GetAvailableTransitions.Response]:
    service = "get_transition_graph" if everything else "get_available_transitions"
    request = GetAvailableTransitions.Request()
    return list(call(node, GetAvailableTransitions, f"{name}/{service}", request).available_transitions)


def _get_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("node_name", nargs="?", help="(default: all lifecycle nodes)")


def _get(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        if args.node_name:
            names = [_known(node, args.node_name)]
        else:
            discover(node, args)
            names = _lifecycle_nodes(node)
        for name in names:
            state = call(node, GetState, f"{name}/get_state", GetState.Request()).current_state
            print(f"{'' if args.node_name else f'{name}: '}{state.label} [{state.id}]")
    return 0


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("node_name", help="e.g. /recorder")
    parser.add_argument("transition", help="label or number, e.g. deactivate")


def _set(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        name = _known(node, args.node_name)
        available = [entry.transition for entry in _transitions(node, name)]
        chosen = next((t for t in available if args.transition in (t.label, str(t.id))), None)
        if chosen is None:
            valid = ", ".join(f"{t.label} [{t.id}]" for t in available)
            raise CommandError(f"{name}: no transition '{args.transition}' from its state; valid: {valid}")
        request = ChangeState.Request(transition=Transition(id=chosen.id, label=chosen.label))
        if not call(node, ChangeState, f"{name}/change_state", request, 20.0).success:
            raise CommandError("Transitioning failed")
        print("Transitioning successful")
    return 0


VERBS = (
    Verb("nodes", "Names of the lifecycle nodes", _nodes, add_discovery_arguments),
    Verb("list", "Transitions that a node can take", _list, _list_arguments),
    Verb("get", "State of a node", _get, _get_arguments),
    Verb("set", "Take a transition", _set, _set_arguments),
)
