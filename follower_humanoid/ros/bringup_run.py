"""One run from the first process to the last: start, watch, end, sum up."""

from __future__ import annotations

import math
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import yaml
from lifecycle_msgs.msg import Transition
from rclpy.utilities import ok, try_shutdown

from follower_humanoid.compile import import_components
from follower_humanoid.graph.graph_config import RECORDER, VIEWER
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.claim import Claim, already_runs
from follower_humanoid.ros.crew import Crew
from follower_humanoid.ros.director import Director
from follower_humanoid.ros.lines import BORN_WITH, line_pairs
from follower_humanoid.ros.outcome import ENDED, End, Outcome, judge
from follower_humanoid.ros.run_plan import RunPlan
from follower_humanoid.ros.spin import StopSignal, start_ros
from follower_humanoid.ros.status import StatusLine, has_begun, summary_text
from follower_humanoid.ros.transport import choose_network

COMPOSED = "composed"
_LONGEST_PREPARATION = 600.0  # for a slow machine to compile the inner loops, once [s]
_LONGEST_START = 60.0
_LONGEST_STOP = 20.0  # s, for a slow disk; at a signal: _HASTE
_HASTE = 2.6
_LOOK_AROUND = 0.25  # until those that run already, on other machines or by hand, are known [s]
_SILENT = 3.0  # without diagnostics for that long a node counts as stuck [s]


class BringupRun:
    """Starts the planned nodes and stays with them to the end."""

    def __init__(self, plan: RunPlan) -> None:
        """Args: the checked plan."""
        self._plan = plan
        if not plan.options.composed:  # separate nodes share what is imported before they are forked
            import_components()  # may compile for a minute, in which a signal still ends everything at once
        self._stop = StopSignal()
        self._line = StatusLine()
        self._folder = Path(tempfile.mkdtemp(prefix=f"follower_humanoid_{os.getpid()}_"))
        self._parameter_file = self._folder / "parameters.yaml"
        self._crew = Crew()
        self._director: Director
        self._active_since = math.inf  # from then on a sign of life is due

    def run(self) -> int:
        """Runs to the end; returns the exit status."""
        choose_network(self._plan.options.open)
        arguments = self._ros_arguments()
        with ExitStack() as names:  # ours until the last node has ended
            try:
                self._fork_nodes([*arguments, "--params-file", str(self._parameter_file)])
                start_ros(arguments)
                self._director = director = Director()
                names.enter_context(Claim(director.domain, director.namespace, self._claimed))
                return self._start_and_watch()
            finally:
                self._crew.kill()
                if ok():
                    self._director.close()
                try_shutdown()
                shutil.rmtree(self._folder, ignore_errors=True)

    @property
    def _claimed(self) -> list[str]:
        """Whose names nobody else may have."""
        return [*self._plan.nodes, *([RECORDER] if self._plan.options.bag else [])]

    def _ros_arguments(self) -> list[str]:
        namespace = self._plan.options.namespace
        remap = ["-r", f"__ns:=/{namespace}"] if namespace else []
        return ["--ros-args", *remap, *self._plan.ros_args]

    def _start_and_watch(self) -> int:
        plan, director = self._plan, self._director
        director.spin(_LOOK_AROUND)
        self._refuse_company(0)
        if plan.options.bag:
            about = self._folder / "about.yaml"
            about.write_text(yaml.safe_dump(plan.about, allow_unicode=True), encoding="utf-8")
            plan.parameters[RECORDER]["about"] = str(about)
        self._parameter_file.write_text(plan.parameter_file(director.namespace), encoding="utf-8")
        end = self._await_crew() or self._lead_to_activity()
        self._active_since = time.monotonic()
        while end is None:
            director.spin(0.05)
            self._line.show(director.values)
            end = self._end_in_sight()
        return self._end(end)

    def _end_in_sight(self) -> End | None:
        if self._director.values.get(SIMULATOR, {}).get(ENDED):
            return End(Outcome.ENDED)  # its process waits to be dismissed
        if self._stop.asked:
            return End(Outcome.ASKED)
        lost = self._crew.ended()
        return None if lost is None else End(Outcome.LOST, lost)

    def _fork_nodes(self, arguments: list[str]) -> None:
        """Before ROS runs in this process; they wait for their parameters.

        The composed process imports its components itself, while ROS starts here.
        """
        plan = self._plan
        composed = plan.options.composed
        BORN_WITH.lay(line_pairs(plan.nodes, composed, plan.options.bag is not None), composed)
        if plan.options.composed:
            nodes = ["--nodes", ",".join(plan.nodes)]
            self._crew.fork(COMPOSED, [*nodes, *arguments], plan.nodes, prepare=import_components)
        else:
            for name in plan.nodes:
                self._crew.fork(name, arguments, (name,))
        if plan.options.bag:
            self._crew.fork(RECORDER, arguments, (RECORDER,))
        if plan.options.view:
            self._crew.fork(VIEWER, arguments, (), aside=True)
        BORN_WITH.keep(())

    def _await_crew(self) -> End | None:
        """Lets the nodes begin once all are there; returns an end that came before that."""
        late = f"nodes still not imported after {_LONGEST_PREPARATION:.0f} s"
        end = self._wait(
            lambda: "" if self._crew.prepared else late, time.monotonic() + _LONGEST_PREPARATION
        )
        if end is None:
            self._crew.begin()
        return end

    def _lead_to_activity(self) -> End | None:
        """Configures and activates everyone, the simulator last; returns an end that came too early.

        The recorder is configured after the others, so that no bag is begun for a graph that
        cannot be made.
        """
        workers = [name for name in self._plan.nodes if name != SIMULATOR]
        recorder = [RECORDER] if self._plan.options.bag else []
        simulator = [SIMULATOR] if SIMULATOR in self._plan.nodes else []
        stages = (
            ([*simulator, *workers], Transition.TRANSITION_CONFIGURE),
            (recorder, Transition.TRANSITION_CONFIGURE),
            ([*recorder, *workers], Transition.TRANSITION_ACTIVATE),
            (simulator, Transition.TRANSITION_ACTIVATE),
        )
        deadline = time.monotonic() + _LONGEST_START
        for nodes, transition in stages:
            self._director.begin(nodes, transition)
            self._refuse_company(1)
            if (end := self._wait(self._not_ready, deadline)) is not None:
                return end
        return None

    def _not_ready(self) -> str:
        unanswered = ", ".join(self._director.unanswered())
        return unanswered and f"not ready after {_LONGEST_START:.0f} s: {unanswered}"

    def _wait(self, complaint: Callable[[], str], deadline: float) -> End | None:
        """Until there is nothing to complain about; returns an end that came before that, or lateness."""
        while text := complaint():
            self._director.spin(0.02)
            if (end := self._end_in_sight()) is not None:
                return end
            if time.monotonic() > deadline:
                self._say(text)
                return End(Outcome.LATE)
        return None

    def _refuse_company(self, own: int) -> None:
        """Two graphs under the same names would command, and end, each other's nodes.

        Args:
            own: How many of each node are ours.

        Raises:
            ConfigurationError: There are more.
        """
        found = self._director.more_than(own, self._claimed)
        if found:
            raise already_runs(self._director.domain, self._director.namespace, found)

    def _end(self, end: End) -> int:
        """Ends everyone, sums up, and says what the run came to."""
        stuck = list(self._silent_nodes())
        begin = time.monotonic()
        self._crew.stop(lambda: self._latest_stop(begin), self._director.spin, last=RECORDER)
        self._director.spin(0.05)
        self._line.end()
        values = dict(self._director.values)
        told = values.get(SIMULATOR, {}), stuck, self._recorder_status(), values.get(RECORDER, {})
        status, words = judge(end, *told)
        for text in words:
            self._say(text)
        self._sum_up(values, status)
        return status

    def _sum_up(self, values: dict[str, dict[str, str]], status: int) -> None:
        """Says what the run came to; of one that has not begun, where its bag is at most."""
        bag = self._plan.options.bag
        kept = bag if bag and bag.exists() else None
        if has_begun(values, SIMULATOR in self._plan.nodes):
            values[RECORDER] = {"bag": str(kept)} if kept else {}
            summary = summary_text(values)
            if summary:
                print(f"the run came to this:\n{summary}", flush=True)
        elif kept or status == 0:
            print(f"no tick was taken{f'; bag: {kept}' if kept else ''}", flush=True)

    def _latest_stop(self, begin: float) -> float:
        """When patience ends: soon if a signal asked, at the end of a run once the bag is written."""
        return self._stop.asked_at + _HASTE if self._stop.asked else begin + _LONGEST_STOP

    def _recorder_status(self) -> int | None:
        """How the recorder ended; None where no bag was begun."""
        bag = self._plan.options.bag
        if bag is None or not bag.exists():
            return None
        return next((m.process.returncode for m in self._crew.members if m.name == RECORDER), None)

    def _silent_nodes(self) -> Iterator[str]:
        now, heard = time.monotonic(), self._director.heard_at
        return (
            name for name in self._plan.nodes if now - heard.get(name, self._active_since) > _SILENT
        )

    def _say(self, text: str) -> None:
        self._line.end()
        print(text, file=sys.stderr, flush=True)
