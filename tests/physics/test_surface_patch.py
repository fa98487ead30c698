"""Where the surface is drawn in frames: a patch of the plane, at the contact point."""

from typing import Any

import numpy as np
import pytest

from prp_gym.envs import PRPEnv
from prp_gym.envs.base.contact_starts import ContactStart, ContactWorld
from prp_gym.physics import TIP_RADIUS, Physics, PhysicsSettings, Surface
from prp_gym.robot.arrays import Array
from tests.support.contact_episodes import ARM, CONTACT_IDS, depth_of, environment, ground_truth_of
from tests.support.drawn_starts import drawn_start

BOUND = 1e-14  # some roundings of lengths below 1 m


@pytest.fixture(params=CONTACT_IDS)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def drawn_patch(physics: Physics, simulation: int = 0) -> tuple[Array, Array]:
    """The point of the patch's middle (3) [m] where a tip touches it, and its normal."""
    model = physics.model(simulation)
    body = model.body("surface").id
    w, x, y, z = model.body_quat[body]
    normal = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    return model.body_pos[body] + TIP_RADIUS * normal, normal


def begun(environment_id: str, seed: int, scenario: str, **options: Any) -> tuple[Physics, ContactStart]:
    """The world at the start of an episode, and how that was drawn."""
    env: PRPEnv = environment(environment_id, scenario=scenario)
    env.reset(seed=seed, options=options)
    assert isinstance(env.task.parts.world, ContactWorld)
    assert isinstance(env.physics, Physics)
    start = drawn_start(env.task, seed, options)
    np.testing.assert_array_equal(ground_truth_of(env)["joint_position"], start.joint_position)
    return env.physics, start


@pytest.mark.parametrize("scenario", ["report", "randomized"])
def test_drawn_patch_lies_where_the_tip_touches_the_surface(environment_id: str, scenario: str) -> None:
    for seed in range(3):
        physics, start = begun(environment_id, seed, scenario)
        middle, normal = drawn_patch(physics)
        np.testing.assert_allclose(normal, start.surface.normal[0], rtol=0, atol=BOUND)
        np.testing.assert_allclose(middle, start.touch, rtol=0, atol=BOUND)
        assert start.surface.normal[0] @ start.touch == pytest.approx(start.surface.offset[0], abs=BOUND)
        # the start is before it, not far to the side: 0.03 rad at a reach of 0.7 m, and 0.15 rad of link 3
        tip = ARM.forward_kinematics(start.joint_position)[:3]
        if scenario == "randomized":
            across = tip - start.touch + depth_of(start, start.joint_position) * normal
            assert np.linalg.norm(across) < 0.03 * 0.7 + 0.15 * 0.3


def test_patch_of_a_surface_that_is_given_lies_where_the_contact_projects_on_it(environment_id: str) -> None:
    given = {"surface_normal": (0.0, -3.0, 4.0), "surface_offset": -0.6}
    physics, start = begun(environment_id, 4, "randomized", **given)
    middle, normal = drawn_patch(physics)
    unit = np.array([0.0, -0.6, 0.8])
    np.testing.assert_allclose(normal, unit, rtol=0, atol=BOUND)
    np.testing.assert_allclose(middle, start.touch + (-0.6 - unit @ start.touch) * unit, rtol=0, atol=BOUND)
    # the patch is drawn at the contact point all the same
    np.testing.assert_array_equal(start.touch, begun(environment_id, 4, "randomized")[1].touch)


def test_patches_lie_around_the_given_centers_and_by_default_around_the_tip_at_home() -> None:
    physics = Physics(settings=PhysicsSettings(surface=True), num_simulations=4)
    normals = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.6, 0.8]])
    offsets, ids = np.array([0.3, -0.2, 0.1]), np.array([0, 1, 3])
    surface = Surface(np.full(3, 50.0), np.zeros(3), normals, offsets)
    centers = np.random.default_rng(0).uniform(-0.5, 0.5, (3, 3))
    home = ARM.forward_kinematics(np.zeros(3))[:3]
    for given, expected in ((centers, centers), (None, np.tile(home, (3, 1)))):
        physics.set_surface(ids, surface, given)
        for row, normal, offset, center in zip(ids, normals, offsets, expected, strict=True):
            middle, found = drawn_patch(physics, int(row))
            np.testing.assert_allclose(found, normal, rtol=0, atol=BOUND)
            assert normal @ middle == pytest.approx(offset, abs=BOUND)
            # nothing but a part along the normal is between the center and the patch
            np.testing.assert_allclose(np.cross(middle - center, normal), 0.0, rtol=0, atol=BOUND)


def test_center_of_the_patch_moves_no_force() -> None:
    surface, ids = Surface.single(300.0, (0.0, -1.0, 0.0), 0.44), np.array([0])
    forces = []
    for center in (np.zeros((1, 3)), np.array([[2.0, -0.44, 1.0]])):
        physics = Physics(settings=PhysicsSettings(surface=True))
        physics.set_surface(ids, surface, center)
        physics.reset(ids, np.array([[0.0, -0.15, 0.0]]), np.zeros((1, 3)))
        forces.append(physics.contact_force[0].copy())
    # 0.05 m deep; the position of the plane's frame causes roundings of 1e-16 m times 300 N/m
    assert forces[0][1] == pytest.approx(15.0, rel=3e-3)
    np.testing.assert_allclose(forces[0], forces[1], rtol=0, atol=1e-10)
