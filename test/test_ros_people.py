"""What people's wrenches do: newest wins, silence lets go, the leader's own messages are not taken twice."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.core.samples import Wrench
from follower_humanoid.graph.graph_config import RunConfig
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.people import PeopleWrench

TICK = 2_000_000
CODEC = Codec("base/push", RobotModel())


def message(force, tick=0, frame="world"):
    return CODEC.encode(Wrench(np.array([force, 0.0, 0.0]), np.zeros(3), frame), tick * TICK)


class Person:
    """The subject with everything around it in plain sight."""

    def __init__(self, lockstepped=False, publishers=1):
        self.warnings, self.rejected, self.time, self.publishers = [], [], 0.0, publishers
        knows = ("", "world", "torso").__contains__
        self.wrench = PeopleWrench(
            CODEC, RunConfig(), TICK, knows, self.warnings.append, self.reject
        )
        self.wrench.now = lambda: self.time
        self.wrench.publishers = lambda: self.publishers
        self.wrench.lockstepped = lockstepped

    def reject(self, error):
        self.rejected.append(str(error))

    def force(self, time):
        held = self.wrench.at(time)
        return None if held is None else held.force[0]


def test_nobody_holds_on_before_the_first_message():
    person = Person()
    assert [person.force(t) for t in (0.0, 0.6, 3.0)] == [None] * 3


def test_newest_wins_at_once_and_silence_lets_go():
    person = Person()
    person.time = 1.0
    person.wrench.receive(message(3.0))
    person.wrench.receive(message(5.0, tick=1_000_000))  # the stamp means nothing
    assert person.force(1.5) == 5.0
    assert person.force(1.6) == pytest.approx(2.5)
    assert person.force(1.7) is None
    assert person.warnings == []


def test_several_publishers_are_warned_of():
    person = Person(publishers=2)
    person.wrench.receive(message(3.0))
    assert person.force(0.0) == 3.0
    assert "several publishers of base/push" in person.warnings[0]


@pytest.mark.parametrize("publishers", [1, 2])
def test_the_leaders_own_messages_are_not_a_person(publishers):
    person = Person(lockstepped=True, publishers=publishers)
    for tick in (0, 5, 10):
        person.wrench.receive(message(1.0, tick))  # this copy may come first
        person.wrench.note_leader(message(1.0, tick))
        person.wrench.receive(message(1.0, tick))  # or second
    assert person.force(0.0) is None


def test_a_leader_that_is_ahead_of_its_copy_is_still_no_person():
    person = Person(lockstepped=True, publishers=2)
    for tick in (0, 5, 10):
        person.wrench.receive(message(1.0, tick))
    for tick in (0, 5, 10):
        person.wrench.note_leader(message(1.0, tick))
    assert person.force(1.0) is None


@pytest.mark.parametrize("ahead", range(-12, 13))
def test_a_persons_stamp_does_not_matter_even_if_it_is_simulated_time(ahead):
    person = Person(lockstepped=True, publishers=2)
    for tick in range(0, 100, 5):
        person.wrench.receive(message(1.0, tick))
        person.wrench.note_leader(message(1.0, tick))
    person.time = 0.2
    person.wrench.receive(message(9.0, tick=95 + ahead))
    for tick in range(100, 115, 5):
        person.wrench.receive(message(1.0, tick))
        person.wrench.note_leader(message(1.0, tick))
    assert person.force(0.3) == 9.0


def test_a_person_is_heard_where_the_leader_says_nothing_more():
    person = Person(lockstepped=True)
    person.wrench.note_leader(message(1.0, 100))
    person.wrench.receive(message(9.0, 105))
    assert person.force(0.25) == 9.0


def test_what_is_decided_late_does_not_take_the_place_of_what_came_after_it():
    person = Person(lockstepped=True, publishers=2)
    person.wrench.receive(message(9.0, tick=5))
    person.wrench.receive(message(7.0, tick=1))
    for tick in (0, 5, 10):
        person.wrench.note_leader(message(1.0, tick))
    assert person.force(0.1) == 7.0


def test_a_person_beside_the_leader_takes_its_place_until_letting_go():
    person = Person(lockstepped=True, publishers=2)
    for tick in range(0, 100, 5):
        person.wrench.note_leader(message(1.0, tick))
    person.wrench.receive(message(9.0, tick=0))
    assert person.force(0.3) == 9.0
    assert person.force(0.8) is None


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (message(np.nan), "not finite"),
        (message(1.0, frame="tail"), "no frame 'tail'"),
        (b"\0\1\0\0junk", "not a WrenchStamped"),
    ],
)
def test_what_cannot_be_used_is_refused(data, words):
    person = Person()
    person.wrench.receive(data)
    assert person.force(0.0) is None
    assert words in person.rejected[0]
    assert "base/push" in person.rejected[0]


def test_a_frame_of_the_robot_is_kept_for_the_plant():
    person = Person()
    person.wrench.receive(message(1.0, frame="torso"))
    assert person.wrench.at(0.0).frame == "torso"
