"""`ros2 service ...`."""

from __future__ import annotations

import argparse
import sys
import time

from follower_humanoid.command_line import positive
from follower_humanoid.ros2_front.graph import (
    add_discovery_arguments,
    call,
    discover,
    full_name,
    graph_node,
    wait_for,
)
from follower_humanoid.ros2_front.messages import fill, interface, read_values
from follower_humanoid.ros2_front.verbs import CommandError, Verb

_PATIENCE = 30.0


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_discovery_arguments(parser)
    parser.add_argument("-t", "--show-types", action="store_true", help="with the type of each service")
    parser.add_argument("-c", "--count-services", action="store_true", help="only how many there are")
    parser.add_argument("--include-hidden-services", action="store_true", help="those with _ too")


def _list(args: argparse.Namespace) -> int:
    with graph_node(args) as node:
        discover(node, args)
        services = sorted(
            (name, types)
            for name, types in node.get_service_names_and_types()
            if args.include_hidden_services or not any(part.startswith("_") for part in name.split("/"))
        )
        if args.count_services:
            print(len(services))
            return 0
        for name, types in services:
            print(f"{name} [{', '.join(types)}]" if args.show_types else name)
    return 0


def _call_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("service_name", help="e.g. /replay/toggle_paused")
    add("service_type", help="package/srv/Type")
    add("values", nargs="?", default="", help="YAML; a field left out keeps its default")
    add("--stdin", action="store_true", help="values from standard input")
    add("-r", "--rate", type=positive, metavar="HZ", help="call again and again")


def _call(args: argparse.Namespace) -> int:
    service_class = interface(args.service_type, "srv")
    values = read_values(sys.stdin.read() if args.stdin else args.values)
    request = service_class.Request()
    fill(request, values)
    name = full_name(args.service_name)
    with graph_node() as node:
        # Looked up first: a client of another type would wait for ever.
        types = wait_for(lambda: dict(node.get_service_names_and_types()).get(name), 0.0)
        if types is None:
            print("waiting for service to become available...", flush=True)
            types = wait_for(lambda: dict(node.get_service_names_and_types()).get(name), _PATIENCE)
        if types is None:
            raise CommandError(f"no service '{name}' after {_PATIENCE:.0f} s")
        asked = args.service_type if args.service_type.count("/") > 1 else ""
        if asked and asked not in types:
            raise CommandError(f"service {name} is of type {', '.join(types)}, not {asked}")
        while True:
            print(f"requester: making request: {request!r}\n", flush=True)
            print(f"response:\n{call(node, service_class, name, request)!r}\n", flush=True)
            if args.rate is None:
                return 0
            time.sleep(1.0 / args.rate)


VERBS = (
    Verb("list", "Names of the services", _list, _list_arguments),
    Verb("call", "Call a service", _call, _call_arguments),
)
