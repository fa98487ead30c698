"""Compliance, impedance, admittance: the target model moves as its equation says, under the true force."""

import copy
import itertools
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs import EpisodeLoop, PRPEnv
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array

COMPLIANCE, IMPEDANCE, ADMITTANCE = "PRP-Compliance-v0", "PRP-Impedance-v0", "PRP-Admittance-v0"
IDS = (COMPLIANCE, IMPEDANCE, ADMITTANCE)
DYNAMIC = (IMPEDANCE, ADMITTANCE)
ARM = PRPArm()
PRESSED = {
    "joint_position": (0.1, -0.2, 0.3),
    "surface_normal": (-0.3, -1.0, 0.2),
    "surface_offset": 0.36,
    "surface_stiffness": 400.0,
    "surface_damping": 5.0,
}
KNOTS = 10  # of the fine integration in a control period
NONE: dict[str, Array] = {}


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def press(env: PRPEnv) -> Array:
    """An action that pulls the tip against the surface of `PRESSED` and holds the other joints."""
    q, velocity = env.physics.joint_position[0], env.physics.joint_velocity[0]
    wanted = np.array([200.0, 50.0, 20.0]) * (np.array([0.1, -0.25, 0.3]) - q)
    torque: Array = ARM.gravity_vector(q) + wanted - np.array([10.0, 5.0, 0.5]) * velocity
    return torque / env.torque_limit


def pressed_episode(env: PRPEnv, steps: int) -> dict[str, Array]:
    """Ground truth (steps + 1, size) by name of an episode that begins and stays in contact for a while."""
    env.reset(seed=3, options=PRESSED)
    rows = [env.ground_truth]
    for _ in range(steps):
        env.step(press(env))
        rows.append(env.ground_truth)
    parts: dict[str, Array] = env.task.ground_truth_layout.split(np.array(rows))
    return parts


def integrated(force: Array, period: float, inertia: Array, damping: Array, stiffness: Array) -> Array:
    """z (T + 1, 6) of M z̈ + K_D ż + K_P z = h, by the classical Runge-Kutta method.

    Args:
        force: h (T + 1, 6), linear between its values.
    """

    def rate(state: Array, h: Array) -> Array:
        z, velocity = state
        return np.array([velocity, (h - damping * velocity - stiffness * z) / inertia])

    state, rows = np.zeros((2, 6)), [np.zeros(6)]
    step = period / KNOTS
    for before, after in itertools.pairwise(force):
        for knot in range(KNOTS):
            begin, middle, end = (before + (after - before) * (knot + s) / KNOTS for s in (0.0, 0.5, 1.0))
            k_1 = rate(state, begin)
            k_2 = rate(state + 0.5 * step * k_1, middle)
            k_3 = rate(state + 0.5 * step * k_2, middle)
            k_4 = rate(state + step * k_3, end)
            state = state + step / 6.0 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4)
        rows.append(state[0])
    return np.array(rows)


def wrench(parts: dict[str, Array]) -> Array:
    force = parts["contact_force"]
    return np.concatenate([force, np.zeros_like(force)], axis=-1)


@pytest.mark.parametrize(
    ("environment_id", "keywords", "numbers"),
    [
        (IMPEDANCE, {}, (0.5, 10.0, 50.0)),
        (ADMITTANCE, {}, (1.0, 10.0, 20.0)),
        (
            IMPEDANCE,
            {"target_inertia": 2.0, "target_damping": (1.0, 2.0, 3.0, 1, 1, 1), "target_stiffness": 300.0},
            (2.0, np.array([1.0, 2.0, 3.0]), 300.0),
        ),
        (ADMITTANCE, {"control_frequency": 50, "target_stiffness": 0.0}, (1.0, 10.0, 0.0)),
    ],
    ids=["impedance", "admittance", "impedance with other numbers", "admittance without a spring at 50 Hz"],
)
@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_model_moves_as_its_equation_says_under_the_true_force(
    environment_id: str, keywords: dict[str, Any], numbers: tuple[Any, Any, Any], scenario: str
) -> None:
    env = environment(environment_id, scenario=scenario, **keywords)
    parts = pressed_episode(env, round(0.8 * env.control_frequency))
    force = parts["contact_force"]
    assert np.abs(force[0]).max() > 10.0  # from the first instant
    assert (np.abs(force).max(axis=0) > 1.0).all()  # on every axis
    inertia, damping, stiffness = (np.ones(6) for _ in range(3))
    for own, given in zip((inertia, damping, stiffness), numbers, strict=True):
        own[:3] = given  # nothing turns the model
    expected = integrated(wrench(parts), 1.0 / env.control_frequency, inertia, damping, stiffness)
    displacement = parts["desired_pose"] - parts["model_pose"]
    assert np.abs(displacement).max() > 0.02
    # Runge-Kutta's own error, (0.002 s)^4 of a rate of 12/s over a second at most, times metres: 1e-8
    np.testing.assert_allclose(displacement, expected, rtol=0, atol=1e-7)


def test_model_without_contact_is_the_reference() -> None:
    for environment_id in IDS:
        env = environment(environment_id, surface_normal=(0.0, 0.0, 1.0), surface_offset=-2.0)
        env.reset(seed=0)
        for _ in range(50):
            env.step(np.zeros(3))
            parts = env.task.ground_truth_layout.split(env.ground_truth)
            np.testing.assert_array_equal(parts["model_pose"], parts["desired_pose"])


@pytest.mark.parametrize(
    ("keywords", "stiffness"),
    [({}, 50.0), ({"target_stiffness": 200}, 200.0), ({"target_stiffness": (9, 8, 7, 1, 1, 1)}, (9, 8, 7))],
)
def test_static_model_is_displaced_at_once_by_force_over_stiffness(
    keywords: dict[str, Any], stiffness: Any
) -> None:
    parts = pressed_episode(environment(COMPLIANCE, **keywords), 100)
    displacement = parts["desired_pose"] - parts["model_pose"]
    expected = parts["contact_force"] / np.array(stiffness, dtype=float)
    assert np.abs(expected).max() > 0.1
    # a difference of lengths below 20 m
    np.testing.assert_allclose(displacement[:, :3], expected, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(displacement[:, 3:], 0.0)


def test_static_model_stays_where_it_has_no_stiffness() -> None:
    parts = pressed_episode(environment(COMPLIANCE, target_stiffness=(0.0, 50.0, 0.0, 0.0, 0.0, 0.0)), 20)
    displacement = parts["desired_pose"] - parts["model_pose"]
    np.testing.assert_array_equal(displacement[:, [0, 2, 3, 4, 5]], 0.0)
    assert (np.abs(displacement[:, 1]) > 0.0).all()


@pytest.mark.parametrize("environment_id", IDS)
def test_errors_are_those_from_the_model_of_tip_alpha_beta_and_the_torque(environment_id: str) -> None:
    task = environment(environment_id).task
    ground_truth = np.zeros((2, task.ground_truth_layout.size))
    parts = task.ground_truth_layout.split(ground_truth)
    parts["end_effector_pose"][:] = [[0.4, -0.3, 0.1, 0.5, 1.0, 9.0], [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]]
    parts["model_pose"][:] = [[0.5, -0.5, 0.4, 0.25, 3.0, 0.0], [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]]
    parts["desired_pose"][:] = 77.0  # what the model makes of it counts
    torque = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    errors = task.errors(ground_truth, torque)
    expected = [[0.5 - 0.4, -0.5 + 0.3, 0.4 - 0.1], [-0.25, 2.0, 0.0], [1.0, 2.0, 3.0]]
    np.testing.assert_array_equal(errors[0], expected)
    np.testing.assert_array_equal(errors[1], [[0.0] * 3, [0.0] * 3, [4.0, 5.0, 6.0]])
    np.testing.assert_array_equal(task.errors(ground_truth[0], torque[0]), errors[0])


SCALES = {  # [m] and [rad]
    "PRP-Compliance-v0": (0.01, 0.1),
    "PRP-Impedance-v0": (0.02, 0.1),
    "PRP-Admittance-v0": (0.03, 0.15),
}


@pytest.mark.parametrize("environment_id", IDS)
def test_reward_is_that_of_the_distance_from_the_model(environment_id: str) -> None:
    length, angle = SCALES[environment_id]
    env = environment(environment_id, scenario="realistic")
    env.reset(seed=3, options=PRESSED)
    for _ in range(50):
        _, reward, *_ = env.step(press(env))
        parts = env.task.ground_truth_layout.split(env.ground_truth)
        off = parts["model_pose"] - parts["end_effector_pose"]
        effort = env.commanded_torque / [50.0, 100.0, 10.0]
        worth = (
            0.7 / (1.0 + np.linalg.norm(off[:3] / length))
            + 0.25 / (1.0 + np.linalg.norm(off[3:5] / angle))
            + 0.05 / (1.0 + np.linalg.norm(effort))
        )
        assert reward == pytest.approx(worth, rel=1e-12)  # some roundings


def test_model_is_recorded_but_not_observed() -> None:
    for environment_id in IDS:
        task = environment(environment_id).task
        assert task.ground_truth_layout.names == (*task.layout.names, "model_pose")


def generators(seeds: Any) -> list[np.random.Generator]:
    return [np.random.default_rng(seed) for seed in seeds]


def pressed_loop(environment_id: str, num_envs: int = 3) -> EpisodeLoop:
    """Environments that begin in contact, after 20 steps under their weight."""
    env = environment(environment_id)
    loop = EpisodeLoop(env.task, env.config, num_envs)
    options = {name: np.array([value] * num_envs) for name, value in PRESSED.items()}
    loop.reset(np.arange(num_envs), generators(range(num_envs)), options)
    for _ in range(20):
        loop.step(np.zeros((num_envs, 3)))
    return loop


@pytest.mark.parametrize("environment_id", DYNAMIC)
def test_restarted_models_are_at_rest_on_their_reference_and_the_others_go_on(environment_id: str) -> None:
    loop, twin = pressed_loop(environment_id), pressed_loop(environment_id)
    parts = loop.task.ground_truth_layout.split(loop.ground_truth)
    assert (np.abs(parts["model_pose"] - parts["desired_pose"]).max(axis=1) > 1e-3).all()
    restarted, others = np.array([0, 2]), np.array([1])
    before = loop.ground_truth.copy()
    loop.reset(restarted, generators([7, 8]), NONE)
    np.testing.assert_array_equal(loop.ground_truth[others], before[others])
    parts = loop.task.ground_truth_layout.split(loop.ground_truth)
    np.testing.assert_array_equal(parts["model_pose"][restarted], parts["desired_pose"][restarted])
    fresh_env = environment(environment_id)
    fresh = EpisodeLoop(fresh_env.task, fresh_env.config, 2)
    fresh.reset(np.arange(2), generators([7, 8]), NONE)
    for action in np.random.default_rng(0).uniform(-0.1, 0.1, size=(150, 3, 3)):
        loop.step(action)
        twin.step(action)
        fresh.step(action[restarted])
        np.testing.assert_array_equal(loop.ground_truth[others], twin.ground_truth[others])
        np.testing.assert_array_equal(loop.ground_truth[restarted], fresh.ground_truth)


@pytest.mark.parametrize("environment_id", DYNAMIC)
def test_saved_models_go_on_as_the_originals(environment_id: str) -> None:
    loop, other = pressed_loop(environment_id), pressed_loop(environment_id)
    state = loop.get_state()
    kept = copy.deepcopy(state)
    now, future = loop.ground_truth.copy(), []
    for _ in range(40):
        loop.step(np.zeros((3, 3)))
        other.step(np.ones((3, 3)))
        future.append(loop.ground_truth.copy())
    for saved in (state, kept):
        other.set_state(saved)
        np.testing.assert_array_equal(other.ground_truth, now)
        for expected in future:
            other.step(np.zeros((3, 3)))
            np.testing.assert_array_equal(other.ground_truth, expected)
