"""An elastic board in front of the robot, for hands to press on: stiff, plane and without friction.

The board is the half-space ahead of a plane across x. A gripper that is δ behind that plane feels

    f_x = −max(0, k δ + d δ̇)

and nothing along y and z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.plant.pulls import Pull
from follower_humanoid.plant.robot_plant import RobotPlant


@dataclass(frozen=True)
class BoardConfig:
    """The board."""

    stiffness: float = parameter(0.0, "stiffness of the elastic board; 0: there is none", "N/m", 0.0, 1e5)
    damping: float = parameter(0.0, "damping of the elastic board", "N·s/m", 0.0, 1e3)
    distance: float = parameter(0.45, "distance ahead of base_link at time 0", "m", 0.1, 2.0)


class Board:
    """Contact of both grippers with the board.

    Attributes:
        place: x of its surface in world [m].
        force: On left and right gripper, in world, summed over the steps of the tick, shape (2, 3) [N].
    """

    def __init__(self, config: BoardConfig, plant: RobotPlant) -> None:
        """Puts the board in front of the robot as it stands."""
        self._config, self._plant = config, plant
        self._data = plant.model.createData()
        self._frames = [plant.robot.frame_id(name) for name in ("l_gripper", "r_gripper")]
        self.place = float(plant.q[0]) + config.distance
        self.force = np.zeros((2, 3))
        self._steps = 0

    def clear(self) -> None:
        """Starts a control tick."""
        self.force = np.zeros((2, 3))
        self._steps = 0

    def pulls(self) -> tuple[Pull, ...]:
        """What the board does to the grippers in the physics step that comes."""
        plant, data = self._plant, self._data
        pin.forwardKinematics(plant.model, data, plant.q, plant.v)
        self._steps += 1
        pulls = []
        for hand, frame in enumerate(self._frames):
            depth = float(pin.updateFramePlacement(plant.model, data, frame).translation[0]) - self.place
            if depth <= 0.0:
                continue
            speed = pin.getFrameVelocity(plant.model, data, frame, pin.LOCAL_WORLD_ALIGNED).linear[0]
            pressing = max(0.0, self._config.stiffness * depth + self._config.damping * float(speed))
            force = np.array([-pressing, 0.0, 0.0])
            self.force[hand] += force
            pulls.append(Pull(frame, force, np.zeros(3)))
        return tuple(pulls)

    def mean_force(self) -> Array:
        """Mean over the control tick so far, shape (2, 3) [N]."""
        mean: Array = self.force / max(1, self._steps)
        return mean
