"""The world: PyBullet server, gravity and ground. Robots and objects are loaded into it."""

from __future__ import annotations

import math
import os
import tempfile
from dataclasses import dataclass

import numpy as np
import pybullet

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.robot.model import GRAVITY


@dataclass(frozen=True)
class GroundConfig:
    """The ground under the robot."""

    friction: float = parameter(0.8, "Coulomb friction of the ground, soles and other links", "", 0.0, 2.0)
    slope: float = parameter(
        0.0, "how much the ground falls ahead at the start; `world` is level with it", "rad", -0.5, 0.5
    )


class Ground:
    """The ground: the plane z = 0 of world, on which gravity need not be normal.

    Attributes:
        friction: Coulomb coefficient.
        gravity: Acceleration in world, whose z axis is normal to the ground, shape (3,) [m/s²].
    """

    def __init__(self, config: GroundConfig) -> None:
        """A plane that falls ahead by the slope."""
        self.friction = config.friction
        ahead, down = math.sin(config.slope), math.cos(config.slope)
        self.gravity: Array = np.array([GRAVITY * ahead, 0.0, -GRAVITY * down])


class World:
    """One PyBullet server; several live side by side in one process.

    Attributes:
        client: PyBullet's id of this server.
        step_length: Physics step [s].
        ground: Shape of the ground.
    """

    def __init__(self, step_length: float, ground: Ground) -> None:
        """An empty world with gravity and ground."""
        self.step_length = step_length
        self.ground = ground
        self.client: int = pybullet.connect(pybullet.DIRECT)
        if self.client < 0:
            raise ConfigurationError("no PyBullet server could be started in this process")
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step_length, numSolverIterations=50, numSubSteps=0,
            deterministicOverlappingPairs=1, enableFileCaching=0, physicsClientId=self.client,
        )
        pybullet.setGravity(*ground.gravity, physicsClientId=self.client)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self.client)
        self.ground_body: int = pybullet.createMultiBody(0, plane, physicsClientId=self.client)
        pybullet.changeDynamics(
            self.ground_body, -1, lateralFriction=1.0, restitution=0.0, physicsClientId=self.client
        )

    def load(self, urdf: str, fixed: bool = False) -> int:
        """Puts a robot, given as URDF text, into the world; returns PyBullet's body id.

        Args:
            urdf: The description.
            fixed: True fixes the base to the world.

        Raises:
            ConfigurationError: PyBullet cannot read it.
        """
        handle, path = tempfile.mkstemp(suffix=".urdf")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(urdf)
            body: int = pybullet.loadURDF(
                path, flags=pybullet.URDF_USE_INERTIA_FROM_FILE, useFixedBase=fixed,
                physicsClientId=self.client,
            )
        except pybullet.error as error:
            raise ConfigurationError(f"PyBullet cannot load the URDF: {error}") from None
        finally:
            os.unlink(path)
        return body

    def step(self) -> None:
        """Advances everything in the world by one physics step."""
        pybullet.stepSimulation(self.client)

    def link_on_ground(self, body: int) -> int | None:
        """Index of the first link of a body that Bullet sees touching the ground; −1 is the base."""
        for contact in pybullet.getContactPoints(self.ground_body, body, physicsClientId=self.client):
            if contact[8] <= 0.0:
                return int(contact[4])
        return None

    def close(self) -> None:
        """Ends the server; closing twice is harmless."""
        if self.client >= 0:
            pybullet.disconnect(self.client)
            self.client = -1
