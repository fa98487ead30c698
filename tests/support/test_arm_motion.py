"""The arms of the tests in closed loop move as the package's model, which is checked against Pinocchio."""

from dataclasses import replace

import numpy as np
import pytest

from prp_gym.robot import NOMINAL, PRPArm
from tests.support.arm_motion import STEP, Arms, advance
from tests.support.contact_plant import Wall
from tests.support.pinocchio_model import random_arm, random_states

COUNT = 40
ROUGH = replace(NOMINAL, viscous_friction=(0.5, 2.0, 0.1), coulomb_friction=(0.3, 1.5, 0.05))


@pytest.mark.parametrize(
    "arm", [PRPArm(), PRPArm(random_arm(3)[0]), PRPArm(ROUGH)], ids=["nominal", "another", "rough"]
)
@pytest.mark.parametrize("walled", [False, True])
def test_step_is_that_of_the_model_with_the_force_of_the_wall(arm: PRPArm, walled: bool) -> None:
    q, v, torque, normal = random_states(5, COUNT)
    draw = np.random.default_rng(6)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    tip = arm.forward_kinematics(q)[:, :3]
    depth = draw.uniform(-0.05, 0.05, COUNT)  # half of them free
    wall = Wall(
        draw.uniform(50.0, 5000.0, COUNT),
        normal,
        np.vecdot(normal, tip) + depth,
        draw.uniform(0.0, 20.0, COUNT),
    )
    position, velocity = q, v
    for _ in range(3):
        rate = np.einsum("nij,nj->ni", arm.analytical_jacobian(position)[:, :3], velocity)
        force = wall.force(arm.forward_kinematics(position)[:, :3], rate) if walled else np.zeros((COUNT, 3))
        velocity = velocity + STEP * arm.forward_dynamics(position, velocity, torque, force)
        position = position + STEP * velocity
    arms = Arms.of([arm.parameters])
    found = advance(arms, q, v, torque, wall if walled else None, 3)
    # accelerations up to 1e5, whose operations have another order
    np.testing.assert_allclose(found[0], position, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found[1], velocity, rtol=1e-9, atol=1e-9)
    if walled:
        free = advance(arms, q, v, torque, None, 3)[1]
        assert 0.2 * COUNT < np.count_nonzero((found[1] != free).any(axis=-1)) < 0.8 * COUNT


def test_rows_have_their_own_masses_and_friction() -> None:
    q, v, torque, _ = random_states(7, 3)
    parameters = (NOMINAL, NOMINAL.scaled((0.7, 1.3, 1.3)), ROUGH)
    together = advance(Arms.of(parameters), q, v, torque, None, 2)
    for row, own in enumerate(parameters):
        rows = slice(row, row + 1)
        alone = advance(Arms.of([own]), q[rows], v[rows], torque[rows], None, 2)
        np.testing.assert_array_equal([part[0] for part in alone], [part[row] for part in together])
