"""What a tick of the ROS-free chain is spent on: the libraries, our kernels, and Python around them."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from types import ModuleType
from typing import Any

import pinocchio as pin
from numba.core.registry import CPUDispatcher

from follower_humanoid.graph.simulate import Chain
from follower_humanoid.plant import bullet_kernels

_PACKAGE = "follower_humanoid"
_EMPTY_CALLS = 10_000


@dataclass(frozen=True)
class Spent:
    """Wall time per tick [s].

    Attributes:
        bullet: In PyBullet: steps, what is commanded and what is read.
        pinocchio: In Pinocchio's algorithms.
        kernels: In what we have compiled, Python's way in and out included.
        python: All else.
    """

    bullet: float
    pinocchio: float
    kernels: float
    python: float

    def parts(self) -> dict[str, float]:
        """Name → wall time [s]."""
        return {part.name: getattr(self, part.name) for part in fields(self)}


class _Clock:
    """Adds up what calls take, without what a look at the clock takes."""

    def __init__(self) -> None:
        self._total, self._calls = 0, 0

    def around(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """The same call, clocked."""
        now = time.perf_counter_ns

        def clocked(*arguments: Any, **named: Any) -> Any:
            begin = now()
            result = call(*arguments, **named)
            self._total += now() - begin
            self._calls += 1
            return result

        return clocked

    def seconds(self, look: float) -> float:
        """In all. Args: what one look takes, which every call contains [s]."""
        return self._total * 1e-9 - self._calls * look

    @staticmethod
    def look() -> float:
        """What a clocked call of nothing takes [s]."""
        clock = _Clock()
        nothing = clock.around(lambda: None)
        for _ in range(_EMPTY_CALLS):
            nothing()
        return clock.seconds(0.0) / _EMPTY_CALLS


def spent_of(chain: Chain, ticks: int) -> Spent:
    """Advances a chain under the clock. What clocks cost outside of what they measure counts as Python."""
    bullet, pinocchio, kernels = _Clock(), _Clock(), _Clock()
    look = _Clock.look()
    with _clocked(bullet, pinocchio, kernels):
        begin = time.perf_counter()
        for _ in range(ticks):
            chain.advance()
        wall = time.perf_counter() - begin
    compiled = [clock.seconds(look) for clock in (bullet, pinocchio, kernels)]
    return Spent(*(part / ticks for part in (*compiled, wall - sum(compiled))))


@contextmanager
def _clocked(bullet: _Clock, pinocchio: _Clock, kernels: _Clock) -> Iterator[None]:
    """Puts clocks around every kernel of the package and every algorithm of Pinocchio, for a while.

    Modules hold kernels under their own names, so each of them is gone through.
    """
    replaced: list[tuple[ModuleType, str, Any]] = []
    for module in (module for name, module in list(sys.modules.items()) if name.startswith(_PACKAGE)):
        for name, value in list(vars(module).items()):
            if isinstance(value, CPUDispatcher):
                of_bullet = value.py_func.__module__ == bullet_kernels.__name__
                replaced.append((module, name, value))
                setattr(module, name, (bullet if of_bullet else kernels).around(value))
    algorithm = type(pin.crba)
    for module in (pin, pin.cholesky):
        for name, value in list(vars(module).items()):
            if isinstance(value, algorithm):
                replaced.append((module, name, value))
                setattr(module, name, pinocchio.around(value))
    try:
        yield
    finally:
        for module, name, value in replaced:
            setattr(module, name, value)
