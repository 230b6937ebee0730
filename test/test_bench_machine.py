"""A loop that keeps time, on a clock of the test's own."""

import pytest

from follower_humanoid.bench.machine import own_lateness, paced_lateness

TICK = 0.002


class Clock:
    """Time passes by work and rest only."""

    def __init__(self):
        self.time = 5.0

    def now(self):
        return self.time

    def rest(self, seconds):
        self.time += seconds


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_loop_with_time_to_rest_is_late_by_one_look_at_most(share):
    clock = Clock()
    late = paced_lateness(TICK, 1000, lambda: clock.rest(share * TICK), clock.now, clock.rest)
    assert 0.0 <= late <= 0.0002


def test_a_halt_is_seen_until_it_has_been_caught_up():
    clock, steps = Clock(), iter(range(1000))
    halt = 0.05

    def work():
        clock.rest(0.5 * TICK + (halt if next(steps) == 500 else 0.0))

    # Each tick catches up by half of its length: 50 of 1000 are late, the 99th percentile is the tenth worst.
    late = paced_lateness(TICK, 1000, work, clock.now, clock.rest)
    assert halt - 12 * 0.5 * TICK < late < halt - 8 * 0.5 * TICK


def test_on_this_machine_it_comes_to_an_end():
    assert own_lateness(TICK, 0.5, 20) >= 0.0
