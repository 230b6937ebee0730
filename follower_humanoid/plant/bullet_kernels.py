"""What is asked of Bullet in every physics step.

`client` is the handle of a `BulletClient`, 0 once it is closed. A kernel that commands answers whether Bullet
has taken it: not where the server is closed, or where an array has another size than it must have.
"""

from __future__ import annotations

import math
from ctypes import c_double, c_int, c_size_t, c_void_p
from typing import Any

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.plant.bullet_library import external

TORQUE_CONTROL, WORLD_FRAME = 1, 2
# Answers of `renew`.
SILENT, INFINITE, FINITE = 0, 1, 2
NO_LINK = -2
Ints = NDArray[np.int32]
Triple = tuple[float, float, float]
_BASE_POSITIONS, _BASE_RATES = 7, 6
# struct b3ContactPointData: bytes; the second body's link among its ints, the distance among its doubles.
_CONTACT, _LINK, _DISTANCE = 176, 4, 12

_submit = external("b3SubmitClientCommandAndWaitStatus", c_void_p, c_void_p, c_void_p)
_step_command = external("b3InitStepSimulationCommand", c_void_p, c_void_p)
_control_command = external("b3JointControlCommandInit2", c_void_p, c_void_p, c_int, c_int)
_set_torque = external("b3JointControlSetDesiredForceTorque", c_int, c_void_p, c_int, c_double)
_force_command = external("b3ApplyExternalForceCommandInit", c_void_p, c_void_p)
_add_force = external("b3ApplyExternalForce", None, c_void_p, c_int, c_int, c_void_p, c_void_p, c_int)
_add_torque = external("b3ApplyExternalTorque", None, c_void_p, c_int, c_int, c_void_p, c_int)
_state_command = external("b3RequestActualStateCommandInit", c_void_p, c_void_p, c_int)
_with_kinematics = external(
    "b3RequestActualStateCommandComputeForwardKinematics", c_int, c_void_p, c_int
)
_state_of = external("b3GetStatusActualState", c_int, c_void_p, *7 * (c_void_p,))
_contact_command = external("b3InitRequestContactPointInformation", c_void_p, c_void_p)
_first_body = external("b3SetContactFilterBodyA", None, c_void_p, c_int)
_second_body = external("b3SetContactFilterBodyB", None, c_void_p, c_int)
_contacts_of = external("b3GetContactPointInformation", None, c_void_p, c_void_p)
_copy = external("memmove", c_void_p, c_void_p, c_void_p, c_size_t)


@kernel("boolean(int64)")
def step(client: int) -> bool:
    """Advances everything by one physics step."""
    return client != 0 and _submit(client, _step_command(client)) != 0


@kernel("boolean(int64, int32, int32[::1], float64[::1])")
def drive(client: int, body: int, rates: Ints, torque: Array) -> bool:
    """Joint torques of the next step.

    Args:
        client, body: Whose.
        rates: Where the driven joints stand among Bullet's velocities, shape (n,).
        torque: Shape (n,) [N·m].
    """
    if client == 0 or torque.size != rates.size:
        return False
    command = _control_command(client, body, TORQUE_CONTROL)
    for n in range(rates.size):
        _set_torque(command, rates[n], torque[n])
    return bool(_submit(client, command) != 0)


@kernel("boolean(int64, int32, int32[::1], float64[:,::1], float64[:,::1])")
def support(client: int, body: int, links: Ints, forces: Array, places: Array) -> bool:
    """What the ground does during the next step: those forces that point upward.

    Args:
        client, body: On whom.
        links: Shape (n,); −1 is the base.
        forces, places: In world, shape (n, 3) [N, m].
    """
    if client == 0 or forces.shape != (links.size, 3) or places.shape != (links.size, 3):
        return False
    taken = True
    force, place, row = forces.ctypes.data, places.ctypes.data, 3 * forces.itemsize
    for n in range(links.size):
        if forces[n, 2] > 0.0:
            # Of several forces in one command Bullet 3.2.7 mixes up the components.
            command = _force_command(client)
            _add_force(command, body, links[n], force + n * row, place + n * row, WORLD_FRAME)
            taken &= _submit(client, command) != 0
    return bool(taken)


@kernel("boolean(int64, int32, int32, float64[::1], float64[::1], float64[::1])")
def pull(client: int, body: int, link: int, force: Array, torque: Array, place: Array) -> bool:
    """A wrench during the next step on one link.

    Args:
        client, body, link: On whom.
        force, torque: In world, shape (3,) [N, N·m].
        place: Where the force acts, in world, shape (3,) [m].
    """
    if client == 0 or force.size != 3 or torque.size != 3 or place.size != 3:
        return False
    command = _force_command(client)
    _add_force(command, body, link, force.ctypes.data, place.ctypes.data, WORLD_FRAME)
    taken = _submit(client, command) != 0
    if torque[0] != 0.0 or torque[1] != 0.0 or torque[2] != 0.0:
        command = _force_command(client)
        _add_torque(command, body, link, torque.ctypes.data, WORLD_FRAME)
        taken &= _submit(client, command) != 0
    return bool(taken)


@kernel("int64(int64, int32, int32)")
def link_on(client: int, ground: int, body: int) -> int:
    """The first link of a body that touches another body; −1 is the base, `NO_LINK` where none does."""
    if client == 0:
        return NO_LINK
    command = _contact_command(client)
    _first_body(command, ground)
    _second_body(command, body)
    if _submit(client, command) == 0:
        return NO_LINK
    # struct b3ContactInformation: an int, and the address of the points.
    found = np.zeros(2, dtype=np.int64)
    _contacts_of(client, found.ctypes.data)
    point = np.empty(_CONTACT // 8)
    for n in range(found.view(np.int32)[0]):
        _copy(point.ctypes.data, found[1] + n * _CONTACT, _CONTACT)
        if point[_DISTANCE] <= 0.0:
            return int(point.view(np.int32)[_LINK])
    return NO_LINK


@kernel_part
def base_state(
    position: Triple, quat: tuple[float, ...], linear: Triple, spin: Triple, center: Array, turn: Array,
    q: Array, v: Array, rotation: Array, base: Array,
) -> bool:  # fmt: skip
    """State of base_link from that of its centre of mass and principal axes.

    Answers whether all of v is finite.

    R = R_axes R_turn;  x = x_c − R c;  ẋ = ẋ_c − ω × R c;  the twist in base axes is (Rᵀ ẋ, Rᵀ ω).

    Args:
        position, quat: Pose of centre and principal axes in world; (x, y, z, w).
        linear, spin: ẋ_c and ω, in world.
        center: c, in base_link, (3,).
        turn: Quaternion of R_turn, base_link to principal axes, (4,).
        q, v: Configuration and velocity, of which the base's rows are written.
        rotation, base: Written: R, and ẋ and ω in world, (2, 3).
    """
    x, y, z, w = quat
    i, j, k, r = turn
    q[3] = w * i + x * r + y * k - z * j
    q[4] = w * j + y * r + z * i - x * k
    q[5] = w * k + z * r + x * j - y * i
    q[6] = w * r - x * i - y * j - z * k
    x, y, z, w = q[3], q[4], q[5], q[6]
    rotation[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    rotation[0, 1] = 2.0 * (x * y - z * w)
    rotation[0, 2] = 2.0 * (x * z + y * w)
    rotation[1, 0] = 2.0 * (x * y + z * w)
    rotation[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    rotation[1, 2] = 2.0 * (y * z - x * w)
    rotation[2, 0] = 2.0 * (x * z - y * w)
    rotation[2, 1] = 2.0 * (y * z + x * w)
    rotation[2, 2] = 1.0 - 2.0 * (x * x + y * y)
    for axis in range(3):
        base[0, axis], base[1, axis], q[axis] = linear[axis], spin[axis], position[axis]
    for axis in range(3):
        # The centre's place relative to base_link, in world.
        arm = rotation[axis, 0] * center[0] + rotation[axis, 1] * center[1] + rotation[axis, 2] * center[2]
        q[axis] -= arm
        after, last = (axis + 1) % 3, (axis + 2) % 3
        # Its share of −ω × arm: along the two other axes.
        base[0, after] -= spin[last] * arm
        base[0, last] += spin[after] * arm
    for axis in range(3):
        v[axis] = v[3 + axis] = 0.0
        for row in range(3):
            v[axis] += rotation[row, axis] * base[0, row]
            v[3 + axis] += rotation[row, axis] * base[1, row]
    total = 0.0
    for rate in v:
        total += rate
    return math.isfinite(total)


@kernel(
    "int64(int64, int32, int32[:,::1], int64[::1], float64[::1], float64[::1], float64[::1], float64[::1], "
    "float64[::1], float64[::1], float64[:,::1], float64[:,::1])"
)
def renew(
    client: int, body: int, joints: Ints, answer: NDArray[Any], positions: Array, rates: Array, center: Array,
    turn: Array, q: Array, v: Array, rotation: Array, base: Array,
) -> int:  # fmt: skip
    """Reads the state of a robot.

    Answers `FINITE` or `INFINITE` for v, `SILENT` where there is no such robot.

    External forces are placed relative to link poses that Bullet leaves one step old: asking for forward
    kinematics renews them. Else a swinging hand would feel N·mm out of nothing.

    Args:
        client, body: Whose.
        joints: Of each moving joint the place among Bullet's positions, among its velocities, and among the
            actuated joints, shape (n, 3).
        answer: Workspace, shape (7,).
        positions, rates: Bullet's own, written; the base's come first: pose and twist of its centre of mass
            and principal axes, in world.
        center, turn: See `base_state`.
        q, v, rotation, base: Written, as by `base_state`; of joints that do not move nothing is.
    """
    if client == 0:
        return SILENT
    command = _state_command(client, body)
    _with_kinematics(command, 1)
    status = _submit(client, command)
    at = answer.ctypes.data
    # Body, how many positions and velocities; where inertial frame, positions, velocities and loads are.
    if status == 0 or _state_of(status, at, at + 8, at + 16, at + 24, at + 32, at + 40, at + 48) == 0:
        return SILENT
    numbers = answer.view(np.int32)
    if numbers[2] != positions.size or numbers[4] != rates.size:
        return SILENT
    _copy(positions.ctypes.data, answer[4], 8 * positions.size)
    _copy(rates.ctypes.data, answer[5], 8 * rates.size)
    for n in range(joints.shape[0]):
        q[_BASE_POSITIONS + joints[n, 2]] = positions[joints[n, 0]]
        v[_BASE_RATES + joints[n, 2]] = rates[joints[n, 1]]
    finite = base_state(
        (positions[0], positions[1], positions[2]),
        (positions[3], positions[4], positions[5], positions[6]),
        (rates[0], rates[1], rates[2]), (rates[3], rates[4], rates[5]),
        center, turn, q, v, rotation, base,
    )  # fmt: skip
    return FINITE if finite else INFINITE
