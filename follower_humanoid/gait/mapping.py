"""Walking parameters from the pull on the hands: corrected eqs. (19), (20) with a start/stop rule.

The pulls on both hands add as vectors; their horizontal part F (axes of world) tells direction and
intensity. A hand that the arm controller lets be led is moved by its pull, which then does not call
for a walk. Eq. (20) alone never stops, so walking starts when |F| stays above one threshold and stops
when it stays below a lower one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from follower_humanoid.control.arm_modes import COMPENSATION
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Gait, PrimitiveStates, Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.sensing.low_pass import LowPass


@dataclass(frozen=True)
class GaitMappingConfig:
    """Parameters of the mapping."""

    filter_time: float = parameter(
        0.1, "time constant of the low-pass on the summed hand force; 0: none", "s", 0.0, 0.3
    )
    saturation: float = parameter(5.0, "eq. (20): force of the largest speed and length", "N", 0.1, 100.0)
    divisor: float = parameter(20.0, "eq. (20): force that would double both", "N", 1.0, 1000.0)
    start_force: float = parameter(0.7, "walking starts when the force stays above this", "N", 0.05, 50.0)
    start_time: float = parameter(0.2, "how long it must stay above", "s", 0.0, 5.0)
    stop_force: float = parameter(0.4, "walking stops when the force stays below this", "N", 0.0, 50.0)
    stop_time: float = parameter(0.5, "how long it must stay below", "s", 0.0, 5.0)
    direction_force: float = parameter(0.5, "below this force the direction is held", "N", 0.0, 50.0)
    turn_rate: float = parameter(
        0.09, "fixed direction step per update, as a rate: step = turn_rate x period", "rad/s", 0.001, 2.0
    )
    reversal_margin: float = parameter(
        0.2, "this close to a half turn, a turn once begun goes on the same way round", "rad", 0.0, 1.5
    )
    initial_direction: float = parameter(
        0.0, "direction of travel before the first pull", "rad", -math.pi, math.pi
    )
    step_height: float = parameter(
        1.0, "factor of the nominal swing height, constant in the paper", "", 0.2, 3.0
    )

    def __post_init__(self) -> None:
        """Without a gap between the thresholds the robot would start and stop on noise."""
        if self.stop_force >= self.start_force:
            raise ConfigurationError(
                f"stop_force = {self.stop_force}: needs to be below start_force = {self.start_force}"
            )


@dataclass(frozen=True)
class GaitMappingInputs:
    """External wrenches on the hands, axes of world; None before the first is measured.

    `arms` names the mode of each hand; None: nobody said that one is led.
    """

    left_hand: Wrench | None
    right_hand: Wrench | None
    arms: PrimitiveStates | None = None


@dataclass(frozen=True)
class GaitMappingOutputs:
    """The walking parameters."""

    gait: Gait


def intensity_factor(force: float, saturation: float, divisor: float) -> float:
    """Walking speed and step length over nominal: `p = 1 + min(|F|, F_sat)/divisor`.

    Args:
        force: |F_xy| [N].
        saturation: F_sat [N].
        divisor: [N].

    Reference: Savić et al. 2016, eq. (20).
    """
    return 1.0 + min(force, saturation) / divisor


def shortest_turn(start: float, goal: float) -> float:
    """Angle from `start` to `goal` the shortest way round, in (−π, π] [rad]."""
    turn = math.remainder(goal - start, 2.0 * math.pi)
    return math.pi if turn == -math.pi else turn


_LED = {side: f"{side.value}_hand/{COMPENSATION}" for side in SIDES}


def _calling_force(left: Wrench, right: Wrench, arms: PrimitiveStates | None) -> tuple[float, float]:
    """Horizontal force of the hands that are not led, (x, y) [N]."""
    led = () if arms is None else arms.names
    x = y = 0.0
    for side, hand in zip(SIDES, (left, right), strict=True):
        if _LED[side] not in led:
            force_x, force_y, _ = hand.force.tolist()
            x, y = x + force_x, y + force_y
    return x, y


class GaitMapping:
    """Component: hand wrenches in, walking parameters out.

    Until both hands have been measured the robot stands: a missing wrench is not a zero force.
    """

    Config = GaitMappingConfig
    Inputs = GaitMappingInputs
    Outputs = GaitMappingOutputs

    def __init__(self, config: GaitMappingConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._period = period
        self._filter_x, self._filter_y = (LowPass[float](config.filter_time, period) for _ in "xy")
        self._walking = False
        self._held = 0.0  # how long the force has called for a change of state [s]
        self._missed = 0.0  # how long the hands have not been measured [s]
        self._direction = config.initial_direction
        self._last_turn = 0.0

    def step(self, inputs: GaitMappingInputs, time: float) -> GaitMappingOutputs:
        """The walking parameters of this update."""
        if inputs.left_hand is None or inputs.right_hand is None:
            self._miss()
            return GaitMappingOutputs(self._gait(walk_speed=0.0, step_length=1.0))
        config, self._missed = self._config, 0.0
        x, y = _calling_force(inputs.left_hand, inputs.right_hand, inputs.arms)
        x, y = self._filter_x.step(x), self._filter_y.step(y)
        force = math.hypot(x, y)
        self._start_or_stop(force)
        factor = intensity_factor(force, config.saturation, config.divisor)
        if not self._walking:
            return GaitMappingOutputs(self._gait(walk_speed=0.0, step_length=factor))
        if force > config.direction_force:
            self._turn_towards(math.atan2(y, x))
        return GaitMappingOutputs(self._gait(walk_speed=factor, step_length=factor))

    def _miss(self) -> None:
        """Hands that are not measured for as long as a stop takes: a force must call anew."""
        self._missed += self._period
        if self._missed >= self._config.stop_time - self._period / 2:
            self._walking, self._held = False, 0.0
            self._filter_x.value = self._filter_y.value = None

    def _start_or_stop(self, force: float) -> None:
        config = self._config
        calling = force < config.stop_force if self._walking else force > config.start_force
        needed = config.stop_time if self._walking else config.start_time
        self._held = self._held + self._period if calling else 0.0
        # half a period of slack: sums of periods are not exact
        if calling and self._held >= needed - self._period / 2:
            self._walking = not self._walking
            self._held = 0.0

    def _turn_towards(self, goal: float) -> None:
        """One fixed step towards `goal`, eq. (19); closer than one step it snaps."""
        step = self._config.turn_rate * self._period
        turn = shortest_turn(self._direction, goal)
        opposite = math.pi - abs(turn) < self._config.reversal_margin
        if opposite and self._last_turn * turn < 0.0:
            turn = -turn  # noise on a backward pull must not make the robot turn to and fro
        if abs(turn) <= step:
            self._direction, self._last_turn = goal, 0.0
        else:
            self._last_turn = math.copysign(step, turn)
            self._direction = math.remainder(self._direction + self._last_turn, 2.0 * math.pi)

    def _gait(self, walk_speed: float, step_length: float) -> Gait:
        return Gait(
            walk_speed=walk_speed,
            walk_dir=self._direction,
            step_length=step_length,
            step_height=self._config.step_height,
            heading=self._direction,
        )
