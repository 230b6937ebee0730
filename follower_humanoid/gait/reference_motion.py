"""The reference motion: walker, pendulum and body tick by tick, and what they do about a DCM off its plan."""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.balance.support_polygon import convex_hull, polygon_margin
from follower_humanoid.core.samples import Array, Gait, Side
from follower_humanoid.gait.capture import capture
from follower_humanoid.gait.changes import GaitChanges, ZmpRoom
from follower_humanoid.gait.feet import FootPose, sole_corners
from follower_humanoid.gait.motion_config import CompositionConfig
from follower_humanoid.gait.pendulum import ReferencePendulum, momentum_shift, natural_frequency
from follower_humanoid.gait.preview import planned_dcm
from follower_humanoid.gait.sequence import Sequence
from follower_humanoid.gait.walk_plan import Plan
from follower_humanoid.gait.walker import Walker
from follower_humanoid.gait.whole_body import ReferenceBody
from follower_humanoid.robot.model import RobotModel

STANDING = Gait(walk_speed=0.0, walk_dir=0.0, step_length=1.0, step_height=1.0, heading=0.0)
HELD = 0.02  # a DCM this far inside the feet can be held by the ZMP [m]
NEAR = 0.9  # part of the tolerance within which the horizon of the preview makes no difference
RECOVERED = 0.5  # recovery ends when the DCM error is below this part of what began it


class ReferenceMotion:
    """Walker, pendulum and body that move together, tick by tick.

    Attributes:
        walker: Half-steps and plan.
        pendulum: Reference CoM, DCM, ZMP.
        body: Reference configuration.
        steady: False while a foot had better not leave the ground.
    """

    def __init__(
        self,
        config: CompositionConfig,
        robot: RobotModel,
        sequence: Sequence,
        feet: dict[Side, FootPose],
        q: Array,
    ) -> None:
        """Starts at rest in the measured configuration q, shape (52,), on the measured feet."""  # fmt: skip
        self._config = config
        self._mass = robot.mass
        self.body = ReferenceBody(config.body, robot, q)
        com = self.body.ik.com[:2]
        self.walker = Walker(config.walker, config.footsteps, sequence, feet, com)
        self.pendulum = ReferencePendulum(com)
        self.steady = True
        self._changes = GaitChanges(config.changes, STANDING, config.walker.preview)

    def within_reach(self, wanted: Gait) -> Gait:
        """Of the walking parameters asked for, what the walk can follow in this tick."""
        if wanted == self._changes.used:  # as nearly always: what a change may cost need not be known
            return self._changes.used
        config, ik = self._config, self.body.ik
        omega = natural_frequency(ik.com_height)
        dcm = self.pendulum.state.dcm + omega * momentum_shift(ik.angular_momentum, self._mass)
        room = ZmpRoom(omega, config.dcm_convergence, config.zmp_reach, config.zmp_reach_double)
        return self._changes.step(wanted, self.walker, dcm, room)

    def advance(self, gait: Gait, dcm: Array | None, dt: float) -> tuple[FootPose, ...]:
        """One tick after the walker's.

        Args:
            gait: Walking parameters.
            dcm: Measured, in world, shape (2,) [m]; None before the first.
            dt: Tick [s].

        Returns:
            The coming footsteps.
        """
        config, walker, ik = self._config, self.walker, self.body.ik
        plan = walker.plan_ahead(gait)
        omega = natural_frequency(ik.com_height)
        momentum = momentum_shift(ik.angular_momentum, self._mass)
        horizon = config.walker.preview if config.dcm_preview else 0.0
        dcm_plan = planned_dcm(walker.zmp.position, plan.zmp, omega, horizon)
        if dcm is not None and config.capture.enabled:
            spin = omega * momentum  # what the angular momentum does to the DCM
            self._recover(dcm, dcm_plan - spin)
            if not self._as_planned(dcm + spin - dcm_plan):
                self._catch(dcm + spin, plan, omega)
        double = walker.swinging is None
        rate, reach = config.dcm_convergence, config.zmp_reach_double if double else config.zmp_reach
        if self.walker.recovering:
            rate = config.recovery_convergence
            reach = config.recovery_reach_double if double else config.recovery_reach
        self.pendulum.advance(walker.zmp.position, dcm_plan, momentum, omega, rate, reach, dt)
        self.body.advance(walker, plan, self.pendulum.state, omega, config.walker.preview, dt)
        return plan.footsteps

    def _recover(self, dcm: Array, wanted: Array) -> None:
        """Too far off, the reference follows reality: it starts from the measured DCM until on plan."""
        limit, now = self._config.capture.take_over, dcm.tolist()
        if self.walker.half_step is None:  # no step to come: what is wanted stays where it is
            self.walker.recovering = False
        elif math.dist(now, self.pendulum.state.dcm.tolist()) > limit:
            self.walker.recovering = True
        elif math.dist(now, wanted.tolist()) < RECOVERED * limit:
            self.walker.recovering = False
        if self.walker.recovering:
            self.pendulum.take_over(dcm)

    def _as_planned(self, error: Array) -> bool:
        """Whether nothing is moved and the DCM is so near its plan that `capture` would leave it at that."""
        untouched = self.steady and self.walker.untouched
        return untouched and math.hypot(*error.tolist()) < NEAR * self._config.capture.tolerance

    def _catch(self, dcm: Array, plan: Plan, omega: float) -> None:
        """Place and time of the present landing; before it, whether the foot may lift off."""
        config, walker = self._config.capture, self.walker
        self.steady = True
        outlook = walker.outlook(plan)
        if outlook is None:
            return
        wanted = capture(dcm, outlook, omega, config)
        walker.catch(wanted, outlook)
        self.steady = wanted.offset < config.lift_off or not self._held_by_feet(dcm)
        if not outlook.lead and wanted.shift.any():
            self.walker.recovering = True

    def _held_by_feet(self, dcm: Array) -> bool:
        """Whether the feet on the ground can hold the DCM where it is."""
        corners = [corner for foot in self.walker.feet.values() for corner in sole_corners(foot)]
        return polygon_margin(convex_hull(np.array(corners)), dcm) > HELD
