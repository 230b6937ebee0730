"""Inner loops as machine code: small arrays cost more in calls between NumPy functions than in arithmetic.

A kernel is an ordinary function of numbers and contiguous arrays, compiled by Numba when its module is
imported and kept on disk for the next time. No fast-math: a result does not depend on where it is computed.
A kernel calls functions of its own file only, and those of C libraries whose types that file says: the copy
on disk is renewed when the file changes, and would not notice a change elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(signature: str) -> Callable[[Function], Function]:
    """Compiles a function for one signature, such as `"float64(float64[::1], float64[:,::1])"`.

    Called with other types or memory layouts it raises TypeError: nothing is converted in silence. The
    environment variable NUMBA_DISABLE_JIT=1 leaves it plain Python, for a debugger.
    """

    def compiled(function: Function) -> Function:
        return cast(Function, numba.njit(signature, cache=True, error_model="numpy")(function))

    return compiled


def kernel_part(function: Function) -> Function:
    """Marks a function that is there for kernels of its file: it is compiled and loaded as part of them."""
    return cast(Function, numba.njit(error_model="numpy")(function))
