"""When recorded moments are due: rate, pause, stop."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

import pytest
from bag_messages import START, write_bag

from follower_humanoid.replay.events import events
from follower_humanoid.replay.index import index_bag
from follower_humanoid.replay.pace import Pace
from follower_humanoid.replay.player import Player, PlayOptions

SECOND = 1_000_000_000
MILLISECOND = 1_000_000
FOR_EVER = 10**6 * SECOND


class Wall:
    """A clock that goes when it is told to."""

    def __init__(self) -> None:
        self.time = 5 * SECOND

    def __call__(self) -> int:
        return self.time


class Sleep(threading.Condition):
    """Sleeps on that clock; whatever is to happen meanwhile, happens and wakes the sleeper."""

    def __init__(
        self, wall: Wall, oversleeps: int = 0, happens: Sequence[tuple[int, Callable[[], None]]] = ()
    ) -> None:
        super().__init__()
        self._wall, self._oversleeps, self._happens = wall, oversleeps, list(happens)

    def wait(self, timeout: float | None = None) -> bool:
        wakes = None if timeout is None else self._wall.time + round(timeout * SECOND) + self._oversleeps
        if self._happens and (wakes is None or self._happens[0][0] <= wakes):
            self._wall.time, event = self._happens.pop(0)
            event()
            return True
        assert wakes is not None, "sleeps for ever"
        self._wall.time = wakes
        return False


class Nap(threading.Condition):
    """Sleeps on the wall's clock, and tells that it does."""

    def __init__(self) -> None:
        super().__init__()
        self.limits: list[float | None] = []
        self._asleep = threading.Semaphore(0)

    def wait(self, timeout: float | None = None) -> bool:
        self.limits.append(timeout)
        self._asleep.release()  # who wants to wake it comes in once it sleeps: it holds the lock till then
        return super().wait(timeout)

    def when_asleep(self, *actions: Callable[[], None]) -> threading.Thread:
        """Does one thing after the other, each once it sleeps again."""

        def act() -> None:
            for action in actions:
                self._asleep.acquire()
                action()

        thread = threading.Thread(target=act, daemon=True)
        thread.start()
        return thread


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


@pytest.mark.parametrize("oversleeps", [0, 300_000])
def test_waiting_is_exact_and_lateness_does_not_add_up(oversleeps):
    wall = Wall()
    pace = Pace(4.0, now=wall)
    pace._changed = Sleep(wall, oversleeps)
    pace.begin(0)
    begin = wall.time
    for number in range(1, 40):
        assert pace.wait_for(number * 10 * MILLISECOND)
        assert wall.time - begin == number * 2_500_000 + oversleeps


def test_waking_early_is_not_arriving_early():
    wall = Wall()
    begin = wall.time
    pace = Pace(1.0, now=wall)
    pace._changed = Sleep(wall, happens=[(begin + MILLISECOND * k, lambda: None) for k in range(1, 10)])
    pace.begin(0)
    assert pace.wait_for(10 * MILLISECOND)
    assert wall.time - begin == 10 * MILLISECOND


def test_a_pause_holds_a_wait_that_has_begun():
    wall = Wall()
    begin = wall.time
    pace = Pace(1.0, now=wall)
    changes = [(begin + 50 * MILLISECOND, pace.pause), (begin + 350 * MILLISECOND, pace.resume)]
    pace._changed = Sleep(wall, happens=changes)
    pace.begin(0)
    assert pace.wait_for(200 * MILLISECOND)
    assert wall.time - begin == 500 * MILLISECOND


@pytest.mark.parametrize("paused", [False, True])
def test_stop_ends_a_wait_at_once(paused):
    pace = Pace(1.0, paused)
    pace._changed = nap = Nap()
    pace.begin(0)
    stopping = nap.when_asleep(pace.stop)
    assert not pace.wait_for(FOR_EVER)  # at once, or this test never ends
    stopping.join()
    assert len(nap.limits) == 1
    assert not pace.wait_for(0)


def test_a_wait_is_woken_by_a_pause_and_by_its_end():
    pace = Pace(1.0)
    pace._changed = nap = Nap()
    pace.begin(0)
    nap.when_asleep(pace.pause, pace.resume, pace.stop)
    assert not pace.wait_for(FOR_EVER)
    until_due, through_the_pause, what_is_left = nap.limits
    assert through_the_pause is None
    assert 0.0 < what_is_left <= until_due <= 1e6


@pytest.mark.parametrize("rate", [1.0, 2.0])
def test_recorded_messages_are_sent_when_they_are_due(tmp_path, rate):
    index = index_bag(write_bag(tmp_path / "bag", 100))
    recorded = list(events(index, frozenset({"/odom"})))
    player = Player(index, PlayOptions(index.path, rate=rate, topics=("odom",), clock=0.0), index.topics)
    assert player.pace.rate == rate
    wall = Wall()
    begin = wall.time
    player.pace = Pace(rate, now=wall)
    player.pace._changed = Sleep(wall)
    sent = []
    player.run(lambda topic, data: sent.append((wall.time - begin, topic, data)))
    assert [data for _, _, data in sent] == [event.data for event in recorded]
    due = [(event.time - START) / rate for event in recorded]
    assert [time for time, _, _ in sent] == pytest.approx(due, abs=1)
