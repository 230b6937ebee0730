"""Bullet's C interface, which PyBullet's library exports beside its Python functions.

A Python function of PyBullet asks the server anew for every quantity and makes tuples of tuples of the
answer; by the C interface one answer holds the whole state as two arrays, and compiled kernels can read it.
Names and types are those of Bullet's `PhysicsClientC_API.h`. PyBullet's Python module itself is never run.
"""

from __future__ import annotations

import ctypes
import importlib.util
from collections.abc import Callable
from ctypes import c_char_p, c_double, c_int, c_void_p
from functools import lru_cache
from typing import Any

import llvmlite.binding
import numba
import numpy as np
from numba.core import config

from follower_humanoid.errors import ConfigurationError

_NUMBA = {None: numba.void, c_int: numba.int32, c_double: numba.float64}
_ADDRESS = numba.int64
# Arrays of double, structures, and the handles of client, command and status go by their address.
_Types = tuple[Any, tuple[Any, ...]]
# What a `BulletClient` calls.
FUNCTIONS: dict[str, _Types] = {
    "b3ConnectPhysicsDirect": (c_void_p, ()),
    "b3DisconnectSharedMemory": (None, (c_void_p,)),
    "b3CanSubmitCommand": (c_int, (c_void_p,)),
    "b3SubmitClientCommandAndWaitStatus": (c_void_p, (c_void_p, c_void_p)),
    # The engine.
    "b3InitPhysicsParamCommand": (c_void_p, (c_void_p,)),
    "b3PhysicsParamSetGravity": (c_int, (c_void_p, c_double, c_double, c_double)),
    "b3PhysicsParamSetTimeStep": (c_int, (c_void_p, c_double)),
    "b3PhysicsParamSetNumSolverIterations": (c_int, (c_void_p, c_int)),
    "b3PhysicsParamSetNumSubSteps": (c_int, (c_void_p, c_int)),
    "b3PhysicsParameterSetDeterministicOverlappingPairs": (c_int, (c_void_p, c_int)),
    "b3PhysicsParamSetEnableFileCaching": (c_int, (c_void_p, c_int)),
    # Bodies.
    "b3CreateCollisionShapeCommandInit": (c_void_p, (c_void_p,)),
    "b3CreateCollisionShapeAddPlane": (c_int, (c_void_p, c_void_p, c_double)),
    "b3GetStatusCollisionShapeUniqueId": (c_int, (c_void_p,)),
    "b3CreateMultiBodyCommandInit": (c_void_p, (c_void_p,)),
    "b3CreateMultiBodyBase": (c_int, (c_void_p, c_double, c_int, c_int, *4 * (c_void_p,))),
    "b3LoadUrdfCommandInit": (c_void_p, (c_void_p, c_char_p)),
    "b3LoadUrdfCommandSetFlags": (c_int, (c_void_p, c_int)),
    "b3LoadUrdfCommandSetUseFixedBase": (c_int, (c_void_p, c_int)),
    "b3GetStatusBodyIndex": (c_int, (c_void_p,)),
    "b3GetNumJoints": (c_int, (c_void_p, c_int)),
    "b3GetJointInfo": (c_int, (c_void_p, c_int, c_int, c_void_p)),
    "b3InitChangeDynamicsInfo": (c_void_p, (c_void_p,)),
    "b3ChangeDynamicsInfoSetLateralFriction": (c_int, (c_void_p, c_int, c_int, c_double)),
    "b3ChangeDynamicsInfoSetRestitution": (c_int, (c_void_p, c_int, c_int, c_double)),
    "b3ChangeDynamicsInfoSetLinearDamping": (c_int, (c_void_p, c_int, c_double)),
    "b3ChangeDynamicsInfoSetAngularDamping": (c_int, (c_void_p, c_int, c_double)),
    "b3ChangeDynamicsInfoSetJointDamping": (c_int, (c_void_p, c_int, c_int, c_double)),
    "b3ChangeDynamicsInfoSetMaxJointVelocity": (c_int, (c_void_p, c_int, c_double)),
    "b3CollisionFilterCommandInit": (c_void_p, (c_void_p,)),
    "b3SetCollisionFilterGroupMask": (None, (c_void_p, *4 * (c_int,))),
    # State.
    "b3CreatePoseCommandInit": (c_void_p, (c_void_p, c_int)),
    "b3CreatePoseCommandSetBasePosition": (c_int, (c_void_p, *3 * (c_double,))),
    "b3CreatePoseCommandSetBaseOrientation": (c_int, (c_void_p, *4 * (c_double,))),
    "b3CreatePoseCommandSetBaseLinearVelocity": (c_int, (c_void_p, c_void_p)),
    "b3CreatePoseCommandSetBaseAngularVelocity": (c_int, (c_void_p, c_void_p)),
    "b3CreatePoseCommandSetJointPosition": (c_int, (c_void_p, c_void_p, c_int, c_double)),
    "b3CreatePoseCommandSetJointVelocity": (c_int, (c_void_p, c_void_p, c_int, c_double)),
    "b3RequestActualStateCommandInit": (c_void_p, (c_void_p, c_int)),
    "b3GetStatusActualState": (c_int, (c_void_p, *7 * (c_void_p,))),
    # Motors.
    "b3JointControlCommandInit2": (c_void_p, (c_void_p, c_int, c_int)),
    "b3JointControlSetDesiredVelocity": (c_int, (c_void_p, c_int, c_double)),
    "b3JointControlSetMaximumForce": (c_int, (c_void_p, c_int, c_double)),
}


@lru_cache(maxsize=1)
def library() -> ctypes.PyDLL:
    """PyBullet's library, with the types of all `FUNCTIONS`.

    Raises:
        ConfigurationError: PyBullet is not there, or is another one.
    """
    spec = importlib.util.find_spec("pybullet")
    if spec is None or spec.origin is None:
        raise ConfigurationError("PyBullet is not installed; valid: pip install 'pybullet>=3.2.7'")
    try:
        found = ctypes.PyDLL(spec.origin)
    except OSError as error:
        raise ConfigurationError(f"{spec.origin} is no library of PyBullet: {error}") from None
    for name, (result, arguments) in FUNCTIONS.items():
        _declare(found, name, result, arguments)
    return found


def external(name: str, result: Any, *arguments: Any) -> Callable[..., Any]:
    """A function of Bullet or of C, to be called from a kernel; where kernels are plain Python, from there.

    Its types belong beside the kernels: their copies on disk would not notice a change here.

    Args:
        name: Of the function.
        result, arguments: Types, as in `FUNCTIONS`.
    """
    function = _declare(library(), name, result, arguments)
    if vars(config)["DISABLE_JIT"]:
        return lambda *values: function(*(v.item() if isinstance(v, np.generic) else v for v in values)) or 0
    # Each by its name: opened to the process as a whole, the library would lend others its own copies of
    # tinyxml2 and of parts of the C++ library.
    llvmlite.binding.add_symbol(name, ctypes.cast(function, c_void_p).value)
    signature = _NUMBA.get(result, _ADDRESS)(*[_NUMBA.get(kind, _ADDRESS) for kind in arguments])
    called: Callable[..., Any] = numba.types.ExternalFunction(name, signature)
    return called


def _declare(found: ctypes.PyDLL, name: str, result: Any, arguments: tuple[Any, ...]) -> Any:
    if not hasattr(found, name):
        raise ConfigurationError(f"{found._name} has no {name}; valid: PyBullet 3.2.7 or later")
    function = getattr(found, name)
    function.restype, function.argtypes = result, arguments
    return function
