"""Whether others are in a ROS domain, told by the ports at which they listen."""

from __future__ import annotations

import socket

from graph_bench import free_domain

from follower_humanoid.ros.company import has_company


def test_one_participant_is_no_company_and_two_are():
    domain = free_domain()
    first = 7400 + 250 * domain + 10
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(4)]
    try:
        for number, each in enumerate(sockets):
            each.bind(("127.0.0.1", first + number))
            assert has_company(domain) == (number >= 2)
    finally:
        for each in sockets:
            each.close()
    assert not has_company(domain)
