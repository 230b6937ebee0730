"""The world: PyBullet server, gravity and ground. Robots and objects are loaded into it."""

from __future__ import annotations

import math
import os
import tempfile
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant import bullet_kernels
from follower_humanoid.plant.bullet_client import BASE, BulletClient, expect_taken
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
        client: The server.
        step_length: Physics step [s].
        ground: Shape of the ground.
        ground_body: Bullet's id of it.
    """

    def __init__(self, step_length: float, ground: Ground) -> None:
        """An empty world with gravity and ground."""
        self.step_length = step_length
        self.ground = ground
        self.client = BulletClient()
        self.client.set_engine(step_length, ground.gravity.tolist())
        self.ground_body = self.client.add_ground()
        self.client.set_contact(self.ground_body, BASE, 1.0)

    def load(self, urdf: str, fixed: bool = False) -> int:
        """Puts a robot, given as URDF text, into the world; returns Bullet's id of its body.

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
            body = self.client.load(path, fixed)
        finally:
            os.unlink(path)
        if body < 0:
            raise ConfigurationError("PyBullet cannot load the URDF")
        return body

    def step(self) -> None:
        """Advances everything in the world by one physics step."""
        expect_taken(bullet_kernels.step(self.client.handle))

    def link_on_ground(self, body: int) -> int | None:
        """Index of the first link of a body that Bullet sees touching the ground; −1 is the base."""
        link = bullet_kernels.link_on(self.client.handle, self.ground_body, body)
        return None if link == bullet_kernels.NO_LINK else link

    def close(self) -> None:
        """Ends the server; closing twice is harmless."""
        self.client.close()
