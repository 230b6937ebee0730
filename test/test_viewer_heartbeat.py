"""Signs of life of pages that hold a hand: each page answers for itself."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest
from graph_bench import ENDLESS, wait_until

from follower_humanoid.viewer.heartbeat import Heartbeat


class Pages:
    """Pages 1 and 2 hold a hand, and 3 is closed."""

    def __init__(self):
        self.heard_of, self.gone_are = [], []
        self.hanging = threading.Event()

    def pages(self):
        return {1, 2, 3}

    def heard(self, number, now):
        self.heard_of.append(number)

    def gone(self, number):
        self.gone_are.append(number)

    def clients(self):
        return {
            1: SimpleNamespace(local_storage=SimpleNamespace(get_item=self.hang)),
            2: SimpleNamespace(local_storage=SimpleNamespace(get_item=lambda key, timeout: None)),
        }

    def hang(self, key, timeout):
        if not self.hanging.wait(timeout):
            raise TimeoutError


@pytest.fixture
def pages():
    made = Pages()
    yield made
    made.hanging.set()


def test_a_page_that_hangs_does_not_keep_others_from_being_heard(pages):
    heartbeat = Heartbeat(pages, pages.clients, ENDLESS)
    assert wait_until(lambda: pages.heard_of.count(2) >= 3 and 3 in pages.gone_are)
    assert 1 not in pages.heard_of
    pages.hanging.set()  # it answers at last
    assert wait_until(lambda: 1 in pages.heard_of)
    heartbeat.end()
