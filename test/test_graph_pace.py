"""Ticks on the wall's clock: never early, counted when late, no race after a long pause."""

from __future__ import annotations

import pytest

from follower_humanoid.graph.pace import Durations, Pace

TICK = 0.002


def test_a_tick_begins_when_its_time_has_come():
    pace = Pace(TICK, now=5.0, first=10)
    assert not pace.may_begin(11, 5.0019)
    assert pace.may_begin(11, 5.0021)
    assert not pace.may_begin(12, 5.0039)
    assert pace.missed == 0


def test_lateness_is_noted_once_per_tick():
    pace = Pace(TICK, now=0.0, first=0)
    for now in (0.0025, 0.0026, 0.0027):  # held back for another reason meanwhile
        assert pace.may_begin(1, now)
    assert pace.late.count == 1
    assert pace.late.percentiles(50.0)[0] == pytest.approx(0.0005)


def test_a_tick_that_begins_when_the_next_should_is_missed():
    pace = Pace(TICK, now=0.0, first=0)
    assert pace.may_begin(1, 0.0045)
    assert pace.missed == 1
    assert pace.may_begin(2, 0.0046)
    assert pace.missed == 1


def test_a_short_delay_is_made_up_for_and_a_long_one_is_not():
    pace = Pace(TICK, now=0.0, first=0)
    assert pace.may_begin(1, 0.1)
    assert pace.may_begin(2, 0.1)
    assert pace.may_begin(3, 3.0)
    assert not pace.may_begin(4, 3.0)
    assert pace.may_begin(4, 3.0 + TICK + 1e-9)


def test_percentiles_are_of_the_newest():
    durations = Durations()
    assert durations.percentiles(50.0, 99.0) == (0.0, 0.0)
    for _ in range(10_000):
        durations.add(1.0)
    assert durations.percentiles(99.0) == (1.0,)
    for _ in range(4096):
        durations.add(2.0)
    assert durations.percentiles(1.0, 99.0) == (2.0, 2.0)
    assert durations.count == 14_096
