"""A node of the wiring table in the lock-stepped graph: messages in by tick, messages out by tick."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import Any

from rclpy.serialization import deserialize_message
from std_msgs.msg import Header

from follower_humanoid.graph.lockstep import CLOCK, STALE, LockStep
from follower_humanoid.graph.wiring import NODES, PRODUCER, SIMULATOR, NodeWiring, node_wiring, nodes_with
from follower_humanoid.ros.barrier import RESET, Announcer, Barrier, expected_readers
from follower_humanoid.ros.cdr import CdrWriter
from follower_humanoid.ros.codecs import NANOSECONDS, Codec, stamp_of
from follower_humanoid.ros.formats import PEOPLE as PEOPLE_TOPICS
from follower_humanoid.ros.managed_node import ManagedNode, Rate
from follower_humanoid.ros.parameters import LiveConfig, declare
from follower_humanoid.ros.people import copy_of
from follower_humanoid.ros.qos import LOCKSTEP
from follower_humanoid.ros.quiet import quiet_stderr
from follower_humanoid.ros.shared_robot import shared_robot
from follower_humanoid.ros.validation import MessageError

ABSENT = "graph/absent"
_BARRIER_POLL = 0.02
_PATIENCE = 1.0  # wall time for a stranger who may not keep the ticks [s]
_TELL_EVERY = 5.0
_READ_BY_NODES = frozenset(topic for node in NODES.values() for topic in node.inputs.values())


class LockStepNode(ManagedNode):
    """Endpoints, start barrier, watchdog and bookkeeping; subclasses say what a step does.

    Attributes:
        wiring: The node's row of the wiring table.
        component: What the node runs, once configured.
        lock: Which messages the next step waits for.
        reset_at: Tick from which everything begins anew, None where no reset is on its way.
    """

    def __init__(self, wiring: NodeWiring, **options: Any) -> None:
        """Declares the component's parameters beside the shared ones.

        Raises:
            ConfigurationError: A parameter value cannot be used.
        """
        super().__init__(wiring.name, **options)
        self.wiring = wiring = node_wiring(wiring.name, self.present)
        with quiet_stderr():  # a physics engine introduces itself when it is imported
            component_class = wiring.component_class()
        adjustable = hasattr(component_class, "reconfigure")
        self.config = declare(self, component_class.Config, adjustable)
        if adjustable:
            LiveConfig(self, self.config, self._reconfigure)
        self.component: Any = None
        self.lock = self._make_lock()
        self.started = False
        self.reset_at: int | None = None
        self._codecs: dict[str, Codec] = {}
        self._publishers_by_topic: dict[str, Any] = {}
        self._copies: dict[str, Any] = {}
        self._own_subscriptions: list[Any] = []
        self._own_publishers: list[Any] = []
        self._barrier: Barrier | None = None
        self._rate = Rate()
        self._steps = 0
        self._busy = 0.0
        self._given_up = 0
        self._progress_at = self._told_at = time.monotonic()
        self._announcer = Announcer(self)
        self._barrier_timer = self.create_timer(_BARRIER_POLL, self._look_at_barrier, clock=self._wall)
        self._barrier_timer.cancel()
        self.create_timer(_PATIENCE, self._watch, clock=self._wall)

    def _make_lock(self) -> LockStep:
        hold = round(STALE / self.graph.tick)
        return LockStep(self.wiring, self.present, self.awaited_topics(), hold)

    # What subclasses say.

    def awaited_topics(self) -> tuple[str, ...]:
        """Inputs that are lock-stepped; empty for all."""
        return ()

    def step(self, tick: int, samples: Mapping[str, Any]) -> None:
        """Does the work of one tick."""
        raise NotImplementedError

    def barrier_passed(self) -> None:
        """Every message will arrive from here on."""

    def may_step(self) -> bool:
        """False to hold a step back although its inputs are there."""
        return True

    def still_waiting_for(self) -> list[str]:
        """Reasons not to start, besides the node's own barrier."""
        return []

    # Lifecycle.

    def set_up(self) -> None:
        """Makes component and endpoints."""
        robot = shared_robot(self.graph.urdf)
        self.component = self.wiring.make(self.config, robot, self.graph.tick)
        self._barrier = Barrier(self, self.present)
        self._codecs = {name: Codec(name, robot) for name in (*self.wiring.inputs.values(), *self.outputs())}
        for topic in self.outputs():
            publisher = self.make_publisher(self._codecs[topic].message_type, topic)
            self._publishers_by_topic[topic] = publisher
            self._barrier.watch(publisher, expected_readers(topic, self.present) - {self.wiring.name})
            if topic in PEOPLE_TOPICS:
                self._copies[topic] = self.make_publisher(self._codecs[topic].message_type, copy_of(topic))
                self._barrier.watch(self._copies[topic], {SIMULATOR} & self.present)
        table = nodes_with(self.present)
        readers = {n for topic in self.outputs() for n in expected_readers(topic, self.present) if n in table}
        self._absent = self.make_publisher(Header, ABSENT)
        self._barrier.watch(self._absent, readers)
        self.make_subscription(Header, ABSENT, self._receive_absent)
        if self.wiring.name != SIMULATOR:
            self.make_subscription(Header, RESET, self._receive_reset)
        for topic in self.lock.topics:
            self._listen(topic)

    def outputs(self) -> tuple[str, ...]:
        """Topics that the node publishes."""
        return tuple(self.wiring.outputs.values())

    def start(self) -> None:
        """Looks for the others; the work begins when all are found."""
        self._progress_at = self._told_at = time.monotonic()
        if self.started:
            self.run_ready_steps()
        else:
            self._barrier_timer.reset()

    def stop(self) -> None:
        """Keeps listening, so that nothing is missed when it goes on."""
        self._barrier_timer.cancel()

    def tear_down(self) -> None:
        """Removes component and endpoints; the run is over for this node."""
        for subscription in self._own_subscriptions:
            self.destroy_subscription(subscription)
        for publisher in self._own_publishers:
            self.destroy_publisher(publisher)
        self._own_subscriptions.clear()
        self._own_publishers.clear()
        self.lock = self._make_lock()
        self.started = False
        self.reset_at = None
        if hasattr(self.component, "close"):  # a physics engine does not end by itself
            self.component.close()
        self.component = None

    def make_publisher(self, message_type: type, topic: str) -> Any:
        """A lock-step publisher that goes with the configuration."""
        publisher = self.create_publisher(message_type, topic, LOCKSTEP)
        self._own_publishers.append(publisher)
        return publisher

    def make_subscription(self, message_type: type, topic: str, callback: Any, qos: Any = LOCKSTEP) -> Any:
        """A subscription to serialised messages that goes with the configuration."""
        subscription = self.create_subscription(message_type, topic, callback, qos, raw=True)
        self._own_subscriptions.append(subscription)
        return subscription

    def _listen(self, topic: str) -> None:
        if topic == CLOCK:
            from rosgraph_msgs.msg import Clock

            self.make_subscription(Clock, CLOCK, self._receive_clock)
            return
        codec = self._codecs[topic]
        subscription = self.make_subscription(
            codec.message_type,
            copy_of(topic) if topic in PEOPLE_TOPICS else topic,
            partial(self._receive, topic, codec.decode),
        )
        producer = PRODUCER[topic].name
        if producer not in self.present and self._barrier is not None:
            self._barrier.watch_stranger(subscription, producer)

    # Messages in.

    def _receive(self, topic: str, decode: Any, data: bytes) -> None:
        tick, rest = divmod(stamp_of(data), self.tick_ns)
        on_tick = tick if rest == 0 else None
        if on_tick is not None and not self.lock.needs(topic, on_tick):
            return
        try:
            sample = decode(data)
        except MessageError as error:
            self.reject(error)
            return
        if self.lock.put(topic, on_tick, sample):
            self.run_ready_steps()

    def _receive_clock(self, data: bytes) -> None:
        tick = stamp_of(data) // self.tick_ns
        if self.lock.needs(CLOCK, tick) and self.lock.put(CLOCK, tick, True):
            self.run_ready_steps()

    def _receive_absent(self, data: bytes) -> None:
        topic = str(deserialize_message(data, Header).frame_id)
        if topic in self.lock.topics and self.lock.put(topic, stamp_of(data) // self.tick_ns, None):
            self.run_ready_steps()

    def _receive_reset(self, data: bytes) -> None:
        self.reset_at = stamp_of(data) // self.tick_ns
        self._announcer.announce_reset(self.reset_at)
        self.run_ready_steps()

    def reset(self) -> None:
        """Begins anew: a fresh component, and nothing from before."""
        self.component = self.wiring.make(self.config, shared_robot(self.graph.urdf), self.graph.tick)

    def _reset_if_due(self) -> None:
        if self.reset_at is not None and self.lock.tick >= self.reset_at:
            self.lock.restart(self.reset_at)
            self.reset_at = None
            self.reset()

    def run_ready_steps(self) -> None:
        """Takes every step whose inputs are there."""
        self._reset_if_due()
        while self.running and self.lock.ready and self.exit_status is None and self.may_step():
            tick = self.lock.tick
            begin = time.perf_counter()
            try:
                self.step(tick, self.lock.take())
            except Exception as error:  # a component that breaks ends the run, and says where
                self.quit(1, f"{self.wiring.name} at tick {tick}: {type(error).__name__}: {error}")
                return
            self._steps += 1
            self._busy += time.perf_counter() - begin
            self._reset_if_due()
            if not self.lock.paced:  # a timer goes on: strangers must be heard in between
                return

    # Messages out.

    def publish(self, outputs: Any, tick: int) -> None:
        """Publishes every output that is there, and says of the others that they are not."""
        stamp = tick * self.tick_ns
        for name, topic in self.wiring.outputs.items():
            sample = getattr(outputs, name)
            if sample is not None:
                data = self._codecs[topic].encode(sample, stamp)
                if topic in self._copies:  # everybody may publish there: the copy is surely ours
                    self._copies[topic].publish(data)
                self._publishers_by_topic[topic].publish(data)
            elif topic in _READ_BY_NODES:
                header = Header(frame_id=topic)
                header.stamp.sec, header.stamp.nanosec = divmod(stamp, NANOSECONDS)
                self._absent.publish(bytes(CdrWriter(header).data))

    # Start barrier and watchdog.

    def _look_at_barrier(self) -> None:
        waiting = self._barrier.waiting_for() if self._barrier is not None else []
        waiting = waiting or self.still_waiting_for()
        now = time.monotonic()
        if not waiting:
            self._barrier_timer.cancel()
            self.started = True
            self._progress_at = now
            self._announcer.announce()
            self.barrier_passed()
            self.run_ready_steps()
        elif now - self._told_at > _TELL_EVERY:
            self._told_at = now
            self.logger.info(f"waiting for {'; '.join(waiting)}")

    def _watch(self) -> None:
        now = time.monotonic()
        if self._steps != getattr(self, "_steps_seen", -1) or not (self.started and self.running):
            self._steps_seen, self._progress_at = self._steps, now
            return
        waited = now - self._progress_at
        if waited >= _PATIENCE and (given_up := self.lock.give_up()):
            self._given_up += len(given_up)
            for missing in given_up:
                self.logger.warning(f"no {missing}: its newest message is held from now on")
            self.run_ready_steps()
        elif self.graph.watchdog and waited > self.graph.watchdog:
            self.stalled(waited, "; ".join(str(missing) for missing in self.lock.missing()))

    def stalled(self, waited: float, missing: str) -> None:
        """Nothing has come for longer than the watchdog allows."""
        if self._steps > 0:  # until then the simulator may wait for somebody's own node to be started
            self.tell_once(f"waiting for {missing}")

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return self._steps

    def _reconfigure(self, config: Any) -> None:
        self.config = config
        if self.component is not None:
            self.component.reconfigure(config)

    @property
    def stamp(self) -> int:
        """Time of the last step [ns]."""
        return max(0, self.lock.tick - self.wiring.period) * self.tick_ns

    def report(self) -> dict[str, float | int | str | bool]:
        """Rate, missed ticks, rejected messages, and what the component has to say."""
        steps, busy = self._steps, self._busy
        values: dict[str, float | int | str | bool] = {
            "tick": max(0, self.lock.tick - self.wiring.period),
            "rate [Hz]": self._rate.look(steps),
            "step_time [s]": busy / steps if steps else 0.0,
            "missed_ticks": self._given_up,
            "late_messages": self.lock.late,
            "stale_inputs": self.lock.stale,
            "rejected_messages": self.rejected,
        }
        if self.running and not self.started:
            values["warning"] = "waiting for the other nodes"
        if hasattr(self.component, "diagnostics"):
            values.update(self.component.diagnostics())
        return values
