"""Steady contact forces on every surface, at every contact point and in every pose, not only the report's."""

from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym
from prp_gym.baselines import BASELINES, Baseline
from prp_gym.envs.base.contact_starts import ContactPoint
from prp_gym.robot import PRPArm
from tests.support.covering import by_turns

Array = NDArray[np.float64]

SLIDE_POSITIONS = (-0.2, -0.15, -0.1)  # of the slide at the first touch [m]
POSES = ((0.0, 0.0), (-1.9, 1.1), (2.4, -0.7))  # q_1 and q_3 [rad]
DEPTH = 0.05
SPRINGS = {
    "compliance": ("PRP-Compliance-v0", 50.0, 5.0),
    # on the stiffest surface the target mass rings with a time constant of 0.7 s
    "impedance": ("PRP-Impedance-v0", 50.0, 7.0),
    "admittance": ("PRP-Admittance-v0", 20.0, 4.0),
}
"""Environment, stiffness [N/m] and duration [s], which leaves an eighth of the tolerances of transients."""
FORCE_CONTROLLERS = {
    "force_inner_position": "PRP-Force-v0",
    "parallel_force_position": "PRP-ForcePosition-v0",
}


class Press(NamedTuple):
    """One case: the surface's stiffness [N/m], contact point and pose of the arm, and target impedance."""

    stiffness: float
    contact: ContactPoint
    target_impedance: dict[str, Array]


def grid(stiffnesses: Array) -> list[Press]:
    """Every stiffness at every position of the slide and in every pose, and each of these with each other."""
    return [
        Press(K, ContactPoint(PRPArm(), np.array([q_1, slide, q_3]), np.array(-1.0)), {})
        for K, slide, (q_1, q_3) in by_turns(stiffnesses.tolist(), SLIDE_POSITIONS, POSES)
    ]


def press(
    environment_id: str, controller: str, cases: list[Press], duration: float, **options: Any
) -> tuple[Array, Array, Baseline[Any]]:
    """Final forces along and across the inward normals [N], all cases side by side; and the controller."""
    env: Any = gymnasium.make(environment_id, scenario="report", duration=duration, **options).unwrapped
    # the tip starts on the surface, so that taring would count a part of the force as the bias of the sensor
    untared = {"taring": "none"} if "taring" in BASELINES[controller].settings_class.choices else {}
    policy, loop = prp_gym.make_baseline(controller, env, **untared), env.make_loop(len(cases))
    rngs = [np.random.default_rng(0) for _ in cases]
    loop.reset(np.arange(len(cases)), rngs, {})
    for row, (stiffness, contact, target_impedance) in enumerate(cases):
        before, behind = contact.near(np.array([[0.0, -0.02, 0.0], [0.0, DEPTH, 0.0]]))
        given = {
            "joint_position": before,
            "goal": behind,
            "surface_normal": contact.normal,
            "surface_offset": np.array(contact.offset),
            "surface_stiffness": np.array(stiffness),
            **target_impedance,
        }
        known = {name: value[None] for name, value in given.items() if name in env.task.reset_options}
        observation = loop.reset(np.array([row]), rngs[row : row + 1], known)
    state, starts = None, np.ones(len(cases), dtype=np.bool_)
    for _ in range(env.config.horizon):
        action, state = policy.predict(observation, state, episode_start=starts)
        observation = loop.step(action.astype(np.float64)).observation
        starts = np.zeros(len(cases), dtype=np.bool_)
    force, inward = loop.physics.contact_force, -np.stack([case.contact.normal for case in cases])
    along = np.vecdot(force, inward)
    return along, np.linalg.norm(force - along[:, None] * inward, axis=-1), policy


@pytest.mark.parametrize("controller", SPRINGS)
def test_springs_hold_on_every_surface_at_every_contact_point_in_every_pose(controller: str) -> None:
    environment_id, target, duration = SPRINGS[controller]
    options = {"reference": "hold"} if controller == "admittance" else {}
    cases = grid(np.logspace(0, 4, 5))
    along, across, policy = press(environment_id, controller, cases, duration, **options)
    own = float(policy.settings.stiffness[0])
    assert own == pytest.approx(target, rel=0.02)  # a search may have chosen a stiffness beside the target's
    # two springs in series over a depth
    expected = [case.stiffness * own / (case.stiffness + own) * DEPTH for case in cases]
    # the design's 0.2 % and, for admittance, 0.5 %
    np.testing.assert_allclose(along, expected, rtol=5e-3 if controller == "admittance" else 2e-3)
    np.testing.assert_allclose(across, 0.0, atol=1e-9)  # without friction nothing acts along the surface


@pytest.mark.parametrize("controller", FORCE_CONTROLLERS)
def test_desired_force_is_reached_on_every_surface_at_every_contact_point_in_every_pose(
    controller: str,
) -> None:
    cases = [
        case._replace(target_impedance={"desired_force": np.array(min(5.0, 0.04 * case.stiffness))})
        for case in grid(np.logspace(np.log10(50.0), np.log10(5000.0), 5))  # what the tuned gains are for
    ]
    along, across, _ = press(FORCE_CONTROLLERS[controller], controller, cases, 2.5)
    np.testing.assert_allclose(
        along, [case.target_impedance["desired_force"] for case in cases], rtol=2e-3
    )  # the design
    np.testing.assert_allclose(across, 0.0, atol=1e-9)
