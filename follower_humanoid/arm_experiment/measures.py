"""What an arm experiment must show, measured on a run: a simulated one or one read from a bag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.control.arm_modes import COMPENSATION
from follower_humanoid.control.hand_task import HandKinematics
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import FollowerError
from follower_humanoid.graph.record import Run
from follower_humanoid.robot.model import RobotModel

_TOUCHING = 0.0  # contact force above which a hand touches the board [N]
_FILTERED = 0.05  # the sensed force needs that long to forget the contact [s]

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ArmTrace:
    """The left hand and its arm, one row per tick.

    Attributes:
        time: Shape (T,) [s].
        place: Gripper relative to base_link, pelvis-yaw axes, shape (T, 3) [m].
        rate: Its velocity, shape (T, 3) [m/s].
        target: Target in use at that tick, shape (T, 3) [m].
        sensed: Sensed force, axes of world, shape (T, 3) [N].
        contact: Board on gripper, shape (T, 3) [N].
        applied: What people applied, shape (T, 3) [N].
        led: True while in gravity compensation, shape (T,).
        position, velocity, torque: Of the seven joints, shape (T, 7) [rad], [rad/s], [N·m].
        elbow: Index of the elbow among them.
    """

    time: Array
    place: Array
    rate: Array
    target: Array
    sensed: Array
    contact: Array
    applied: Array
    led: Mask
    position: Array
    velocity: Array
    torque: Array
    elbow: int = 3

    @property
    def speed(self) -> Array:
        """Speed of the hand, shape (T,) [m/s]."""
        return np.asarray(np.linalg.norm(self.rate, axis=1))

    @property
    def touching(self) -> Mask:
        """Where the hand touches the board, shape (T,)."""
        return np.abs(self.contact[:, 0]) > _TOUCHING


def arm_trace(run: Run, robot: RobotModel | None = None) -> ArmTrace:
    """The left arm of a run."""
    robot = robot or RobotModel()
    joints, base = run["joint_states"], run["odom"]
    kinematics, arm = HandKinematics(robot), robot.groups.left_arm
    count = min(len(joints), len(base))
    place, rate = np.empty((count, 3)), np.empty((count, 3))
    for row in range(count):
        q = np.concatenate((base.position[row], base.quat_xyzw[row], joints.position[row]))
        v = np.concatenate((base.linear_velocity[row], base.angular_velocity[row], joints.velocity[row]))
        hands = kinematics.motion(q, v)
        place[row], rate[row] = hands.place[0], hands.place_rate[0]
    ticks = joints.ticks[:count]
    nothing = np.zeros((count, 3))
    target = (
        run["left_hand/target"].held("position", ticks - 1) if "left_hand/target" in run else nothing * np.nan
    )
    target = np.where(np.isnan(target), place[0], target)
    return ArmTrace(
        time=joints.times[:count], place=place, rate=rate, target=target,
        sensed=np.nan_to_num(run["left_hand/wrench"].held("force", ticks)),
        contact=run["left_hand/contact"].held("force", ticks) if "left_hand/contact" in run else nothing,
        applied=run["left_hand/applied"].held("force", ticks),
        led=_led(run, ticks),
        position=joints.position[:count, arm], velocity=joints.velocity[:count, arm],
        torque=joints.effort[:count, arm],
    )  # fmt: skip


def _led(run: Run, ticks: NDArray[np.int64]) -> Mask:
    if "arms/mode" not in run:
        return np.zeros(len(ticks), dtype=bool)
    series = run["arms/mode"]
    words = [sample.names[0].endswith(COMPENSATION) for sample in series.samples]
    rows = series.latest(ticks)
    return np.array([row >= 0 and words[row] for row in rows])


@dataclass(frozen=True)
class BoardNumbers:
    """Figures 1 and 2.

    Attributes:
        tracking_error: y and z in contact, rms, shape (2,) [m].
        overshoot: Furthest that the hand leaves the square outwards in contact [m].
        static_force: Mean normal force while the hand rests on the board [N].
        expected_force: K_m k_b/(K_m + k_b) · commanded penetration [N].
        peak_force: Largest normal force [N].
        touchdowns: How often contact began.
        free_force: Largest true contact force where the hand is in front of the board, and largest sensed
            force from a moment after it came there, shape (2,) [N].
        tangential_force: Largest sensed |F_y|, |F_z|, shape (2,) [N].
    """

    tracking_error: Array
    overshoot: float
    static_force: float
    expected_force: float
    peak_force: float
    touchdowns: int
    free_force: Array
    tangential_force: Array


def board_numbers(
    trace: ArmTrace, stiffness: float, board_stiffness: float, penetration: float
) -> BoardNumbers:
    """Measures the board task.

    Args:
        trace: The run.
        stiffness: K_m along x [N/m].
        board_stiffness: k_b [N/m].
        penetration: How far behind the surface the targets lie [m].

    Raises:
        FollowerError: There is no contact to measure.
    """
    touching, press = trace.touching, np.abs(trace.contact[:, 0])
    if not touching.any():
        raise FollowerError("the hand never touched the board: nothing to measure")
    error = (trace.target - trace.place)[touching, 1:]
    written, asked = trace.place[touching, 1:], trace.target[touching, 1:]
    beyond = np.maximum(written - asked.max(axis=0), asked.min(axis=0) - written)
    begins = int(np.count_nonzero(np.diff(touching.astype(int)) == 1))
    pressed = touching & np.all(np.isclose(trace.target, np.roll(trace.target, 1, axis=0), atol=1e-9), axis=1)
    pressed &= trace.target[:, 0] > trace.target[:, 0].max() - 1e-9
    late = _lasting(pressed, trace.time, 0.3)
    in_front = trace.place[:, 0] < trace.target[:, 0].max() - penetration
    # What is measured at a tick is the mean since the one before.
    apart = in_front & np.roll(in_front, 1)
    free = ~_dilated(~in_front, trace.time, _FILTERED)
    return BoardNumbers(
        tracking_error=np.sqrt(np.mean(error**2, axis=0)),
        overshoot=float(beyond.max()),
        static_force=float(press[late].mean()),
        expected_force=stiffness * board_stiffness / (stiffness + board_stiffness) * penetration,
        peak_force=float(press.max()),
        touchdowns=begins,
        free_force=np.array([press[apart].max(), np.linalg.norm(trace.sensed[free], axis=1).max()]),
        tangential_force=np.abs(trace.sensed[:, 1:]).max(axis=0),
    )


@dataclass(frozen=True)
class PushNumbers:
    """Figure 3: one push.

    Attributes:
        begin, end: Of the push [s].
        yielded: How far the hand goes along the force [m].
        elbow_peak: Largest elbow speed in it [rad/s].
        elbow_left: Largest elbow speed from 0.5 s after its end, while still led, over the peak.
        drift: Largest hand speed in the same time [m/s].
        torque_step: Largest change of a joint torque within a tick at a switch of modes [N·m].
    """

    begin: float
    end: float
    yielded: float
    elbow_peak: float
    elbow_left: float
    drift: float
    torque_step: float


def pushes(trace: ArmTrace) -> list[PushNumbers]:
    """Every push of a run."""
    acting = np.linalg.norm(trace.applied, axis=1) > 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], acting.astype(int), [0]))))
    return [_push(trace, begin, end) for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def _push(trace: ArmTrace, begin: int, end: int) -> PushNumbers:
    time = trace.time
    force = trace.applied[begin]
    along = force / np.linalg.norm(force)
    elbow = np.abs(trace.velocity[:, trace.elbow])
    peak = float(elbow[begin:end].max())
    after = (time >= time[end - 1] + 0.5) & trace.led
    freed = np.flatnonzero(~trace.led & (np.arange(len(time)) >= end))
    after &= np.arange(len(time)) < (freed[0] if len(freed) else len(time))
    switched = np.flatnonzero(np.diff(trace.led.astype(int))) + 1
    near = [n for n in switched if begin - 5 <= n <= (freed[0] if len(freed) else len(time))]
    return PushNumbers(
        begin=float(time[begin]), end=float(time[end - 1]),
        yielded=float((trace.place[end - 1] - trace.place[begin]) @ along),
        elbow_peak=peak,
        elbow_left=float(elbow[after].max() / peak) if after.any() else float("nan"),
        drift=float(trace.speed[after].max()) if after.any() else float("nan"),
        torque_step=max((torque_step(trace.torque, int(n)) for n in near), default=float("nan")),
    )  # fmt: skip


def torque_step(torque: Array, tick: int, around: int = 2) -> float:
    """Largest change of any joint's torque from tick to tick near one, torque of shape (T, n) [N·m]."""
    part = torque[max(0, tick - around) : tick + around + 1]
    return float(np.abs(np.diff(part, axis=0)).max())


def energy_given_back(force: Array, velocity: Array, period: float) -> float:
    """How much more work the arm ever returns than was done on it since the beginning [J].

    Args:
        force: On the hand, shape (T, 3) [N].
        velocity: Of the hand, shape (T, 3) [m/s].
        period: Between rows [s].

    Returns:
        −min over time of ∫ F·ẋ dt; zero or less where the arm is passive and began with nothing stored.
    """
    return float(-np.min(np.cumsum(np.einsum("ij,ij->i", force, velocity)) * period))


def _lasting(mask: Mask, time: Array, least: float) -> Mask:
    """Where a mask has been true for a while."""
    since = np.where(mask, np.nan, time)
    last = np.fmax.accumulate(np.where(np.isnan(since), -np.inf, since))
    late: Mask = mask & (time - last > least)
    return late


def _dilated(mask: Mask, time: Array, tail: float) -> Mask:
    """A mask that stays true for a while longer, and is true one row earlier."""
    last = np.fmax.accumulate(np.where(mask, time, -np.inf))
    longer: Mask = (time - last <= tail) | np.roll(mask, -1)
    return longer
