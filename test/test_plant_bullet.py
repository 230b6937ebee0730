"""What goes to Bullet and comes from it by its C interface is what PyBullet's Python functions do."""

import subprocess
import sys

import numpy as np
import pytest
from bullet_reference import STEP, Reference
from plant_bench import plant, robot

from follower_humanoid.errors import ConfigurationError, PhysicsError
from follower_humanoid.plant import bullet_kernels
from follower_humanoid.plant.bullet_client import BulletClient
from follower_humanoid.plant.bullet_library import library
from follower_humanoid.plant.plant_urdf import bullet_body
from follower_humanoid.plant.world import Ground, GroundConfig, World


@pytest.fixture
def reference(tmp_path):
    made = Reference(tmp_path)
    yield made
    made.close()


@pytest.fixture
def simulator():
    made = plant()
    yield made
    made.close()


def state_of(bullet):
    places = bullet._places
    positions, rates = bullet._positions, bullet._rates
    return np.r_[positions[:7], rates[:6], positions[places[:, 0]], rates[places[:, 1]]]


@pytest.mark.parametrize("height", [5.0, 0.83])
def test_both_move_the_robot_to_the_same_bits(simulator, reference, height):
    """In the air, and falling on its shanks, since feet are no shapes of Bullet's."""
    bullet, world = simulator.plant.bullet, simulator.plant.world
    random = np.random.default_rng(int(10 * height))
    # The base's frame in this URDF is that of its principal axes.
    q = np.r_[0.1, -0.2, height, 0.0, 0.0, 0.0, 1.0, random.uniform(-0.1, 0.1, 45)]
    v = random.normal(0.0, 0.1, 51)
    bullet.place(q, v)
    center = bullet.center_in_base
    linear = v[:3] + np.cross(v[3:6], center)
    reference.place(list(q[:3] + center), [0, 0, 0, 1], list(linear), list(v[3:6]), q[7:], v[6:])
    assert bullet.link_names == {-1: "base_link"} | dict(enumerate(reference.links))
    touched = set()
    for _ in range(150):
        torque = random.normal(size=45)
        links = random.integers(-1, 45, 12).astype(np.int32)
        forces, places = random.normal(size=(12, 3)), bullet.q[:3] + random.normal(0.0, 0.3, (12, 3))
        pull = random.normal(size=3), random.normal(size=3), bullet.q[:3] + random.normal(size=3)
        bullet.drive(torque)
        bullet.support(links, forces, places)
        bullet.pull(7, *pull)
        world.step()
        bullet.read()
        reference.step(torque, links, forces, places, 7, *pull)
        assert state_of(bullet).tobytes() == reference.state.tobytes()
        assert world.link_on_ground(bullet.body) == reference.link_on_ground
        touched.add(reference.link_on_ground)
    assert (touched == {None}) == (height == 5.0)


def test_a_closed_server_is_no_crash(simulator):
    bullet, world = simulator.plant.bullet, simulator.plant.world
    simulator.close()
    assert world.link_on_ground(bullet.body) is None
    for asked in (
        world.step,
        bullet.read,
        world.client.add_ground,
        lambda: bullet.drive(np.zeros(45)),
        lambda: bullet.support(np.zeros(1, dtype=np.int32), np.ones((1, 3)), np.zeros((1, 3))),
        lambda: bullet.pull(-1, np.ones(3), np.ones(3), np.zeros(3)),
    ):
        with pytest.raises(PhysicsError, match="does not answer"):
            asked()


def test_arrays_of_another_size_are_refused(simulator):
    bullet, links = simulator.plant.bullet, np.zeros(2, dtype=np.int32)
    for asked in (
        lambda: bullet.drive(np.zeros(44)),
        lambda: bullet.support(links, np.ones((1, 3)), np.ones((2, 3))),
        lambda: bullet.support(links, np.ones((2, 3)), np.ones((2, 2))),
        lambda: bullet.pull(0, np.ones(2), np.ones(3), np.ones(3)),
        lambda: bullet.pull(0, np.ones(3), np.ones(3), np.ones(1)),
    ):
        with pytest.raises(PhysicsError, match="wrong size"):
            asked()


def test_a_body_that_is_not_there_is_silent(simulator):
    bullet = simulator.plant.bullet
    bullet.body += 1
    with pytest.raises(PhysicsError, match="does not answer"):
        bullet.read()
    with pytest.raises(PhysicsError, match="no body 99"):
        simulator.plant.world.client.state_sizes(99)


def test_servers_do_not_know_each_other():
    worlds = [World(STEP, Ground(GroundConfig())) for _ in range(3)]
    bodies = [world.load(bullet_body(robot().urdf)) for world in worlds]
    worlds[1].close()
    assert len(set(bodies)) == 1
    assert len(worlds[0].client.joints(bodies[0])) == len(worlds[2].client.joints(bodies[2])) == 45
    for world in worlds:
        world.close()


def test_a_step_of_one_world_is_none_of_another():
    one, other = plant(), plant()
    before = other.plant.q.tobytes()
    one.plant.step(np.zeros(45))
    other.plant.bullet.read()
    assert other.plant.q.tobytes() == before != one.plant.q.tobytes()
    one.close()
    other.close()


def test_what_is_no_urdf_is_told():
    world = World(STEP, Ground(GroundConfig()))
    with pytest.raises(ConfigurationError, match="cannot load"):
        world.load("<robot name='x'><link")
    world.close()


def test_others_do_not_get_its_copies_of_libraries():
    """Pinocchio, or ROS, loaded after it would else read XML by PyBullet's tinyxml2."""
    code = (
        "import ctypes, follower_humanoid.plant.bullet_kernels\n"
        "assert not hasattr(ctypes.CDLL(None), 'b3ConnectPhysicsDirect')"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (None, "not installed"),
        ("libm.so.6", "has no b3ConnectPhysicsDirect; valid:"),
        ("/nowhere.so", "no library of PyBullet"),
    ],
)
def test_without_pybullet_or_with_another_one_it_says_so(monkeypatch, found, words):
    spec = None if found is None else type("Spec", (), {"origin": found})
    monkeypatch.setattr("importlib.util.find_spec", lambda name: spec)
    with pytest.raises(ConfigurationError, match=words):
        library.__wrapped__()


def test_a_client_can_be_closed_twice():
    client = BulletClient()
    assert bullet_kernels.step(client.handle)
    client.close()
    client.close()
    assert not bullet_kernels.step(client.handle)
