"""The balance law of the paper: an adaptive PID on ZMP and PCM that changes reference velocities.

Savić et al. 2016, dynamic balance control module in section "The RAMP-based framework for cooperative
transportation": corrections from the distances between desired and actual ZMP and projection of the centre
of mass (PCM); no desired foot wrenches, the joints are stiff.
The paper gives no gains. Ours follow from what makes the robot topple on stiff joints: the soles. One of
rotational stiffness K pushes back by p = r(c − u) on a CoM at c that was sent to u, r = K/(m g h),
about 2.5 sideways on one foot. With u̇ = k_C(c_ref − c) − k_Z ω(p_ref − p) that pendulum is stable for
k_C/r < k_Z ω < k_C: the ZMP damps, the PCM brings back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.balance.correction import Correction, Kinematics, Situation
from follower_humanoid.balance.shifted_reference import ShiftedReference
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Point
from follower_humanoid.gait.differential_ik import IkConfig
from follower_humanoid.gait.pendulum import natural_frequency
from follower_humanoid.robot.model import RobotModel


@dataclass(frozen=True)
class PaperConfig:
    """Gains of the paper's law."""

    pcm: float = parameter(3.0, "k_C, velocity per PCM error", "1/s", 0, 50)
    pcm_rate: float = parameter(0.0, "k_D, velocity per rate of the PCM error", "", 0, 2)
    zmp: float = parameter(0.6, "k_Z, velocity per ZMP error, in parts of ω", "", 0, 5)
    filter_time: float = parameter(0.02, "low-pass of the ZMP error", "s", 1e-4, 1)
    ramp_time: float = parameter(0.2, "time over which the gains grow and fade with contact", "s", 0.01, 5)
    limit: float = parameter(0.05, "largest shift of the CoM in x and in y", "m", 0, 0.3)


class PaperBalance:
    """v = v_ref + g (k_C e_C + k_D ė_C − k_Z ω e_Z) with e_C = c_ref − c and e_Z = p_ref − p.

    A velocity per error is the I of a position per error, a velocity per its rate the P. Adaptive: g goes
    from 0 to 1 while the feet carry the robot and back while they do not.
    """

    def __init__(
        self, config: PaperConfig, ik: IkConfig, feedback: bool, robot: RobotModel, where: Kinematics,
        period: float,
    ) -> None:  # fmt: skip
        """Args: gains, the IK's, False for a reference left as it is, the robot and where it is, tick [s]."""
        self._config = config
        self._feedback = feedback
        self._period = period
        self._body, self._wanted = where.body, where.wanted
        self._shifted = ShiftedReference(ik, robot, where.wanted)
        self._shift: Array = np.zeros(2)
        self._zmp_error: Array = np.zeros(2)
        self._gain = 0.0

    def correct(self, now: Situation) -> Correction:
        """One tick."""
        dt, limit = self._period, self._config.limit
        rate = self._velocity(now) if self._feedback else np.zeros(2)
        old = self._shift
        self._shift = np.minimum(np.maximum(old + dt * rate, -limit), limit)
        rate = (self._shift - old) / dt
        reference = self._shifted.step(now.q_wanted, now.v_wanted, self._shift, rate, dt)
        return Correction(Point.on_ground(now.zmp.xyz), reference)

    def _velocity(self, now: Situation) -> Array:
        """The correction of the CoM's velocity, shape (2,) [m/s]."""
        config, dt, body, wanted = self._config, self._period, self._body, self._wanted
        carried = now.measured_zmp is not None
        self._gain = min(max(self._gain + (1.0 if carried else -1.0) * dt / config.ramp_time, 0.0), 1.0)
        zmp_error = np.zeros(2) if now.measured_zmp is None else now.zmp.xyz[:2] - now.measured_zmp
        share = 1.0 - math.exp(-dt / config.filter_time)
        self._zmp_error = self._zmp_error + share * (zmp_error - self._zmp_error)
        # Against a pull of the hands the CoM rests elsewhere.
        pcm_error = now.hands.resting_com(wanted.com[:2]) - body.com[:2]
        pcm_rate = wanted.com_velocity[:2] - body.com_velocity[:2]
        omega = natural_frequency(float(wanted.com[2]))
        velocity = config.pcm * pcm_error + config.pcm_rate * pcm_rate
        return np.asarray(self._gain * (velocity - config.zmp * omega * self._zmp_error))
