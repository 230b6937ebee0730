"""Which message a node waits for: exactly the one of the tick, whatever else arrives and in what order."""

from __future__ import annotations

import pytest

from follower_humanoid.graph.lockstep import CLOCK, LockStep
from follower_humanoid.graph.wiring import NODES, PRODUCER, WIRING, is_optional, used_tick

EVERYONE = frozenset(NODES)


def feed(lock, topic, ticks):
    return [lock.put(topic, tick, f"{topic}@{tick}") for tick in ticks]


def test_step_waits_for_every_input_of_its_tick():
    lock = LockStep(NODES["arm_controller"], EVERYONE)
    assert not lock.ready
    for topic in ("joint_states", "odom"):
        assert feed(lock, topic, [0]) == [False]
    assert [str(m) for m in lock.missing()] == ["imu of tick 0 from simulator"]
    assert feed(lock, "imu", [0]) == [True]
    values = lock.take()
    assert values["imu"] == "imu@0"
    assert values["left_hand/wrench"] is None  # of tick -1
    assert lock.tick == 1


def test_latest_message_is_never_taken_for_the_right_one():
    lock = LockStep(NODES["wrench_sensing"], EVERYONE)
    topics = lock.topics
    for topic in topics:
        feed(lock, topic, [2, 1, 0])
    for tick in range(3):
        assert lock.ready
        assert lock.take() == {topic: f"{topic}@{tick}" for topic in topics}
    assert not lock.ready


def test_a_slow_node_uses_its_ticks_and_can_drop_the_others_unread():
    lock = LockStep(NODES["gait_mapping"], EVERYONE)
    lock.take()  # tick 0 has nothing to wait for
    assert lock.tick == 5
    assert [lock.needs("left_hand/wrench", tick) for tick in range(6)] == [False] * 4 + [True] * 2
    for topic in lock.topics:
        feed(lock, topic, [4])
    assert lock.take() == {topic: f"{topic}@4" for topic in lock.topics}


def test_a_slow_output_is_used_through_the_next_period():
    lock = LockStep(NODES["motion_composition"], EVERYONE)
    feed(lock, "gait", [0, 5])
    seen = []
    for tick in range(12):
        for topic in lock.topics:
            if topic != "gait":
                feed(lock, topic, [tick])
        if not lock.ready:
            break
        seen.append(lock.take()["gait"])
    assert seen == [None] * 5 + ["gait@0"] * 5 + ["gait@5"] * 2


def test_an_announced_absence_counts_as_a_message():
    lock = LockStep(NODES["simulator"], EVERYONE, ["legs/command", "arms/command"])
    lock.put("legs/command", 0, None)
    assert lock.put("arms/command", 0, "volts")
    assert lock.take() == {"legs/command": None, "arms/command": "volts"}


def test_a_node_without_inputs_is_paced_by_the_clock():
    lock = LockStep(NODES["leader"], EVERYONE)
    assert lock.topics == (CLOCK,)
    ticks = []
    for tick in range(11):
        lock.put(CLOCK, tick, True)
        while lock.ready:
            ticks.append(lock.tick)
            lock.take()
    assert ticks == [0, 5, 10]


def test_late_and_double_messages_change_nothing():
    lock = LockStep(NODES["wrench_sensing"], EVERYONE)
    for topic in lock.topics:
        feed(lock, topic, [0])
    assert not lock.put("odom", 0, "another")
    assert lock.take()["odom"] == "odom@0"
    assert not lock.put("odom", 0, "late")
    assert lock.late == 2


@pytest.mark.parametrize("node", WIRING, ids=lambda node: node.name)
def test_every_node_uses_what_the_wiring_says(node):
    lock = LockStep(node, EVERYONE)
    for tick in range(0, 60, node.period):
        for topic in lock.topics:
            period = 1 if topic == CLOCK else PRODUCER[topic].period
            for sent in range(tick + 1):
                if sent % period == 0:
                    lock.put(topic, sent, sent)
        assert lock.tick == tick
        values = lock.take()
        for topic, value in values.items():
            used = tick if topic == CLOCK else used_tick(tick, topic)
            assert value == (used if used >= 0 else None)


def without(*names):
    return EVERYONE - set(names)


def test_a_stranger_that_keeps_the_ticks_is_waited_for():
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"))
    state = [topic for topic in lock.topics if topic != "gait"]
    for tick in range(5):
        for topic in state:
            feed(lock, topic, [tick])
        lock.take()
    for topic in state:
        feed(lock, topic, [5])
    assert not lock.ready
    assert feed(lock, "gait", [0]) == [True]
    assert lock.take()["gait"] == "gait@0"


@pytest.mark.parametrize("left_out", sorted(NODES))
@pytest.mark.parametrize("node", WIRING, ids=lambda node: node.name)
def test_with_a_stranger_that_keeps_the_ticks_a_node_uses_what_it_uses_without(node, left_out):
    lock = LockStep(node, without(left_out))
    steps = 0
    for now in range(60):
        for topic in lock.topics:
            period = 1 if topic == CLOCK else PRODUCER[topic].period
            if now % period == 0:
                lock.put(topic, now, now)
        while lock.ready and lock.tick <= now:
            tick, steps = lock.tick, steps + 1
            for topic, value in lock.take().items():
                if topic == CLOCK or (PRODUCER[topic].name == left_out and is_optional(topic)):
                    continue  # the newest, whoever has it
                used = used_tick(tick, topic)
                assert value == (used if used >= 0 else None), topic
    assert steps >= 60 // node.period - 1


@pytest.mark.parametrize("tick", [None, 3, 1_000_000])
def test_the_newest_message_of_any_other_stranger_is_held(tick):
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"))
    lock.put("gait", tick, "walk")
    for step in range(12):
        for topic in lock.topics:
            if topic != "gait":
                feed(lock, topic, [step])
        assert lock.take()["gait"] == "walk"


def test_a_stranger_that_falls_silent_is_given_up_and_its_last_word_held():
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"))
    feed(lock, "gait", [0])
    seen = []
    for step in range(12):
        for topic in lock.topics:
            if topic != "gait":
                feed(lock, topic, [step])
        if not lock.ready:
            assert [str(m) for m in lock.give_up()] == ["gait of tick 5 from gait_mapping"]
        seen.append(lock.take()["gait"])
    assert seen == [None] * 5 + ["gait@0"] * 7


def test_motor_commands_are_waited_for_whoever_sends_them():
    lock = LockStep(NODES["simulator"], without("arm_controller"), ["legs/command", "arms/command"])
    feed(lock, "legs/command", [0])
    assert lock.give_up() == []
    assert not lock.ready


@pytest.mark.parametrize("name", sorted(NODES))
@pytest.mark.parametrize("tick", [50, 10_000])
def test_a_restart_begins_anew_however_late_it_comes(name, tick):
    lock = LockStep(NODES[name], EVERYONE)
    lock.restart(tick)
    for now in range(tick, tick + 20):
        for topic in lock.topics:
            period = 1 if topic == CLOCK else PRODUCER[topic].period
            if now % period == 0:
                feed(lock, topic, [now])
        while lock.ready and lock.tick <= now:
            lock.take()
    assert lock.tick > tick + 15
    assert lock.strange == 0


def test_after_a_late_restart_a_stranger_that_keeps_the_ticks_is_still_waited_for():
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"))
    lock.restart(10_000)
    lock.put("gait", 10_000, "slow")
    gait = walk(lock, 10)
    assert gait[-1] == "slow"
    for topic in lock.topics:
        if topic != "gait":
            feed(lock, topic, [lock.tick])
    assert {missing.topic for missing in lock.missing()} == {"gait"}


def test_after_a_restart_earlier_results_are_absent():
    lock = LockStep(NODES["leg_controller"], EVERYONE)
    for tick in range(3):
        for topic in lock.topics:
            feed(lock, topic, [tick])
        lock.take()
    lock.restart(3)
    for topic in ("joint_states", "odom", "left_foot/wrench", "right_foot/wrench"):
        feed(lock, topic, [3])
    assert lock.ready
    values = lock.take()
    assert values["joint_states"] == "joint_states@3"
    assert values["balance/reference"] is None


@pytest.mark.parametrize("name", sorted(EVERYONE - {"simulator", "leader"}))
def test_after_a_late_restart_nobody_is_taken_for_left_behind(name):
    lock = LockStep(NODES[name], EVERYONE)
    begin = 50_000
    lock.restart(begin)
    # A neighbour may be a period ahead: its first message comes while nothing of before is awaited.
    for tick in range(begin, begin + 11):
        for topic in lock.topics:
            if tick % PRODUCER[topic].period == 0:
                feed(lock, topic, [tick])
    while lock.ready and lock.tick <= begin + 10:
        values = lock.take()
    assert lock.tick > begin + 10
    assert all(value is not None for value in values.values())
    assert lock.strange == 0


def test_after_a_late_restart_a_stranger_that_keeps_the_ticks_is_waited_for():
    lock = LockStep(NODES["zmp_balance"], without("motion_composition"))
    lock.restart(50_000)
    feed(lock, "motion/reference", [50_000])
    for tick in (50_000, 50_001):
        for topic in lock.topics:
            if topic not in ("motion/reference",):
                feed(lock, topic, [tick])
        assert lock.ready
        values = lock.take()
    assert values["motion/reference"] == "motion/reference@50000"
    assert [missing.topic for missing in lock.missing() if missing.topic.startswith("motion/ref")] == [
        "motion/reference"
    ]


def walk(lock, steps, held="gait"):
    """Steps of a node whose other inputs all come; what it got on the held topic."""
    seen = []
    for _ in range(steps):
        for topic in lock.topics:
            if topic != held:
                feed(lock, topic, [lock.tick])
        seen.append(lock.take()[held])
    return seen


def test_absence_of_what_is_held_makes_no_other_input_superfluous():
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"))
    lock.put("gait", None, "walk")
    walk(lock, 5)
    assert not lock.put("gait", 0, None)
    missing = lock.missing()
    for entry in missing:
        assert not lock.ready
        assert lock.put(entry.topic, entry.tick, "state") == (entry is missing[-1])
    assert lock.take()["gait"] == "walk"


def test_what_is_held_becomes_too_old():
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"), hold=20)
    lock.put("gait", None, "walk")
    assert walk(lock, 30) == ["walk"] * 21 + [None] * 9
    assert lock.stale == 9
    lock.put("gait", None, "on")
    assert walk(lock, 30) == ["on"] * 21 + [None] * 9


def test_a_silent_stranger_is_given_up_and_soon_absent():
    lock = LockStep(NODES["motion_composition"], without("gait_mapping"), hold=10)
    feed(lock, "gait", [0])
    assert walk(lock, 10) == [None] * 5 + ["gait@0"] * 5
    lock.give_up()
    assert walk(lock, 20) == ["gait@0"] * 11 + [None] * 9


def test_held_motor_commands_become_missing_so_that_the_drives_hold():
    topics = ["legs/command", "arms/command"]
    lock = LockStep(NODES["simulator"], without("arm_controller"), topics, hold=3)
    lock.put("arms/command", None, "volts")
    assert walk(lock, 5, "arms/command") == ["volts"] * 4 + [None]


def test_nobody_waits_for_what_a_stranger_need_not_publish():
    lock = LockStep(NODES["gait_mapping"], without("arm_controller"))
    assert lock.take()["arms/mode"] is None
    feed(lock, "left_hand/wrench", [4])
    assert feed(lock, "right_hand/wrench", [4]) == [True]
    lock.put("arms/mode", None, "led")
    assert lock.take()["arms/mode"] == "led"


def test_a_node_that_hears_strangers_only_keeps_the_pace_of_the_clock():
    lock = LockStep(NODES["gait_mapping"], without("wrench_sensing", "arm_controller"))
    for topic in lock.topics:
        if topic != CLOCK:
            lock.put(topic, None, "pull")
    assert not lock.ready
    ticks = []
    for tick in range(11):
        lock.put(CLOCK, tick, True)
        while lock.ready:
            ticks.append(lock.tick)
            assert lock.take()["left_hand/wrench"] == "pull"
    assert ticks == [0, 5, 10]


def test_a_simulator_whose_commands_are_held_waits_for_nobody():
    lock = LockStep(NODES["simulator"], without("arm_controller"), ["arms/command"])
    assert lock.paced
    lock.put("arms/command", None, "volts")
    assert lock.ready
    assert not lock.paced


def test_who_is_given_up_is_waited_for_again_once_it_has_caught_up():
    lock = LockStep(NODES["simulator"], EVERYONE, ["legs/command", "arms/command"])
    feed(lock, "arms/command", range(20))
    feed(lock, "legs/command", [0])
    lock.take()
    assert not lock.ready
    assert [str(m) for m in lock.give_up_on(lock.topics)] == ["legs/command of tick 1 from leg_controller"]
    taken = [lock.take()["legs/command"] for _ in range(4)]
    assert taken == [None] * 4
    feed(lock, "legs/command", [1, 2])  # late: still catching up
    assert lock.ready
    assert lock.late == 2
    feed(lock, "legs/command", [7])  # back, a little ahead
    assert [lock.take()["legs/command"] for _ in range(3)] == [None, None, "legs/command@7"]
    assert not lock.ready


def test_a_node_that_leaves_is_not_waited_for_from_its_tick_on():
    lock = LockStep(NODES["zmp_balance"], EVERYONE)
    for topic in lock.topics:
        feed(lock, topic, [0, 1, 2, 3] if topic != "motion/reference" else [0])
    lock.take()
    lock.take()
    assert not lock.ready or lock.tick == 2
    lock.leave("motion_composition", 1)
    for _ in range(2):
        assert lock.ready
        lock.take()


def test_messages_of_a_far_future_are_counted_and_dropped():
    lock = LockStep(NODES["wrench_sensing"], EVERYONE)
    for topic in lock.topics:
        feed(lock, topic, [10**6, 10**9, 2**40])
    assert lock.strange == 3 * len(lock.topics)
    assert not lock.ready
