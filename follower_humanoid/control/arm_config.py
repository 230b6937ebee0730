"""Parameters of the arm controller."""

from __future__ import annotations

from dataclasses import dataclass, field

from follower_humanoid.control.arm_modes import IMPEDANCE, MODES
from follower_humanoid.control.motor_inverse import MotorModel
from follower_humanoid.core.config import parameter
from follower_humanoid.errors import ConfigurationError


@dataclass(frozen=True)
class ArmControllerConfig:
    """Parameters of the arm controller. Axes of triples: ahead of the pelvis, to its left, up."""

    stiffness: tuple[float, float, float] = parameter(
        (100.0, 100.0, 3000.0), "stiffness K_m of the hand", "N/m", 1.0, 20000.0
    )
    inertia: tuple[float, float, float] = parameter(
        (3.0, 3.0, 3.0), "inertia H_m of the hand as a leader feels it", "kg", 0.5, 50.0
    )
    damping_ratio: float = parameter(1.0, "D_m over critical damping", "", 0.1, 5.0)
    return_proportional: float = parameter(
        0.8, "K_P of eq. (17): how fast the hand returns to its place", "1/s", 0.0, 20.0
    )
    return_differential: float = parameter(0.1, "K_D of eq. (17)", "", 0.0, 0.9)
    return_force: tuple[float, float, float] = parameter(
        (60.0, 60.0, 200.0), "largest force with which the hand returns to its place", "N", 1.0, 500.0
    )
    reach: float = parameter(0.12, "how far a hand may be pulled from its place", "m", 0.01, 1.0)
    reach_stiffness: float = parameter(2000.0, "stiffness beyond that", "N/m", 0.0, 20000.0)
    posture_stiffness: float = parameter(
        100.0, "null-space stiffness, to the first posture", "1/s²", 0.0, 2000.0
    )
    posture_damping: float = parameter(20.0, "null-space damping", "1/s", 0.0, 200.0)
    posture_return: float = parameter(2.0, "rate of return to the first posture", "1/s", 0.0, 20.0)
    singular_threshold: float = parameter(
        0.08, "singular value of the Jacobian below which its inverse is damped", "m/rad", 0.001, 0.5
    )
    singular_damping: float = parameter(0.05, "damping of the inverse at a singularity", "m/rad", 0.001, 0.5)
    stop_margin: float = parameter(0.08, "distance from a joint stop where springs begin", "rad", 0.0, 0.5)
    stop_stiffness: float = parameter(900.0, "push away from a joint stop", "1/s²", 0.0, 5000.0)
    stop_damping: float = parameter(40.0, "braking towards a joint stop", "1/s", 0.0, 200.0)
    acceleration_filter_time: float = parameter(
        0.01, "low-pass on the measured body acceleration", "s", 0.0, 0.2
    )
    reference_filter_time: float = parameter(
        0.01, "low-pass on the desired joint acceleration (derivative of eq. (6))", "s", 0.0, 0.2
    )
    mode: str = parameter(
        IMPEDANCE,
        "what the arms do: keep their places, let themselves be led, or whichever the force says",
        choices=MODES,
        read_only=False,
    )
    compensation_damping: float = parameter(
        60.0, "D_m of eq. (10): a force of that many newtons leads a hand at 1 m/s", "N·s/m", 5.0, 1000.0
    )
    payload: float = parameter(
        0.0,
        "weight in each hand that gravity compensation carries besides the arm's",
        "N",
        0.0,
        300.0,
        read_only=False,
    )
    auto_pulled: float = parameter(
        4.0, "force above which a hand lets itself be led in mode auto", "N", 0.1, 500.0, read_only=False
    )
    auto_released: float = parameter(
        1.5, "force below which it counts as let go", "N", 0.0, 500.0, read_only=False
    )
    auto_delay: float = parameter(
        0.8,
        "time for which it must be let go before it keeps a place again",
        "s",
        0.0,
        60.0,
        read_only=False,
    )
    blend_time: float = parameter(0.2, "time in which a switch of modes fades in", "s", 0.01, 5.0)
    glide_speed: float = parameter(0.1, "how fast a hand that was led goes back", "m/s", 0.005, 1.0)
    glide_turn: float = parameter(0.5, "how fast its posture goes back", "rad/s", 0.01, 5.0)
    limit_avoidance: float = parameter(
        0.0,
        "k_0 of eq. (7), joints to the middle of their ranges; 0: to the first posture",
        "rad²/s",
        0.0,
        50.0,
    )
    motor: MotorModel = field(default_factory=MotorModel)

    def __post_init__(self) -> None:
        """Refuses what the single ranges let through.

        Raises:
            ConfigurationError: A hand would be let go by a force that also leads it.
        """
        if self.auto_released >= self.auto_pulled:
            raise ConfigurationError(
                f"auto_released = {self.auto_released} N: valid: below auto_pulled = {self.auto_pulled} N"
            )
