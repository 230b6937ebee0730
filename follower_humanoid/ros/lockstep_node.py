"""A node of the wiring table in the lock-stepped graph: messages in by tick, messages out by tick."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from typing import Any

from rclpy.parameter import Parameter

from follower_humanoid.graph.lockstep import STALE, LockStep
from follower_humanoid.graph.wiring import SIMULATOR, NodeWiring, node_wiring
from follower_humanoid.ros.adjusted import AdjustedParameters
from follower_humanoid.ros.barrier import Announcer, Barrier
from follower_humanoid.ros.bus import Bus
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.inlet import Inlet
from follower_humanoid.ros.leaving import AHEAD, Attendance
from follower_humanoid.ros.managed_node import ManagedNode
from follower_humanoid.ros.outlet import NOTHING, Outlet
from follower_humanoid.ros.parameters import LiveConfig, declare
from follower_humanoid.ros.qos import LOCKSTEP
from follower_humanoid.ros.resets import Resets
from follower_humanoid.ros.shared_robot import shared_robot
from follower_humanoid.ros.starting import Starting
from follower_humanoid.ros.toll import Toll
from follower_humanoid.ros.watchdog import Watchdog

_SHORT_REST = 0.001


class LockStepNode(ManagedNode):
    """Endpoints, start barrier, watchdog and bookkeeping; subclasses say what a step does.

    Attributes:
        wiring: The node's row of the wiring table.
        component: What the node runs, once configured.
        lock: Which messages the next step waits for.
        bus: Connects the nodes of this process, if there are several.
        inlet, outlet: Bring messages in and out.
        resets: When everything begins anew.
        idle: Deactivated while the others go on.
        away: Left behind by the others, and not in step with them again.
        attendance: Who else has left.
        starting: Where it waits for the others before its first step.
    """

    def __init__(self, wiring: NodeWiring, bus: Bus | None = None, **options: Any) -> None:
        """Declares the component's parameters beside the shared ones.

        Args:
            wiring: The node's row of the wiring table.
            bus: Connects the nodes of this process; all must have been made before one is configured.
            options: For rclpy.

        Raises:
            ConfigurationError: A parameter value cannot be used.
        """
        super().__init__(wiring.name, **options)
        self.wiring = wiring = node_wiring(wiring.name, self.present)
        component_class = wiring.component_class()
        adjustable = hasattr(component_class, "reconfigure")
        self.config = declare(self, component_class.Config, adjustable)
        self._adjusted = AdjustedParameters(self) if adjustable else None
        if adjustable:
            LiveConfig(self, self.config, self._reconfigure)
        self.component: Any = None
        self.lock = self._make_lock()
        self.bus = bus
        self.inlet = Inlet(self)
        if bus is not None:
            bus.join(wiring.name, self.run_ready_steps)
        self.started = self.idle = self.away = False
        self.outlet: Outlet
        self.codecs: dict[str, Codec] = {}
        self._toll = Toll()
        self._announcer = Announcer(self)
        self.resets = Resets(self, self._announcer)
        self.attendance = Attendance(self, self._goes_on_without, self.reject)
        self.starting = Starting(self)
        self._watchdog = Watchdog(self)

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

    def readers_of_more(self) -> dict[str, list[Any]]:
        """Nodes that need the envelopes as such, not what is in them, each with what would serve it too."""
        return {}

    def shares_process(self, name: str) -> bool:
        """Whether another node is in this process."""
        return self.bus is not None and name in self.bus

    # Lifecycle.

    def set_up(self) -> None:
        """Makes the component, and at the first time the endpoints."""
        robot = shared_robot(self.graph.urdf)
        self.component = self.wiring.make(self.config, robot, self.graph.tick)
        if self.starting.barrier is not None:
            return
        self.starting.barrier = barrier = Barrier(self, self.present)
        self.codecs = {
            topic: Codec(topic, robot)
            for topic in (*self.wiring.inputs.values(), *self.wiring.outputs.values())
        }
        self.outlet = Outlet(self, self.codecs)
        self.outlet.watch(barrier, self.readers_of_more())
        if self._adjusted is not None:
            self._adjusted.open(barrier)
        self.inlet.open(self.codecs, barrier)
        if self.wiring.name != SIMULATOR:
            self.resets.hear()

    def start(self) -> None:
        """Looks for the others; the work begins when all are found."""
        self._watchdog.calm()
        self.idle = False
        if self.started:
            self.run_ready_steps()
        else:
            self.starting.begin()

    def stop(self) -> None:
        """Keeps step with the others, but says at each tick that it has nothing to say."""
        self.starting.hold()
        self.idle = self.started
        self.run_ready_steps()

    def come_back(self, tick: int) -> None:
        """Joins the others again, after an absence, a little ahead of what it hears of them."""
        if not self.away:
            return
        self.away = False
        self.lock.restart(tick + AHEAD)
        self.resets.begin_if_due()
        self.attendance.come_back(self.lock.tick)

    def _goes_on_without(self, name: str, tick: int) -> None:
        if self.lock.leave(name, tick):
            self.run_ready_steps()

    def tear_down(self) -> None:
        """Removes the component; the endpoints stay, for the node keeps step with the others."""
        if hasattr(self.component, "close"):  # a physics engine does not end by itself
            self.component.close()
        self.component = None

    def make_publisher(self, message_type: type, topic: str) -> Any:
        """A lock-step publisher."""
        return self.create_publisher(message_type, topic, LOCKSTEP)

    def make_subscription(self, message_type: type, topic: str, callback: Any, qos: Any = LOCKSTEP) -> Any:
        """A subscription to serialised messages."""
        return self.create_subscription(message_type, topic, callback, qos, raw=True)

    # Steps.

    @property
    def subscriptions(self) -> Iterator[Any]:
        """What an executor has to look after: not what the node fetches itself."""
        fetched = self.inlet.mailbox.subscriptions if hasattr(self, "inlet") else []
        return (s for s in super().subscriptions if s not in fetched)

    def rest(self) -> float:
        """Short where a step that the executor brings about makes the node wait for messages again [s]."""
        return _SHORT_REST if self.inlet.mailbox.subscriptions else super().rest()

    def attend(self, seconds: float) -> bool:
        """Waits for what others send, takes it in and steps."""
        attended = self.inlet.mailbox.fetch(seconds)
        if attended:
            self.run_ready_steps()
        return attended

    def reset(self) -> None:
        """Begins anew: a fresh component, and nothing from before."""
        self.component = self.wiring.make(self.config, shared_robot(self.graph.urdf), self.graph.tick)

    def _reset_if_due(self) -> None:
        if (tick := self.resets.begin_if_due()) is not None:
            self.lock.restart(tick)

    def run_ready_steps(self) -> None:
        """Takes every step whose inputs are there."""
        self._reset_if_due()
        while (self.running or self.idle) and self.lock.ready and self.exit_status is None:
            if not self.may_step():
                return
            tick = self.lock.tick
            begin = time.perf_counter()
            try:
                samples = self.lock.take()
                if self.idle:
                    self.outlet.send(NOTHING, tick)
                else:
                    self.step(tick, samples)
            except Exception as error:  # a component that breaks ends the run, and says where
                self.quit(1, f"{self.wiring.name} at tick {tick}: {type(error).__name__}: {error}")
                return
            self._toll.add(time.perf_counter() - begin)
            self._reset_if_due()
            if not self.lock.paced:  # a timer goes on: strangers must be heard in between
                return

    def publish(self, outputs: Any, tick: int) -> None:
        """Publishes every output that is there, and says of the others that they are not."""
        self.outlet.send(outputs, tick)

    # Start and watchdog.

    def all_found(self) -> None:
        """Every message will arrive: the work begins."""
        self.started = True
        self._watchdog.calm()
        self.outlet.look()
        if self._adjusted is not None:
            self._adjusted.tell()
        self._toll.begin()
        self._announcer.announce()
        self.barrier_passed()
        self.run_ready_steps()

    def catch_up(self) -> None:
        """The others have gone on without this node, further than it can follow: it joins them again."""
        self.logger.warning(f"left behind at tick {self.lock.tick}: going on where the others are")
        self.away = True
        self.attendance.leave(self.lock.tick)

    def stalled(self, waited: float, missing: str) -> None:
        """Nothing has come for longer than the watchdog allows."""
        if self.steps > 0:  # until then the simulator may wait for somebody's own node to be started
            self.tell_once(f"waiting for {missing}")

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return self._toll.steps

    def flush(self) -> int:
        """Sends what others had no room for."""
        return self.outlet.flush() if hasattr(self, "outlet") else 0

    def finish(self) -> None:
        """Takes no further step."""
        self.idle = False
        self.inlet.mailbox.close()
        super().finish()

    def _reconfigure(self, config: Any, changed: list[Parameter]) -> None:
        self.config = config
        if self.component is not None:
            self.component.reconfigure(config)
        if self._adjusted is not None:
            self._adjusted.note(changed)

    @property
    def stamp(self) -> int:
        """Time of the last step [ns]."""
        return max(0, self.lock.tick - self.wiring.period) * self.tick_ns

    def report(self) -> dict[str, float | int | str | bool]:
        """Rate, missed ticks, rejected messages, and what the component has to say."""
        values: dict[str, float | int | str | bool] = {
            "tick": max(0, self.lock.tick - self.wiring.period),
            **self._toll.report(self.lock.tick),
            "missed_ticks": self._watchdog.given_up,
            "late_messages": self.lock.late,
            "wrong_ticks": self.lock.strange,
            "stale_inputs": self.lock.stale,
            "rejected_messages": self.rejected,
            "lost_messages": self.outlet.lost if hasattr(self, "outlet") else 0,
        }
        if self.running and not self.started:
            values["warning"] = "waiting for the other nodes"
        if hasattr(self.component, "diagnostics"):
            values.update(self.component.diagnostics())
        return values
