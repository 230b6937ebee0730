"""What a balance law works from and what it answers."""

from __future__ import annotations

from typing import NamedTuple

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.core.samples import Array, ContactPlan, Joints, Point, Wrench
from follower_humanoid.robot.body_state import BodyState


class Kinematics(NamedTuple):
    """Where the robot is and where it shall be: always the same objects, which follow from tick to tick.

    Attributes:
        body: Measured.
        soles: Of left and right, measured: axes and origin in world, shape (4, 3), views of `body`.
        wanted: Of the reference motion.
    """

    body: BodyState
    soles: tuple[Array, Array]
    wanted: BodyState


class Situation(NamedTuple):
    """One tick, besides the `Kinematics`: the complete reference, hands and feet.

    Attributes:
        hands: Effect of the hand forces.
        q_wanted, v_wanted: Configuration of the reference, shape (52,), and velocity, shape (51,).
        zmp, dcm: Plan in world, over the ground.
        measured_zmp: In world, shape (2,) [m]; None where the feet carry too little.
        contacts: Planned shares of the weight.
    """

    hands: HandEffect
    q_wanted: Array
    v_wanted: Array
    zmp: Point
    dcm: Point
    measured_zmp: Array | None
    contacts: ContactPlan


class Correction(NamedTuple):
    """What a law asks for.

    Attributes:
        zmp: Commanded.
        reference: Corrected joint reference.
        dcm: Measured; None under a law that knows none.
        left_foot, right_foot: What the ground should do to each foot, at and in its sole frame; None
            under a law that leaves it to stiff joints.
    """

    zmp: Point
    reference: Joints
    dcm: Point | None = None
    left_foot: Wrench | None = None
    right_foot: Wrench | None = None
