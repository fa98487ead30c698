"""Conformance of every environment to Gymnasium and Stable-Baselines3, and its reproducibility."""

import copy
import pickle
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as check_env_for_sb3

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.robot import NOMINAL
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS
from tests.support.covering import by_turns

Outcome = tuple[Array, float, bool, bool, dict[str, Any]]
RATES = (50, 100, 500, 1000)
SOME = 1.1  # [s]: 550 steps, past the blocks of noise (256) and of reference (512)
SAVED_AFTER = (20, 480)  # steps: the tip is still in the surface; the second ends just before such blocks do

COPIES: dict[str, Callable[[PRPEnv], PRPEnv]] = {
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "deepcopy": copy.deepcopy,
}


def every(choices: Sequence[Any]) -> list[tuple[str, str, Any]]:
    """Every environment in every scenario, with one of the choices."""
    return by_turns(prp_gym.list_envs(), SCENARIOS, choices)


@pytest.fixture(params=prp_gym.list_envs())
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=SCENARIOS)
def scenario(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def made(environment_id: str, scenario: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, scenario=scenario, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def random_actions(env: PRPEnv, count: int, seed: int = 1) -> Array:
    """Random torques within the nominal limits, whatever the scenario's are."""
    share = full_actions(env)
    values: Array = share * np.random.default_rng(seed).uniform(-1.0, 1.0, size=(count, len(share)))
    return values


def gentle_actions(env: PRPEnv, count: int) -> Array:
    """Random torques of a tenth of the nominal limits, under which no arm diverges within a second."""
    values: Array = 0.1 * random_actions(env, count, seed=2)
    return values


def full_actions(env: PRPEnv) -> Array:
    """An action of the nominal torque limits (joints)."""
    return np.array(env.arm.parameters.torque_limit) / env.torque_limit


def still(env: PRPEnv) -> Array:
    """A zero action (joints)."""
    return np.zeros(len(env.torque_limit))


def start_of(env: PRPEnv) -> dict[str, Any]:
    """Reset options with which the tip of a contact task begins a decimetre inside a soft surface."""
    if "surface_offset" not in env.task.reset_options:
        return {}
    return {
        "joint_position": (0.0, -0.2, 0.0),
        "surface_normal": (0.0, -1.0, 0.0),
        "surface_offset": 0.44,
        "surface_stiffness": 50.0,
        "surface_damping": 5.0,
    }


def assert_touching(env: PRPEnv, outcomes: list[Outcome], before: int) -> None:
    """A contact task's arm is in contact soon after its start, or it would show nothing about contacts."""
    near = before == min(SAVED_AFTER) and start_of(env)
    assert not near or any(outcome[4]["contact_force"] > 0.0 for outcome in outcomes)


def run(env: PRPEnv, actions: Array) -> list[Outcome]:
    """Step up to a divergence: without joint stops the slide may be flung out within seconds."""
    outcomes: list[Outcome] = []
    for action in actions:
        outcomes.append(env.step(action))
        if outcomes[-1][2]:
            break
    return outcomes


def assert_same(outcomes: list[Outcome], expected: list[Outcome]) -> None:
    """Assert equality to the last bit."""
    for outcome, other in zip(outcomes, expected, strict=True):
        np.testing.assert_array_equal(outcome[0], other[0])
        assert outcome[1:] == other[1:]


def test_gymnasiums_checker_is_satisfied(environment_id: str, scenario: str) -> None:
    check_env(made(environment_id, scenario), skip_render_check=True)


def test_gymnasiums_checker_is_satisfied_with_frames(open_contexts: None, environment_id: str) -> None:
    env = made(environment_id, "realistic", render_mode="rgb_array", width=64, height=48)
    check_env(env)
    frame = env.render()
    assert frame is not None
    assert frame.shape == (48, 64, 3)
    env.close()


def test_stable_baselines3s_checker_is_satisfied(environment_id: str, scenario: str) -> None:
    check_env_for_sb3(made(environment_id, scenario), warn=True, skip_render_check=True)


def test_stable_baselines3s_checker_is_satisfied_with_frames(
    open_contexts: None, environment_id: str
) -> None:
    env = made(environment_id, "randomized", render_mode="rgb_array", width=64, height=48)
    check_env_for_sb3(env, warn=True, skip_render_check=False)
    env.close()


def test_environment_that_has_drawn_can_be_copied_and_draws_the_same(
    open_contexts: None, environment_id: str
) -> None:
    env = made(environment_id, "randomized", render_mode="rgb_array", width=64, height=48)
    env.reset(seed=0)
    frame = env.render()
    for how in COPIES.values():
        clone = how(env)
        np.testing.assert_array_equal(clone.render(), frame)
        clone.close()
    env.close()


def test_depth_frames_are_distances(open_contexts: None, environment_id: str) -> None:
    env = made(environment_id, "report", render_mode="depth_array", width=64, height=48, camera="top")
    env.reset(seed=0)
    frame = env.render()
    assert frame is not None
    assert frame.shape == (48, 64)
    assert frame.dtype == np.float32
    # the top camera is 2 m above the floor; 24 bits between 0.01 and 20 m leave a millimetre there
    assert float(frame.max()) == pytest.approx(2.15, abs=1e-3)
    env.close()


def test_reset_discards_the_whole_state(environment_id: str, scenario: str) -> None:
    """The hidden warm start of the solver included: the new episode begins against the joint stops."""
    used, fresh = made(environment_id, scenario), made(environment_id, scenario)
    joints = len(used.torque_limit)
    edge = {"joint_position": NOMINAL.joint_upper[:joints], "joint_velocity": (1.0, 0.5, 1.0)[:joints]}
    for options in ({}, edge, start_of(used)):
        used.reset(seed=7, options=start_of(used))
        run(used, random_actions(used, 20, seed=2))
        run(used, full_actions(used) * np.ones((180, 1)))  # to the stops, where there are any
        again, _ = used.reset(seed=1234, options=options)
        first, _ = fresh.reset(seed=1234, options=options)
        np.testing.assert_array_equal(again, first)
        actions = random_actions(fresh, 50)
        assert_same(run(used, actions), run(fresh, actions))


def test_same_seed_gives_the_same_episode_to_the_last_bit(environment_id: str, scenario: str) -> None:
    episodes = []
    for _ in range(2):
        env = made(environment_id, scenario, duration=SOME)
        first, info = env.reset(seed=42)
        steps = run(env, random_actions(env, env.config.horizon))
        assert steps[-1][2] or steps[-1][3]
        episodes.append([(first, 0.0, False, False, info), *steps])
    assert_same(*episodes)


def test_seeds_make_a_difference_where_anything_is_random(environment_id: str, scenario: str) -> None:
    env = made(environment_id, scenario)
    one, other = (np.concatenate([env.reset(seed=s)[0], env.step(still(env))[0]]) for s in (0, 1))
    assert np.array_equal(one, other) == env.task.scenario.deterministic


def test_next_reset_without_a_seed_draws_anew_but_reproducibly(environment_id: str, scenario: str) -> None:
    env, twin = made(environment_id, scenario), made(environment_id, scenario)
    starts = [env.reset(seed=0)[0], env.reset()[0], env.reset()[0]]
    for start, expected in zip([twin.reset(seed=0), twin.reset(), twin.reset()], starts, strict=True):
        np.testing.assert_array_equal(start[0], expected)
    repeats = np.array_equal(starts[0], starts[1]) or np.array_equal(starts[1], starts[2])
    assert repeats == env.task.scenario.deterministic


@pytest.mark.parametrize(("environment_id", "scenario", "rate"), every(RATES))
def test_observation_stays_in_its_space_whatever_the_actions(
    environment_id: str, scenario: str, rate: int
) -> None:
    env = made(environment_id, scenario, control_frequency=rate, duration=1.0)
    env.action_space.seed(3)
    observation, _ = env.reset(seed=3)
    for _ in range(rate + rate // 5):  # and into the next episode
        assert env.observation_space.contains(observation)
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        assert 0.0 <= reward <= 1.0
        assert np.isfinite(list(info.values())).all()
        assert not (terminated and truncated)
        if terminated or truncated:
            observation, _ = env.reset()


def test_reward_is_the_sum_of_its_terms_in_info(environment_id: str, scenario: str) -> None:
    env = made(environment_id, scenario)
    env.reset(seed=5)
    for _, reward, _, _, info in run(env, random_actions(env, 50)):
        terms = {name: value for name, value in info.items() if name.startswith("reward_")}
        assert set(terms) == {f"reward_{term.name}" for term in env.task.numbers.reward}
        # few terms, added in another order perhaps
        assert sum(terms.values()) == pytest.approx(reward, rel=1e-15)


def test_info_is_what_was_declared(environment_id: str, scenario: str) -> None:
    env = made(environment_id, scenario, control_frequency=50)
    _, start = env.reset(seed=0)
    infos = [start, *(outcome[4] for outcome in run(env, np.tile(still(env), (3, 1))))]
    for count, info in enumerate(infos):
        assert list(info) == [field.name for field in env.info_fields]
        assert info["time"] == pytest.approx(count / 50, rel=1e-15)  # one rounding
        assert {type(value) for value in info.values()} == {np.float64}  # as libraries that store infos need
    assert all(field.unit and field.description for field in env.info_fields)


def test_info_of_reset_is_that_of_an_arm_which_has_not_moved(environment_id: str, scenario: str) -> None:
    env = made(environment_id, scenario)
    _, info = env.reset(seed=0, options=start_of(env))
    force = info.pop("contact_force", 0.0)
    assert set(info.values()) == {0.0}
    # one root; zero for tasks without contact
    assert force == pytest.approx(np.linalg.norm(env.physics.contact_force[0]), rel=1e-15)
    assert (force > 0.0) == bool(start_of(env))


@pytest.mark.parametrize(("environment_id", "scenario", "rate"), every(RATES))
def test_episode_is_truncated_exactly_at_its_duration(environment_id: str, scenario: str, rate: int) -> None:
    env = made(environment_id, scenario, control_frequency=rate, duration=0.3)
    for episode in range(2):
        env.reset(seed=episode)
        steps = round(0.3 * rate)
        outcomes = run(env, random_actions(env, steps))
        assert [outcome[3] for outcome in outcomes] == [False] * (steps - 1) + [True]
        assert not any(outcome[2] for outcome in outcomes)
        assert outcomes[-1][4]["time"] == pytest.approx(0.3, rel=1e-15)  # one rounding


def test_return_lies_between_zero_and_the_number_of_steps(environment_id: str, scenario: str) -> None:
    env = made(environment_id, scenario, duration=SOME)
    env.reset(seed=11)
    outcomes = run(env, random_actions(env, env.config.horizon))
    assert outcomes[-1][2] or outcomes[-1][3]
    assert 0.0 < sum(outcome[1] for outcome in outcomes) <= env.config.horizon


@pytest.mark.parametrize("before", SAVED_AFTER)
@pytest.mark.parametrize(("environment_id", "scenario", "how"), every(list(COPIES)))
def test_copy_made_in_an_episode_goes_on_as_the_original(
    environment_id: str, scenario: str, how: str, before: int
) -> None:
    env = made(environment_id, scenario)
    env.reset(seed=21, options=start_of(env))
    run(env, gentle_actions(env, before))
    clone = COPIES[how](env)
    actions = random_actions(env, 50)
    expected = run(env, actions)
    assert_touching(env, expected, before)
    assert_same(run(clone, actions), expected)
    np.testing.assert_array_equal(clone.reset()[0], env.reset()[0])
    assert_same(run(clone, actions[:20]), run(env, actions[:20]))


@pytest.mark.parametrize("before", SAVED_AFTER)
def test_saved_state_brings_back_the_same_future_here_and_elsewhere(
    environment_id: str, scenario: str, before: int
) -> None:
    env, other = made(environment_id, scenario), made(environment_id, scenario)
    env.reset(seed=31, options=start_of(env))
    observation = run(env, gentle_actions(env, before))[-1][0]
    state = env.get_state()
    kept = pickle.loads(pickle.dumps(state))
    actions = random_actions(env, 50)
    expected = run(env, actions)
    assert_touching(env, expected, before)
    following, _ = env.reset()
    other.reset(seed=32)
    run(other, actions[:7])
    for target, saved in ((env, state), (other, kept), (other, state), (env, kept)):
        # `state` unchanged by what env did since, or it would no longer lead to the same future
        np.testing.assert_array_equal(target.set_state(saved), observation)
        assert_same(run(target, actions), expected)
        np.testing.assert_array_equal(target.reset()[0], following)


def test_state_may_be_set_before_the_first_reset(environment_id: str, scenario: str) -> None:
    env, fresh = made(environment_id, scenario), made(environment_id, scenario)
    observation, _ = env.reset(seed=1)
    np.testing.assert_array_equal(fresh.set_state(env.get_state()), observation)
    actions = random_actions(env, 20)
    assert_same(run(fresh, actions), run(env, actions))
