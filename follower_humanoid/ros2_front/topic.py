"""`ros2 topic ...`: the verbs, and those of them that only look at the graph."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from follower_humanoid.ros2_front import topic_echo, topic_hz, topic_pub
from follower_humanoid.ros2_front.graph import (
    add_discovery_arguments,
    discover,
    full_name,
    graph_node,
    wait_for,
)
from follower_humanoid.ros2_front.verbs import CommandError, Verb


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("-t", "--show-types", action="store_true", help="with the type of each topic")
    parser.add_argument("-c", "--count-topics", action="store_true", help="only how many there are")
    parser.add_argument("-v", "--verbose", action="store_true", help="with publishers and subscribers")
    parser.add_argument("--include-hidden-topics", action="store_true", help="those that begin with _ too")


def _list(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        discover(node, args)
        topics = sorted(
            (name, types)
            for name, types in node.get_topic_names_and_types()
            if args.include_hidden_topics or not any(part.startswith("_") for part in name.split("/"))
        )
        if args.count_topics:
            print(len(topics))
        elif args.verbose:
            _with_numbers("Published topics", "publisher", topics, node.count_publishers)
            _with_numbers("Subscribed topics", "subscriber", topics, node.count_subscribers)
        else:
            for name, types in topics:
                print(f"{name} [{', '.join(types)}]" if args.show_types else name)
    return 0


def _with_numbers(
    title: str, noun: str, topics: list[tuple[str, list[str]]], count: Callable[[str], int]
) -> None:
    print(f"{title}:")
    for name, types in topics:
        number = count(name)
        if number:
            print(f" * {name} [{', '.join(types)}] {number} {noun}{'s' if number > 1 else ''}")
    print()


def _info_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("topic_name", help="e.g. /joint_states")
    parser.add_argument("-v", "--verbose", action="store_true", help="with every endpoint and its QoS")


def _info(args: argparse.Namespace) -> int:
    name = full_name(args.topic_name)
    with graph_node(args) as node:
        discover(node, args)
        types = wait_for(lambda: dict(node.get_topic_names_and_types()).get(name), 1.0)
        if types is None:
            raise CommandError(f"Unknown topic '{name}'")
        print(f"Type: {types[0] if len(types) == 1 else types}\n")
        _ends(node, "Publisher", node.get_publishers_info_by_topic(name), args.verbose)
        _ends(node, "Subscription", node.get_subscriptions_info_by_topic(name), args.verbose)
    return 0


def _ends(node: Node, title: str, ends: list[Any], verbose: bool) -> None:
    print(f"{title} count: {len(ends)}\n" if verbose else f"{title} count: {len(ends)}")
    for end in ends if verbose else ():
        qos = end.qos_profile
        print(f"Node name: {end.node_name}\nNode namespace: {end.node_namespace}")
        print(f"Topic type: {end.topic_type}\nEndpoint type: {end.endpoint_type.name}")
        print("QoS profile:")
        print(f"  Reliability: {qos.reliability.name}")
        print(f"  History (Depth): {qos.history.name} ({qos.depth})")
        print(f"  Durability: {qos.durability.name}")
        print(f"  Deadline: {_duration(qos.deadline)}\n  Lifespan: {_duration(qos.lifespan)}")
        print(f"  Liveliness: {qos.liveliness.name}\n")


def _duration(duration: Any) -> str:
    return "Infinite" if duration.nanoseconds >= 2**63 - 1 else f"{duration.nanoseconds} nanoseconds"


VERBS = (
    Verb("list", "Names of the topics", _list, _list_arguments),
    Verb("info", "Type and number of publishers and subscribers", _info, _info_arguments),
    Verb("echo", "Show messages as they come", topic_echo.run, topic_echo.arguments),
    Verb("hz", "Measure the rate of messages", topic_hz.run, topic_hz.arguments),
    Verb("pub", "Publish messages", topic_pub.run, topic_pub.arguments),
)
