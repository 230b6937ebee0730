"""When recorded moments are due: rate, pause, stop."""

from __future__ import annotations

import threading
import time

import pytest

from follower_humanoid.replay.pace import Pace

SECOND = 1_000_000_000


class Wall:
    """A clock that goes when it is told to."""

    def __init__(self) -> None:
        self.time = 5 * SECOND

    def __call__(self) -> int:
        return self.time


def test_time_runs_at_the_rate():
    wall = Wall()
    pace = Pace(2.0, now=wall)
    pace.begin(100 * SECOND)
    wall.time += 3 * SECOND
    assert pace.reached() == 106 * SECOND
    assert pace.wait_for(106 * SECOND)


def test_a_pause_moves_what_comes_after_it():
    wall = Wall()
    pace = Pace(1.0, now=wall)
    pace.begin(0)
    wall.time += SECOND
    pace.pause()
    wall.time += 10 * SECOND
    assert pace.reached() == SECOND
    pace.resume()
    wall.time += SECOND
    assert pace.reached() == 2 * SECOND


def test_pausing_twice_is_pausing_once():
    wall = Wall()
    pace = Pace(1.0, now=wall)
    pace.begin(0)
    pace.pause()
    wall.time += SECOND
    pace.pause()
    pace.toggle()
    assert not pace.paused
    pace.resume()
    assert pace.reached() == 0


def test_waiting_is_exact_to_a_millisecond():
    pace = Pace(4.0)
    pace.begin(0)
    late = []
    begin = time.monotonic_ns()
    for number in range(1, 40):
        assert pace.wait_for(number * 10_000_000)
        late.append((time.monotonic_ns() - begin) / 1e6 - number * 2.5)
    assert min(late) > -0.1
    assert sorted(late)[len(late) // 2] < 1.0


@pytest.mark.parametrize("paused", [False, True])
def test_stop_ends_a_wait_at_once(paused):
    pace = Pace(1.0, paused)
    pace.begin(0)
    threading.Timer(0.1, pace.stop).start()
    begin = time.monotonic()
    assert not pace.wait_for(100 * SECOND)
    assert time.monotonic() - begin < 2.0
    assert not pace.wait_for(0)


def test_a_pause_holds_a_wait_that_has_begun():
    pace = Pace(1.0)
    pace.begin(0)
    threading.Timer(0.05, pace.pause).start()
    threading.Timer(0.35, pace.resume).start()
    begin = time.monotonic()
    assert pace.wait_for(200_000_000)
    assert time.monotonic() - begin > 0.45
