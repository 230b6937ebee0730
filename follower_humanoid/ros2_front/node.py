"""`ros2 node ...`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from follower_humanoid.ros2_front.graph import (
    add_discovery_arguments,
    discover,
    find_node,
    full_name,
    graph_node,
    node_names,
)
from follower_humanoid.ros2_front.verbs import Verb


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("-a", "--all", action="store_true", help="hidden nodes too")
    parser.add_argument("-c", "--count-nodes", action="store_true", help="only how many there are")


def _list(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        discover(node, args)
        names = node_names(node, args.all)
        for line in [len(names)] if args.count_nodes else names:
            print(line)
    return 0


def _info_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("node_name", help="e.g. /simulator")
    parser.add_argument("--include-hidden", action="store_true", help="hidden topics and services too")


def _info(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        name, namespace = find_node(node, args.node_name)
        discover(node, args)
        print(full_name(args.node_name))
        services = node.get_service_names_and_types_by_node(name, namespace)
        clients = node.get_client_names_and_types_by_node(name, namespace)
        for title, ends in (
            ("Subscribers", node.get_subscriber_names_and_types_by_node(name, namespace)),
            ("Publishers", node.get_publisher_names_and_types_by_node(name, namespace)),
            ("Service Servers", services),
            ("Service Clients", clients),
        ):
            _show(title, ends, args.include_hidden)
    return 0


def _show(title: str, ends: Sequence[tuple[str, list[str]]], hidden: bool) -> None:
    print(f"  {title}:")
    for name, types in sorted(ends):
        if hidden or not any(part.startswith("_") for part in name.split("/")):
            print(f"    {name}: {', '.join(types)}")
    print()


VERBS = (
    Verb("list", "Names of the nodes", _list, _list_arguments),
    Verb("info", "Topics and services of a node", _info, _info_arguments),
)
