"""The viewer in the graph: it observes, and publishes what people at the page do."""

from __future__ import annotations

import queue
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger

from follower_humanoid.core.samples import Array
from follower_humanoid.graph.graph_config import LEADER, RECORDER, VIEWER
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.director import reports_in
from follower_humanoid.ros.displays import Displays
from follower_humanoid.ros.leading import Leading
from follower_humanoid.ros.managed_node import ManagedNode
from follower_humanoid.ros.newest import Newest
from follower_humanoid.ros.outcome import ENDED
from follower_humanoid.ros.parameters import declare
from follower_humanoid.ros.qos import DIAGNOSTICS
from follower_humanoid.ros.shared_robot import shared_robot
from follower_humanoid.viewer.config import ViewerConfig
from follower_humanoid.viewer.moment import Moment, TrailKeeper
from follower_humanoid.viewer.page import Page
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.speedometer import Speedometer
from follower_humanoid.viewer.tape import SHOWN

_PUSHING = 0.005  # wall time between two looks at the clock during a push [s]
_MISSING = 3.0  # wall time without diagnostics after which a node counts as missing [s]


class ViewerNode(ManagedNode):
    """Looks at the graph some thirty times a second, while somebody looks at the page."""

    only_one = False
    _newest: Newest | None = None

    def __init__(self, **options: Any) -> None:
        """Declares the parameters.

        Raises:
            ConfigurationError: A parameter value cannot be used.
        """
        super().__init__(VIEWER, **options)
        self.config = declare(self, ViewerConfig)
        self._orders: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._trail, self._speed = TrailKeeper(), Speedometer()
        self._page: Page | None = None
        self._reports: dict[str, dict[str, str]] = {}
        self._heard: dict[str, float] = {}
        self._begun = self._moved = time.monotonic()
        self._frames = 0
        self._timer = self.make_timer(1.0 / self.config.rate, self._visit)
        self._timer.cancel()
        self._push_timer = self.make_timer(_PUSHING, self._push_on)
        self._push_timer.cancel()

    @property
    def subscriptions(self) -> Iterator[Any]:
        """What an executor has to look after: not what is emptied by hand."""
        own = set(self._newest.subscriptions) if self._newest else set()
        return (s for s in super().subscriptions if s not in own)

    def set_up(self) -> None:
        """Opens the page and listens."""
        robot = shared_robot(self.graph.urdf)
        self._newest = Newest(self, SHOWN, robot, self.reject)
        self._leading = Leading(self, robot)
        self._reset = self.create_client(Trigger, "reset")
        self._listener = self.create_subscription(
            DiagnosticArray, "/diagnostics", self._hear, DIAGNOSTICS, raw=True
        )
        self._displays = Displays(self, robot.urdf)
        if self.config.page:
            self._page = Page(self.config, Skeleton(robot.urdf), self._push_asked, self._reset_asked)
            print(f"viewer: {self._page.address}", file=sys.stderr, flush=True)

    def start(self) -> None:
        """Begins to look."""
        self._timer.reset()

    def stop(self) -> None:
        """Looks no more, and lets go."""
        self._timer.cancel()
        self._leading.let_go(self.stamp)

    def tear_down(self) -> None:
        """Closes the page."""
        if self._newest is not None:
            self._newest.close()
        self._close()

    def finish(self) -> None:
        """Lets go and says a last word."""
        if self._newest is not None:
            self._leading.let_go(self.stamp)
        self._close()
        super().finish()

    @property
    def stamp(self) -> int:
        """Time of the state that is shown [ns]."""
        return max(self._newest.stamp, 0) if self._newest is not None else 0

    def report(self) -> dict[str, float | int | str | bool]:
        """Where the page is, and how many pictures were drawn."""
        address = self._page.address if self._page is not None else ""
        return {"address": address, "pictures": self._frames}

    def _visit(self) -> None:
        while not self._orders.empty():
            self._orders.get()()
        page, newest = self._page, self._newest
        if newest is None:
            return
        watched = page is not None and page.watched
        now = time.monotonic()
        self._listen_while_needed(newest, watched or self._displays.wanted, now)
        if not newest.listening:
            self._leading.pull({}, self.stamp)
            return
        before = newest.stamp
        if newest.look("joint_states"):
            self._moved = now
            if newest.stamp < before:  # another run
                self._trail.forget()
        moment = self._moment(now)
        self._displays.show(moment)
        if page is not None and watched:
            page.show(moment, self._trail.add)
            self._frames += 1
        self._leading.pull(page.forces() if page is not None else {}, self.stamp)

    def _listen_while_needed(self, newest: Newest, needed: bool, now: float) -> None:
        """Who publishes is not troubled while nobody looks."""
        if needed and not newest.listening:
            newest.listen()
            self._moved = now
        elif not needed and newest.listening:
            newest.close()
            newest.forget()

    def _moment(self, now: float) -> Moment:
        samples = self._newest.samples if self._newest is not None else {}
        speed = self._speed.look(self.stamp / 1e9, now)
        missing = tuple(sorted(self._missing(now)))
        return Moment(self.stamp / 1e9, samples, self._reports, missing, now - self._moved, speed)

    def _missing(self, now: float) -> Iterator[str]:
        if now - self._begun < 2 * _MISSING:
            return
        for name in self.present - {RECORDER}:
            if name == LEADER and name not in self._heard:
                continue  # people lead
            if now - self._heard.get(name, self._begun) > _MISSING:
                yield name

    def _hear(self, data: bytes) -> None:
        for name, values in reports_in(data, self.get_namespace()).items():
            self._reports[name] = values
            self._heard[name] = time.monotonic()

    def _push_asked(self, impulse: Array) -> None:
        def begin() -> None:
            self._leading.push.begin(impulse, self.stamp / 1e9)
            self._push_timer.reset()

        self._orders.put(begin)

    def _push_on(self) -> None:
        if self._newest is not None:
            self._newest.look("joint_states")
        self._leading.go_on_pushing(self.stamp)
        if not self._leading.push.active:
            self._push_timer.cancel()

    def _reset_asked(self) -> None:
        def ask() -> None:
            self._reset.call_async(Trigger.Request())

        self._orders.put(ask)

    def _close(self) -> None:
        page, self._page = self._page, None
        if page is not None:
            ended = self._reports.get(SIMULATOR, {}).get(ENDED, "")
            page.close(f"The run is over: {ended}." if ended else "The viewer was stopped.")
