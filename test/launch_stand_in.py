"""Takes the place of ROS 2's `launch` where that is not installed: as much of it as the launch file uses.

It checks what the real one checks (names, defaults, choices of arguments) and really runs the processes, but
it knows no output formats, no respawning and no other actions. Names and keywords are those of `launch`.
"""

from __future__ import annotations

import subprocess
import sys
import types
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str | None = field(default=None, kw_only=True)
    description: str = field(default="", kw_only=True)
    choices: Sequence[str] | None = field(default=None, kw_only=True)

    def execute(self, context: Context) -> None:
        value = context.launch_configurations.setdefault(self.name, self.default_value)
        if value is None:
            raise RuntimeError(f"Required launch argument '{self.name}' was not provided.")
        if self.choices is not None and value not in self.choices:
            raise RuntimeError(f"Argument '{self.name}' provided value '{value}' is not valid.")


@dataclass
class LaunchConfiguration:
    variable_name: str

    def perform(self, context: Context) -> str:
        return context.launch_configurations[self.variable_name]


@dataclass
class Shutdown:
    reason: str = field(default="reason not given", kw_only=True)


@dataclass
class EmitEvent:
    event: Any = field(kw_only=True)

    def execute(self, context: Context) -> None:
        assert isinstance(self.event, Shutdown)
        context.shutdown = self.event.reason


@dataclass
class OpaqueFunction:
    function: Callable[..., Any] = field(kw_only=True)

    def execute(self, context: Context) -> None:
        for entity in self.function(context) or ():
            entity.execute(context)


@dataclass
class ExecuteProcess:
    cmd: Sequence[str] = field(kw_only=True)
    output: str = field(default="log", kw_only=True)
    on_exit: Sequence[Any] = field(default=(), kw_only=True)

    def execute(self, context: Context) -> None:
        assert all(isinstance(word, str) and word for word in self.cmd), self.cmd
        context.processes.append(self)


@dataclass
class LaunchDescription:
    entities: Sequence[Any]


@dataclass
class Context:
    """What a launch knows.

    Attributes:
        launch_configurations: Name → value.
        processes: What is to be started.
        shutdown: Why the launch is over; None while it goes on.
    """

    launch_configurations: dict[str, str]
    processes: list[ExecuteProcess] = field(default_factory=list)
    shutdown: str | None = None


def launched(description: Any, arguments: dict[str, str]) -> Context:
    """Visits the description as `ros2 launch` does; processes are collected and not started."""
    declared = {e.name for e in description.entities if isinstance(e, DeclareLaunchArgument)}
    assert set(arguments) <= declared
    context = Context(dict(arguments))
    for entity in description.entities:
        entity.execute(context)
    return context


def run(process: ExecuteProcess, context: Context, **options: Any) -> subprocess.CompletedProcess[str]:
    """Runs one of its processes to the end, and does what is to be done then."""
    done = subprocess.run(process.cmd, text=True, capture_output=True, check=False, **options)
    for entity in process.on_exit:
        entity.execute(context)
    return done


def installed(patch: Any) -> None:
    """Puts the stand-in where `import launch` finds it."""
    parts = {
        "launch": [LaunchDescription],
        "launch.actions": [DeclareLaunchArgument, EmitEvent, ExecuteProcess, OpaqueFunction],
        "launch.events": [Shutdown],
        "launch.substitutions": [LaunchConfiguration],
    }
    for name, members in parts.items():
        module = types.ModuleType(name)
        for member in members:
            setattr(module, member.__name__, member)
        patch.setitem(sys.modules, name, module)
