"""The robot's world made and moved by PyBullet's Python functions: what ours is compared with."""

import numpy as np
import pybullet
from plant_bench import robot

from follower_humanoid.plant.plant_urdf import bullet_body
from follower_humanoid.robot.model import GRAVITY

STEP = 0.001


class Reference:
    """A server of its own, with the ground and a robot."""

    def __init__(self, folder):
        self.client = pybullet.connect(pybullet.DIRECT)
        own = {"physicsClientId": self.client}
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP, numSolverIterations=50, numSubSteps=0, deterministicOverlappingPairs=1, **own
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY, **own)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **own)
        self.ground = pybullet.createMultiBody(0, plane, **own)
        pybullet.changeDynamics(self.ground, -1, lateralFriction=1.0, restitution=0.0, **own)
        path = folder / "robot.urdf"
        path.write_text(bullet_body(robot().urdf))
        self.body = pybullet.loadURDF(str(path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE, **own)
        count = pybullet.getNumJoints(self.body, **own)
        for link in range(-1, count):
            pybullet.changeDynamics(
                self.body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0,
                maxJointVelocity=1e4, **own,
            )  # fmt: skip
            # In one call with the others PyBullet 3.2.7 leaves a link's friction at 0.5.
            pybullet.changeDynamics(self.body, link, lateralFriction=0.8, restitution=0.0, **own)
            assert pybullet.getDynamicsInfo(self.body, link, **own)[1] == 0.8
            if link >= 0:
                pybullet.setCollisionFilterGroupMask(self.body, link, 1, 2, **own)
        infos = [pybullet.getJointInfo(self.body, n, **own) for n in range(count)]
        names = [info[1].decode() for info in infos]
        self.links = [info[12].decode() for info in infos]
        self.joints = [names.index(name) for name in robot().joint_names]
        pybullet.setJointMotorControlArray(
            self.body, self.joints, pybullet.VELOCITY_CONTROL, forces=[0.0] * 45, **own
        )

    def place(self, position, quat, linear, spin, angles, rates):
        own = {"physicsClientId": self.client}
        pybullet.resetBasePositionAndOrientation(self.body, position, quat, **own)
        pybullet.resetBaseVelocity(self.body, linear, spin, **own)
        for joint, angle, rate in zip(self.joints, angles, rates, strict=True):
            pybullet.resetJointState(self.body, joint, angle, rate, **own)

    def step(self, torque, links, forces, places, pulled, force, twist, place):
        own = {"physicsClientId": self.client}
        pybullet.getLinkState(self.body, 0, computeForwardKinematics=True, **own)
        pybullet.setJointMotorControlArray(
            self.body, self.joints, pybullet.TORQUE_CONTROL, forces=torque.tolist(), **own
        )
        for n, link in enumerate(links.tolist()):
            if forces[n, 2] > 0.0:
                pybullet.applyExternalForce(
                    self.body, link, forces[n].tolist(), places[n].tolist(), pybullet.WORLD_FRAME, **own
                )
        pybullet.applyExternalForce(
            self.body, pulled, force.tolist(), place.tolist(), pybullet.WORLD_FRAME, **own
        )
        pybullet.applyExternalTorque(self.body, pulled, twist.tolist(), pybullet.WORLD_FRAME, **own)
        pybullet.stepSimulation(**own)

    def close(self):
        pybullet.disconnect(self.client)

    @property
    def state(self):
        own = {"physicsClientId": self.client}
        states = pybullet.getJointStates(self.body, self.joints, **own)
        pose = pybullet.getBasePositionAndOrientation(self.body, **own)
        velocity = pybullet.getBaseVelocity(self.body, **own)
        angles, rates = ([state[index] for state in states] for index in (0, 1))
        return np.r_[pose[0], pose[1], velocity[0], velocity[1], angles, rates]

    @property
    def link_on_ground(self):
        contacts = pybullet.getContactPoints(self.ground, self.body, physicsClientId=self.client)
        return next((contact[4] for contact in contacts if contact[8] <= 0.0), None)
