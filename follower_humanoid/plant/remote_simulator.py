"""A simulator in a process of its own: physics and controllers each have a processor.

`serve` is what that process does, `RemoteSimulator` is the component as a node has it. Both are exactly as
far as each other: of what goes to and fro one sends, and the other waits for it.
"""

from __future__ import annotations

import pickle
import socket
import struct
import time
from contextlib import suppress
from typing import Any

from follower_humanoid.core.sample_bytes import packed, unpacked
from follower_humanoid.errors import ConfigurationError, FollowerError, PhysicsError
from follower_humanoid.plant.falls import Fall
from follower_humanoid.plant.held_place import knows_frame
from follower_humanoid.plant.simulator import (
    Simulator,
    SimulatorConfig,
    SimulatorInputs,
    SimulatorOutputs,
)
from follower_humanoid.robot.model import RobotModel

PHYSICS_CPU = "physics_cpu_per_tick [s]"
_IT = "the process that does the physics"
_LARGEST = 1 << 16  # bytes of one message
_TIMEOUT = struct.Struct("@ll")  # timeval: whole seconds, and microseconds
_RAISED: dict[str, type[FollowerError]] = {
    error.__name__: error for error in (ConfigurationError, PhysicsError)
}


class RemoteSimulator:
    """A `Simulator` at the other end of a line; `advance` returns while the physics goes on.

    Attributes:
        fall: The first fall, as far as it has been heard of.
        voltage_limit: Of the motors [V].
    """

    def __init__(
        self, end: socket.socket, patience: float, config: SimulatorConfig, urdf: str, robot: RobotModel,
        period: float,
    ) -> None:  # fmt: skip
        """The robot standing at time 0.

        Args:
            end: Ours of the line; at the other one somebody serves.
            patience: How long an answer may take once it is made [s].
            config, period: See `Simulator`.
            urdf: The robot's description as `RobotModel` takes it.
            robot: The model made from it.

        Raises:
            ConfigurationError: See `Simulator`.
            PhysicsError: There is no answer.
        """
        self._end, self._patience, self._robot = end, patience, robot
        self.voltage_limit = config.motors.chosen().voltage_limit
        self.fall: Fall | None = None
        self._under_way = False
        self._error: FollowerError | None = None
        self._outputs: SimulatorOutputs
        self._told: dict[str, float | int | str] = {}
        self._wait_for(0.0)  # however long that takes: whoever starts us looks at the clock
        self._begin("make", config, urdf, period)
        self.observe()
        self._wait_for(patience)

    def advance(self, inputs: SimulatorInputs) -> None:
        """Begins a control tick.

        Raises:
            PhysicsError: See `observe`.
        """
        self.observe()
        self._begin("advance", *packed(inputs))

    def reset(self) -> None:
        """Takes the place of a control tick: at the next one the robot is back on its feet."""
        self.observe()
        self._begin("reset")

    def observe(self) -> SimulatorOutputs:
        """The state of the current tick, once it is reached.

        Raises:
            PhysicsError: See `Simulator.advance`; or there is no answer. From then on it stays at that.
        """
        self._settle()
        if self._error is not None:
            raise self._error
        return self._outputs

    def knows_frame(self, name: str) -> bool:
        """True for a name that a wrench's `frame` may have."""
        return knows_frame(self._robot, name)

    def diagnostics(self) -> dict[str, float | int | str]:
        """See `Simulator`, and the processor time that its process has used per tick [s].

        What it said last where there is no answer: `observe` raises that.
        """
        self._settle()
        told = self._asked("diagnostics")
        if told is not None:
            self._told = told
        return self._told

    def close(self) -> None:
        """Closes its world; another one can be made on the same line."""
        self._settle()
        self._asked("close")

    def _begin(self, call: str, *arguments: Any) -> None:
        self._send(call, *arguments)
        self._under_way = True

    def _settle(self) -> None:
        if self._under_way:
            self._under_way = False
            answer = self._answer()
            if answer is not None:
                layout, data, self.fall = answer
                self._outputs = SimulatorOutputs(*unpacked(layout, data))

    def _asked(self, call: str) -> Any:
        self._send(call)
        return self._answer()

    def _send(self, call: str, *arguments: Any) -> None:
        if self._error is not None:
            return
        try:
            self._end.send(pickle.dumps((call, arguments)))
        except OSError as error:
            self._error = PhysicsError(f"{_IT} is gone: {error.strerror}")

    def _answer(self) -> Any:
        """What comes back; None where nothing does, or an error."""
        if self._error is not None:
            return None
        try:
            data = self._end.recv(_LARGEST)
        except BlockingIOError:
            self._error = PhysicsError(f"{_IT} has been silent for {self._patience:g} s")
            return None
        except OSError:
            data = b""
        if not data:
            self._error = PhysicsError(f"{_IT} is gone")
            return None
        refused, answer = pickle.loads(data)
        if refused:
            name, text = answer
            self._error = _RAISED.get(name, FollowerError)(text)
            return None
        return answer

    def _wait_for(self, seconds: float) -> None:
        """How long an answer may take; 0: for ever."""
        timeout = _TIMEOUT.pack(*divmod(round(1e6 * seconds), 1_000_000))
        self._end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, timeout)


def serve(end: socket.socket) -> None:
    """Does what the other end of the line asks for, until that is gone."""
    server = _Server()
    with suppress(ConnectionError):
        while data := end.recv(_LARGEST):
            call, arguments = pickle.loads(data)
            try:
                answer = (False, getattr(server, call)(*arguments))
            except Exception as error:  # whatever it is: who asked must know
                answer = (True, _in_words(error))
            end.send(pickle.dumps(answer))


def _in_words(error: Exception) -> tuple[str, str]:
    name = next((name for name, kind in _RAISED.items() if isinstance(error, kind)), "")
    return name, str(error) if name else f"{type(error).__name__}: {error}"


class _Server:
    """What can be asked for."""

    def __init__(self) -> None:
        self._simulator: Simulator | None = None
        self._cpu_from = 0.0

    def make(self, config: SimulatorConfig, urdf: str, period: float) -> Any:
        self.close()
        self._simulator = Simulator(config, RobotModel(urdf), period)
        self._cpu_from = time.process_time()
        return self._state()

    def advance(self, layout: Any, data: bytes) -> Any:
        self._existing.advance(SimulatorInputs(*unpacked(layout, data)))
        return self._state()

    def reset(self) -> Any:
        self._existing.reset()
        return self._state()

    def diagnostics(self) -> dict[str, float | int | str]:
        simulator = self._existing
        per_tick = (time.process_time() - self._cpu_from) / max(simulator.tick, 1)
        return {**simulator.diagnostics(), PHYSICS_CPU: per_tick}

    def close(self) -> None:
        if self._simulator is not None:
            self._simulator.close()
            self._simulator = None

    @property
    def _existing(self) -> Simulator:
        if self._simulator is None:
            raise PhysicsError("no simulator has been made")
        return self._simulator

    def _state(self) -> Any:
        simulator = self._existing
        return *packed(simulator.observe()), simulator.fall
