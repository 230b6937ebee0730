"""What every node of the package has: lifecycle, self-start, shared parameters, diagnostics, exit status."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError
from follower_humanoid.graph.graph_config import GraphConfig
from follower_humanoid.ros.careful_services import make_careful
from follower_humanoid.ros.parameters import declare
from follower_humanoid.ros.qos import DIAGNOSTICS

_TELL_EVERY = 1.0  # wall time between two warnings about messages on one topic [s]
_LONGEST_WARNING = 400  # characters: a message may hold a name of any length
FAILED = 1
# The executor's wait without a time limit hears no signal. One with a limit looks at it only when
# it has nothing to do, so a busy executor is stopped by a future that completes.
REST = 0.1


class ManagedNode(LifecycleNode):
    """A lifecycle node that starts itself unless a manager does.

    Subclasses override `set_up`, `start`, `stop`, `tear_down` and `report`.

    Attributes:
        graph: Parameters shared by all nodes.
        exit_status: None while the node runs; the process ends once it is set.
        exit_reason: One line with the reason.
        when_over: Called once the status is set.
        only_one: False where several of the same name get along in one graph.
        hears_people: Whether messages come from outside the graph, and soon have to be heard.
    """

    only_one = True
    hears_people = False

    def __init__(self, name: str, **options: Any) -> None:
        """Declares the shared parameters.

        Raises:
            ConfigurationError: A parameter value cannot be used.
        """
        super().__init__(name, **options)
        self.graph: GraphConfig = declare(self, GraphConfig)
        self.present = self.graph.present
        self.tick_ns = round(self.graph.tick * NANOSECONDS)
        self.exit_status: int | None = None
        self.exit_reason = ""
        self.when_over: Callable[[], None] = lambda: None
        self.running = False
        self.rejected = 0
        self.logger: Any = cast(Any, self).get_logger()
        self._told: set[str] = set()
        self._rejections: dict[str, tuple[float, int]] = {}  # topic -> told at [s], how many not told since
        self._wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._accept_transitions_with_care()
        make_careful(self, self.reject)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", DIAGNOSTICS)
        self.make_timer(1.0, self._publish_diagnostics)
        self._starter = self.make_timer(0.0, self._start_itself)

    def set_up(self) -> None:
        """Makes what the node needs; nothing is published yet."""

    def start(self) -> None:
        """Begins to work."""

    def stop(self) -> None:
        """Pauses."""

    def tear_down(self) -> None:
        """Undoes `set_up`."""

    def report(self) -> dict[str, float | int | str | bool]:
        """Values for the diagnostics; `warning` or `error` sets the level and the text."""
        return {}

    @property
    def stamp(self) -> int:
        """Simulated time the node has come to [ns]."""
        return 0

    def quit(self, status: int, reason: str) -> None:
        """Ends the process soon; the first reason counts, but a failure takes the place of a good end."""
        if self.exit_status is None or (self.exit_status == 0 and status != 0):
            self.exit_status, self.exit_reason = status, reason
            if status == FAILED:
                self.logger.error(reason)
            self.when_over()

    def tell_once(self, text: str) -> None:
        """Warns, but not again with the same words."""
        if text not in self._told:
            self._told.add(text)
            self.logger.warning(text)

    def reject(self, error: Exception) -> None:
        """Counts a message that cannot be used and says why, at most once a second per topic."""
        self.rejected += 1
        topic, now = getattr(error, "topic", ""), time.monotonic()
        told_at, untold = self._rejections.get(topic, (-math.inf, 0))
        if now - told_at < _TELL_EVERY:
            self._rejections[topic] = (told_at, untold + 1)
            return
        self._rejections[topic] = (now, 0)
        more = f" ({untold} more before)" if untold else ""
        self.logger.warning(str(error)[:_LONGEST_WARNING] + more)

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return 0

    def wind_down(self) -> None:
        """The end is near: begin nothing new, but finish what has arrived."""

    def make_timer(self, period: float, callback: Callable[[], Any]) -> Any:
        """Calls back every so often by the wall's clock; period in [s]."""
        return self.create_timer(period, callback, clock=self._wall)

    def attend(self, seconds: float) -> bool:
        """Takes in what the node fetches itself, or waits for it so long [s]; False if there is nothing."""
        return False

    def rest(self) -> float:
        """How long the executor may have when the node has nothing to attend to [s]."""
        return REST

    def flush(self) -> int:
        """Sends what others had no room for; returns how many messages are left."""
        return 0

    def finish(self) -> None:
        """Last diagnostics before the node goes."""
        self.running = False
        self._publish_diagnostics()

    # Lifecycle transitions; rclpy swallows exceptions in them, so they are turned into an exit here.

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Makes endpoints and components."""
        return self._transition(self.set_up)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begins to work."""
        return self._transition(self.start, running=True)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Pauses; what the others get meanwhile is for `stop` to say."""
        return self._transition(self.stop, running=False)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Undoes the configuration."""
        return self._transition(self.tear_down, running=False)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ends the process."""
        self.running = False
        self.quit(0, "shut down by its lifecycle")
        return TransitionCallbackReturn.SUCCESS

    def _transition(self, action: Any, running: bool | None = None) -> TransitionCallbackReturn:
        try:
            if running is not None:
                self.running = running
            action()
        except ConfigurationError as error:
            self.running = False
            self.quit(BAD_CONFIGURATION, str(error))
            return TransitionCallbackReturn.FAILURE
        except Exception as error:  # whatever it is, the user must see it
            self.running = False
            self.quit(FAILED, f"{type(error).__name__}: {error}")
            return TransitionCallbackReturn.ERROR
        return TransitionCallbackReturn.SUCCESS

    def _accept_transitions_with_care(self) -> None:
        """Refuses a transition that the state does not know; rclpy would end the process."""
        service: Any = cast(Any, self)._service_change_state
        change = service.callback

        def change_if_possible(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except rclpy_implementation.RCLError as error:
                asked = request.transition.label or request.transition.id
                self.logger.warning(f"no transition {asked} now: {error}")
                response.success = False
                return response

        service.callback = change_if_possible

    def _start_itself(self) -> None:
        self._starter.cancel()
        untyped = cast(Any, self)
        if self.graph.autostart and untyped.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            untyped.trigger_activate()

    def _publish_diagnostics(self) -> None:
        values = self.report()
        name = self.get_fully_qualified_name()
        status = DiagnosticStatus(level=DiagnosticStatus.OK, name=name, message="running")
        status.hardware_id = self.get_namespace()
        if not self.running:
            status.message = "not running"
        for key, level in (("warning", DiagnosticStatus.WARN), ("error", DiagnosticStatus.ERROR)):
            if values.get(key):
                status.level, status.message = level, str(values[key])
        status.values = [KeyValue(key=key, value=_text(value)) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(self.stamp, NANOSECONDS)
        self._diagnostics.publish(message)


def _text(value: Any) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)


class Rate:
    """Steps per wall second between two looks."""

    def __init__(self) -> None:
        """Starts at nothing."""
        self._steps = 0
        self._at = time.monotonic()

    def look(self, steps: int) -> float:
        """The rate since the last look [Hz], given the steps so far."""
        now = time.monotonic()
        rate = (steps - self._steps) / max(now - self._at, 1e-9)
        self._steps, self._at = steps, now
        return rate
