"""One run from the first process to the last: start, watch, end, sum up."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import rclpy
import yaml
from lifecycle_msgs.msg import Transition
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import ok, try_shutdown

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.resources import node_command
from follower_humanoid.ros.bringup_options import VIEWER
from follower_humanoid.ros.crew import Crew, Member, how_it_ended
from follower_humanoid.ros.director import Director
from follower_humanoid.ros.graph_config import RECORDER
from follower_humanoid.ros.managed_node import BAD_CONFIGURATION, FAILED
from follower_humanoid.ros.quiet import quiet_stderr
from follower_humanoid.ros.run_plan import RunPlan
from follower_humanoid.ros.simulator_node import FELL
from follower_humanoid.ros.spin import StopSignal
from follower_humanoid.ros.status import StatusLine, summary_text
from follower_humanoid.ros.transport import roomy_transport

COMPOSED = "composed"
_LONGEST_START = 60.0
_LONGEST_STOP = 2.6
_SILENT = 3.0  # without diagnostics for that long a node counts as stuck [s]


class BringupRun:
    """Starts the planned nodes and stays with them to the end."""

    def __init__(self, plan: RunPlan) -> None:
        """Args: the checked plan."""
        self._plan = plan
        self._stop = StopSignal()
        self._line = StatusLine()
        self._folder = Path(tempfile.mkdtemp(prefix="follower_humanoid_"))
        self._crew = Crew(roomy_transport(self._folder))
        self._director: Director

    def run(self) -> int:
        """Runs to the end; returns the exit status."""
        # Only this machine's own graph, unless the user has said otherwise.
        if not any(name in os.environ for name in ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS")):
            os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        arguments = self._ros_arguments()
        try:
            try:
                with quiet_stderr():
                    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
            except Exception as error:  # rclpy has no common type for what it finds wrong here
                reason = re.sub(r", at \S+", "", " ".join(str(error).split()))
                raise ConfigurationError(f"--ros-args {' '.join(self._plan.ros_args)}: {reason}") from None
            self._director = Director()
            return self._start_and_watch(arguments)
        finally:
            self._crew.kill()
            if ok():
                self._director.close()
            try_shutdown()
            shutil.rmtree(self._folder, ignore_errors=True)

    def _ros_arguments(self) -> list[str]:
        namespace = self._plan.options.namespace
        remap = ["-r", f"__ns:=/{namespace}"] if namespace else []
        return ["--ros-args", *remap, *self._plan.ros_args]

    def _start_and_watch(self, arguments: list[str]) -> int:
        plan, director = self._plan, self._director
        parameters = self._folder / "parameters.yaml"
        if plan.options.bag:
            about = self._folder / "about.yaml"
            about.write_text(yaml.safe_dump(plan.about, allow_unicode=True), encoding="utf-8")
            plan.parameters[RECORDER]["about"] = str(about)
        parameters.write_text(plan.parameter_file(director.namespace), encoding="utf-8")
        self._start_processes([*arguments, "--params-file", str(parameters)])
        ended = self._lead_to_activity()
        while ended is None and not self._stop.asked:
            director.spin(0.05)
            self._line.show(director.values)
            ended = self._crew.ended() or self._finished()
        return self._end(ended)

    def _finished(self) -> Member | None:
        """The simulator's process once it has said that the run is over; it waits to be dismissed."""
        if not self._director.values.get(SIMULATOR, {}).get("ended"):
            return None
        return next((m for m in self._crew.members if SIMULATOR in m.nodes), None)

    def _start_processes(self, arguments: list[str]) -> None:
        plan = self._plan
        if plan.options.composed:
            names = ",".join(plan.nodes)
            command = [*node_command(COMPOSED), "--nodes", names, *arguments]
            self._crew.start(COMPOSED, command, plan.nodes)
        else:
            for name in plan.nodes:
                self._crew.start(name, [*node_command(name), *arguments], (name,))
        if plan.options.bag:
            self._crew.start(RECORDER, [*node_command(RECORDER), *arguments], (RECORDER,))
        if plan.options.view:
            self._crew.start(VIEWER, [*node_command(VIEWER), *arguments], ())

    def _lead_to_activity(self) -> Member | None:
        """Configures and activates everyone, the simulator last; returns who ended too early.

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
            while unanswered := self._director.unanswered():
                self._director.spin(0.02)
                if self._stop.asked:
                    return None
                if (ended := self._crew.ended()) is not None:
                    return ended
                if time.monotonic() > deadline:
                    self._say(f"not ready after {_LONGEST_START:.0f} s: {', '.join(unanswered)}")
                    return next(m for m in self._crew.members if set(unanswered) & set(m.nodes))
        return None

    def _end(self, ended: Member | None) -> int:
        """Ends everyone, sums up, and says what the run came to."""
        asked = self._stop.asked and ended is None
        stuck = list(self._silent_nodes())
        self._crew.stop(time.monotonic() + _LONGEST_STOP, self._director.spin, last=RECORDER)
        self._director.spin(0.05)
        self._line.end()
        status = self._status(ended, asked, stuck)
        values = dict(self._director.values)
        if self._plan.options.bag:
            values[RECORDER] = {"bag": str(self._plan.options.bag)}
        text = summary_text(values)
        if text:
            print(f"the run came to this:\n{text}", flush=True)
        return status

    def _status(self, ended: Member | None, asked: bool, stuck: list[str]) -> int:
        if ended is None or asked:
            return 0
        status = ended.process.returncode
        reason = self._director.values.get(SIMULATOR, {}).get("ended", "")
        if SIMULATOR in ended.nodes and status in (0, FELL):
            if status == FELL:
                self._say(reason or "the robot fell")
            return int(status)
        if status == BAD_CONFIGURATION:
            return BAD_CONFIGURATION  # the node has said why
        if SIMULATOR in ended.nodes and status == FAILED and reason:
            self._say(reason)
            if stuck:
                self._say(f"lost: {', '.join(stuck)} (no sign of life)")
            return FAILED
        how = how_it_ended(status) if status is not None else "does not answer"
        nodes = "" if ended.nodes == (ended.name,) else f" with {', '.join(ended.nodes)}"
        self._say(f"lost: {ended.name}{nodes}, {how}")
        return FAILED

    def _silent_nodes(self) -> Iterator[str]:
        now = time.monotonic()
        return (
            name for name in self._plan.nodes if now - self._director.heard_at.get(name, now) > _SILENT
        )

    def _say(self, text: str) -> None:
        self._line.end()
        print(text, file=sys.stderr, flush=True)
