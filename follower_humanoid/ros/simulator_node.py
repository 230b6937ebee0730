"""The simulator in the graph: publishes the state of a tick, waits for its commands, steps."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Mapping
from typing import Any

from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from follower_humanoid.core.cdr import NANOSECONDS, clock_bytes
from follower_humanoid.core.topics import PEOPLE as PEOPLE_TOPICS
from follower_humanoid.graph.graph_config import LEADER, RunConfig
from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.pace import Durations, Pace
from follower_humanoid.graph.run_end import RunEnd
from follower_humanoid.graph.wiring import NODES, SIMULATOR, node_wiring
from follower_humanoid.ros.barrier import RESET, RollCall, expected_readers
from follower_humanoid.ros.holding import HoldingDrives
from follower_humanoid.ros.lockstep_node import LockStepNode
from follower_humanoid.ros.managed_node import FAILED
from follower_humanoid.ros.outcome import ENDED, EXIT_STATUS
from follower_humanoid.ros.outlet import LOOK_EVERY
from follower_humanoid.ros.parameters import declare
from follower_humanoid.ros.people import PeopleWrench
from follower_humanoid.ros.qos import LATCHED, PEOPLE
from follower_humanoid.ros.shared_robot import shared_robot

FELL = 3
_PACE = 0.0005  # wall time between two looks at the clock when paced [s]


class SimulatorNode(LockStepNode):
    """Keeps simulated time; everyone else follows its stamps."""

    hears_people = True

    def __init__(self, **options: Any) -> None:
        """Declares the plant's and the run's parameters."""
        super().__init__(node_wiring(SIMULATOR), **options)
        self.run: RunConfig = declare(self, RunConfig)
        self._roll_call = RollCall(self, self.present, self._all_know, self.reject)
        self._waiting_for_all = False
        self._peak_voltage, self._saturated = 0.0, 0
        self.create_service(Trigger, "reset", self._reset_asked)
        self._inputs = self.wiring.component_class().Inputs
        self._topics = [self.wiring.inputs[name] for name in self._inputs.__match_args__]
        self._people: dict[str, PeopleWrench] = {}
        self._clock_heard = False
        self._began = self._stepped = 0.0
        self._tick_times = Durations()
        self._joint_hash = hashlib.sha256()
        self._speed = (0.0, 0)
        self._pace: Pace | None = None
        self._holding = HoldingDrives(self)

    def awaited_topics(self) -> tuple[str, ...]:
        """Commands of what can move, and the leader's wrenches where the built-in leader runs."""
        topics = list(node_wiring(SIMULATOR).inputs.values())
        if self.config.fixed_trunk:
            topics.remove("legs/command")
        return tuple(t for t in topics if t not in PEOPLE_TOPICS or LEADER in self.present)

    def set_up(self) -> None:
        """Builds the world and the endpoints, the clock among them."""
        again = self.starting.barrier is not None
        if not again:
            self._clock_publisher = self.make_publisher(Clock, CLOCK)
        super().set_up()
        robot = shared_robot(self.graph.urdf)
        if not again:
            self._describer = self.create_publisher(String, "robot_description", LATCHED)
        self._describer.publish(String(data=robot.urdf))
        self._end = RunEnd(self.run, robot)
        barrier = self.starting.barrier
        if barrier is not None and not again:
            self._reset_publisher = self.make_publisher(Header, RESET)
            barrier.watch(self._reset_publisher, self._roll_call.others)
            self._holding.open(barrier)
        self._people = {topic: self._person(topic) for topic in sorted(PEOPLE_TOPICS)}

    def _person(self, topic: str) -> PeopleWrench:
        codec = self.codecs[topic]
        person = PeopleWrench(
            codec, self.run, self.tick_ns, self.component.knows_frame, self.tell_once, self.reject
        )
        subscription = self.make_subscription(codec.message_type, topic, person.receive, PEOPLE)
        person.publishers = subscription.get_publisher_count
        person.now = lambda: self.lock.tick * self.graph.tick
        person.lockstepped = topic in self.lock.topics
        self.inlet.copies[topic] = person.note_leader
        return person

    def readers_of_more(self) -> dict[str, list[Any]]:
        """Whom the clock paces, and who records it."""
        return {name: [self._clock_publisher] for name in expected_readers(CLOCK, self.present)}

    def still_waiting_for(self) -> list[str]:
        """Nodes that have not announced themselves."""
        missing = self._roll_call.waiting_for()
        return [f"nodes {', '.join(missing)} to be ready"] if missing else []

    def barrier_passed(self) -> None:
        """Time 0: the first state goes out."""
        self._began = self._stepped = time.monotonic()
        self._began_at = time.time()
        if self.run.realtime:
            self._keep_real_time()
        self._publish_state()

    def may_step(self) -> bool:
        """In real time, not before the tick is over on the wall's clock too."""
        if self._waiting_for_all:
            return False
        if not self.lock.paced and self._pace is None:
            self.tell_once("no commands with stamps of the tick: in real time from here on")
            self._keep_real_time()
        if self._pace is None:
            return True
        # The state of a tick is out once it has begun: the next one begins a tick later.
        return self._pace.may_begin(self.lock.tick + 1, time.monotonic())

    def _keep_real_time(self) -> None:
        self._pace = Pace(self.graph.tick, time.monotonic(), self.lock.tick)
        self.make_timer(_PACE, self._keep_pace)

    def _keep_pace(self) -> None:
        """Goes on; time does not stand still for who is silent, whose motor drives then hold."""
        self.run_ready_steps()
        silent = time.monotonic() - self._stepped
        if not (self.running and self.started):
            self._stepped = time.monotonic()
        elif not self.run.realtime or silent <= self.run.hold_after:
            return
        elif self._waiting_for_all:
            names = ", ".join(self._roll_call.waiting_for())
            self.logger.warning(f"{names} silent for {silent:.2f} s: the reset goes on without")
            self._all_know()
        elif not self.lock.ready:
            for missing in self.lock.give_up_on(self.lock.topics):
                self.logger.warning(f"no {missing} for {silent:.2f} s: going on without it")
            self.run_ready_steps()

    def stop(self) -> None:
        """Pauses: simulated time stands still for everyone."""

    def tear_down(self) -> None:
        """Ends the run: simulated time cannot begin again at 0 for those who have seen more of it."""
        begun = self.started
        super().tear_down()
        if begun:
            self.quit(0, "the simulator was cleaned up")

    def step(self, tick: int, samples: Mapping[str, Any]) -> None:
        """One tick of physics, then the next state."""
        self._holding.note(tick, samples)
        given = dict(samples)
        time_now = tick * self.graph.tick
        for topic, person in self._people.items():
            held = person.at(time_now)
            if held is not None:
                given[topic] = held
        inputs = self._inputs(*map(given.get, self._topics))
        if self.lock.tick == self.resets.due_at:
            self.component.reset()
        else:
            self.component.advance(inputs)
        self._publish_state()
        self._note_voltages(inputs)
        now = time.monotonic()
        self._tick_times.add(now - self._stepped)
        self._stepped = now
        self._look_for_end()

    def reset(self) -> None:
        """The robot stands already; what follows the reset is nobody's old result."""

    def _reset_asked(self, request: Any, response: Any) -> Any:
        """Tells everyone at which tick to begin anew and waits until all know."""
        response.success = self.started and self.running and self.resets.due_at is None
        if not response.success:
            response.message = "not running" if self.resets.due_at is None else "a reset is on its way"
            return response
        # Nobody has stepped the tick after the next; slow nodes step at multiples of their period.
        whole = math.lcm(*(node.period for node in NODES.values()))
        self.resets.due_at = tick = -(-(self.lock.tick + 2) // whole) * whole
        self._roll_call.expect_reset(tick, self.attendance.gone)
        self._waiting_for_all = bool(self._roll_call.waiting_for())
        header = Header()
        header.stamp.sec, header.stamp.nanosec = divmod(tick * self.tick_ns, NANOSECONDS)
        self._reset_publisher.publish(header)
        response.message = f"back on its feet at {tick * self.graph.tick:.3f} s"
        return response

    def _all_know(self) -> None:
        if self._waiting_for_all:
            self._waiting_for_all = False
            self._stepped = time.monotonic()  # nobody was late so far
            self.run_ready_steps()

    def _note_voltages(self, inputs: Any) -> None:
        commands = [command for command in (inputs.legs, inputs.arms) if command is not None]
        volts = [volt for command in commands for volt in command.effort.tolist()]
        peak = max(max(volts), -min(volts)) if volts else 0.0
        self._peak_voltage = max(self._peak_voltage, peak)
        self._saturated += peak >= self.component.plant.motors.voltage_limit

    def _publish_state(self) -> None:
        tick, state = self.lock.tick, self.component.observe()
        self.publish(state, tick)
        self._joint_hash.update(state.joints.position.tobytes())
        if tick % LOOK_EVERY == 0:
            self._clock_heard = self._clock_publisher.get_subscription_count() > 0
        if self._clock_heard:
            self._clock_publisher.publish(clock_bytes(tick * self.tick_ns))

    def _look_for_end(self) -> None:
        state, fall = self.component.observe(), self.component.fall
        now = self.lock.tick * self.graph.tick
        feet = (state.left_foot.force, state.right_foot.force)
        if not self._end.over(now, state.odometry.linear_velocity, feet, fall.time if fall else None):
            return
        if fall is None:
            self.quit(0, f"the run ended at {now:.3f} s")
            return
        x, y, _ = fall.place
        place = f"at x = {x:.2f} m, y = {y:.2f} m"
        self.quit(FELL, f"the robot fell at {fall.time:.3f} s, {place}: {fall.reason}")

    def stalled(self, waited: float, missing: str) -> None:
        """Nobody else can go on either: the run is lost."""
        if self._waiting_for_all:
            missing = f"a reset waits for {', '.join(self._roll_call.waiting_for())}"
        self.quit(FAILED, f"no message for {waited:.0f} s: {missing}")

    def wind_down(self) -> None:
        """No further tick."""
        self.running = False

    @property
    def stamp(self) -> int:
        """Simulated time of the newest state [ns]."""
        return self.lock.tick * self.tick_ns

    def report(self) -> dict[str, float | int | str | bool]:
        """Simulated time, real-time factor, voltage, saturation, fall."""
        values = super().report()
        now = time.monotonic()
        at, tick = self._speed
        factor = (self.lock.tick - tick) * self.graph.tick / max(now - at, 1e-9) if at else 0.0
        self._speed = (now, self.lock.tick)
        elapsed = now - self._began if self._began else 0.0
        values["simulated_time [s]"] = self.stamp / NANOSECONDS
        values["real_time_factor"] = factor
        if elapsed:
            values["mean_real_time_factor"] = self.stamp / NANOSECONDS / elapsed
            values["began_at [s]"] = f"{self._began_at:.3f}"
            median, rarely = self._tick_times.percentiles(50.0, 99.0)
            values["tick_time_p50 [s]"], values["tick_time_p99 [s]"] = median, rarely
        if self._pace is not None:
            (values["lateness_p99 [s]"],) = self._pace.late.percentiles(99.0)
            values["late_ticks"] = self._pace.missed
        if self.exit_status is not None:
            values[ENDED], values[EXIT_STATUS] = self.exit_reason, self.exit_status
        fall = self.component.fall if self.component is not None else None
        values["peak_voltage [V]"] = self._peak_voltage
        values["saturated_ticks"] = self._saturated
        values["joint_hash"] = self._joint_hash.hexdigest()  # as of a recorded run
        values["fallen"] = fall is not None
        if fall is not None:
            values["error"] = f"fell at {fall.time:.3f} s: {fall.reason}"
        return values
