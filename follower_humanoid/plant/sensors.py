"""What the robot's sensors say: means over the control tick, in each sensor's frame, with errors."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import SIDES, Array, Inertial, Joints, Odometry, Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant.pulls import Pull, add_in_joint
from follower_humanoid.plant.robot_plant import RobotPlant
from follower_humanoid.plant.sensor_errors import Readings, SensorConfig, SensorErrors
from follower_humanoid.plant.sensor_sums import add_step, mean_wrenches
from follower_humanoid.robot.model import BASE_DOF


class _Soles:
    """Where the soles' frames are fixed, left first.

    Attributes:
        joints: Pinocchio joints that carry them, (2,).
        axes, offsets: Rotations (2, 3, 3) and origins (2, 3) in their joints' frames.
    """

    def __init__(self, plant: RobotPlant) -> None:
        frames = [plant.model.frames[plant.robot.frame_id(f"{side.prefix}_sole")] for side in SIDES]
        self.joints = np.array([frame.parentJoint for frame in frames])
        self.axes = np.array([frame.placement.rotation for frame in frames])
        self.offsets = np.array([frame.placement.translation for frame in frames])


class _Wrists:
    """The joints that the wrists' sensors measure at, and the hands behind them, left first.

    Attributes:
        joints: Their Pinocchio ids, (2,).
        hand_of: Joint → which hand, 0 or 1.
        poses: Of the joints in world, views that follow the plant, (4, 3) each.
        columns: Columns of the Jacobian that move each, (2, n).
        masses, levers, inertias: Of the hands, in their joints' frames: m (2,), centre (2, 3), about the
            centre (2, 3, 3).
        left_at_rest, right_at_rest: Force through each joint at no acceleration, views that follow the
            plant, (6,) each.
        displaced: Hand → place of its sensor's frame in the joint's, where they are not the same.
    """

    def __init__(self, plant: RobotPlant) -> None:
        model, ids = plant.model, [plant.robot.frame_id(f"{side.prefix}_wrist") for side in SIDES]
        points = [plant.held_point(frame) for frame in ids]
        for joint in (point.joint for point in points):
            if len(model.subtrees[joint]) > 1:
                name = model.names[joint]
                raise ConfigurationError(
                    f"URDF: another joint follows {name}, which must be the last of its arm"
                )
        self.joints = np.array([point.joint for point in points])
        self.hand_of = {point.joint: hand for hand, point in enumerate(points)}
        self.poses: list[Array] = [plant.joint_poses[point.joint] for point in points]
        self.columns = np.array([point.columns for point in points])
        hands = [model.inertias[point.joint] for point in points]
        self.masses = np.array([hand.mass for hand in hands])
        self.levers = np.array([hand.lever for hand in hands])
        self.inertias = np.array([hand.inertia for hand in hands])
        at_rest: list[Array] = [plant.data.f[point.joint].vector for point in points]
        self.left_at_rest, self.right_at_rest = at_rest
        places = [model.frames[frame].placement for frame in ids]
        self.displaced = {hand: place for hand, place in enumerate(places) if not place.isIdentity()}


class Sensors:
    """Gathers every physics step, reads at the control tick."""

    def __init__(self, config: SensorConfig, plant: RobotPlant) -> None:
        """Sensors of one robot at rest."""
        self._errors, self._plant = SensorErrors(config), plant
        self._soles, self._wrists = _Soles(plant), _Wrists(plant)
        # Cleared in one piece, which is parted into wrenches of feet and wrists, and specific force.
        self._sums = np.zeros(27)
        self._foot_sums, self._wrist_sums = self._sums[:24].reshape(2, 2, 6)
        self._specific_force = self._sums[24:]
        self._count = 0
        self._v = plant.v.copy()
        self._rotation, self._base = plant.rotation, plant.bullet.base_twist
        self._acceleration = np.zeros_like(plant.v)

    def clear(self) -> None:
        """Starts a control tick."""
        self._sums.fill(0.0)
        self._count = 0

    def before_step(self) -> None:
        """Remembers the state at which the forces of the coming physics step act."""
        self._v[:] = self._plant.v
        self._rotation, self._base = self._plant.rotation, self._plant.bullet.base_twist

    def after_step(self, pulls: tuple[Pull, ...] = ()) -> None:
        """Adds one physics step and what people did in it."""
        plant, wrists = self._plant, self._wrists
        if plant.soles.touching:
            plant.soles.add_wrenches_to(self._foot_sums)
        # Force through a wrist joint = inertia and weight of the hand less what acts on it.
        add_step(
            self._v, plant.v, self._base, plant.bullet.base_twist, self._rotation, plant.world.ground.gravity,
            plant.world.step_length, plant.joint_poses, plant.world_jacobian, wrists.joints, wrists.columns,
            wrists.left_at_rest, wrists.right_at_rest, wrists.masses, wrists.levers, wrists.inertias,
            self._acceleration, self._specific_force, self._wrist_sums,
        )  # fmt: skip
        for pull in pulls:
            point = plant.held_point(pull.frame)
            hand = wrists.hand_of.get(point.joint)
            if hand is not None:
                total = self._wrist_sums[hand]
                add_in_joint(wrists.poses[hand], point.offset, pull.force, pull.torque, total)
        self._count += 1

    def at_rest(self) -> None:
        """Gathers static equilibrium, for the readings before the first step."""
        self.clear()
        self.before_step()
        self.after_step()  # no step was made: no acceleration

    def read(self) -> Readings:
        """Every sensor at the current tick."""
        plant = self._plant
        # Copied in one piece; what is read are parts of the copies.
        q, v = plant.q.copy(), plant.v.copy()
        turn, spin = q[3:7], v[3:6]
        exact = Readings(
            Joints(q[7:], v[BASE_DOF:], plant.effort),
            Odometry(q[:3], turn, v[:3], spin),
            Inertial(turn, spin, self._specific_force / self._count),
            *self._mean_wrenches(),
        )
        return self._errors.added_to(exact) if self._errors.any else exact

    def _mean_wrenches(self) -> list[Wrench]:
        """Those of left and right foot, left and right wrist, means of the tick.

        Of the feet, in world, expressed at and in the sole frame of its end: so force and moment balance
        the change of momentum over the tick exactly.
        """
        plant, soles, means = self._plant, self._soles, np.empty((2, 4, 3))
        plant.renew_dynamics()  # the step to come needs it too
        mean_wrenches(
            plant.joint_poses, soles.joints, soles.axes, soles.offsets, self._foot_sums, self._wrist_sums,
            self._count, means,
        )  # fmt: skip
        for hand, place in self._wrists.displaced.items():
            in_joint = pin.Force(means[:, 2 + hand].ravel())
            means[:, 2 + hand] = place.actInv(in_joint).vector.reshape(2, 3)
        forces, torques = means
        return list(map(Wrench, forces, torques))
