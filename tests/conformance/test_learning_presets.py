"""The learning presets of all tasks: the task itself, observed as errors of order 1 at 50 Hz."""

import copy
import pickle
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.spaces import Box
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env as check_env_for_sb3

import prp_gym
from prp_gym.agents.policy.agent_file import load_agent, save_agent
from prp_gym.agents.training.export import AgentFacts, export_agent, identity_normalizer
from prp_gym.comparison.agents import find_agents
from prp_gym.envs import PRPEnv, PRPVectorEnv
from prp_gym.envs.base.error_observation import ErrorObservation, read_parts
from prp_gym.errors import ErrorObservationError, InvalidValueError, PRPError, UnknownNameError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import MEASURED_FIELDS, ObservationLayout
from prp_gym.tasks.parts import TaskParts
from prp_gym.tasks.presets import find_preset, learning_id
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TASKS, TaskEntry
from tests.support.synthetic_agents import RUN

Outcome = tuple[Array, float, bool, bool, dict[str, Any]]
SHORT = {"duration": 0.4}  # [s]: 20 steps
POSE = "PRP-PoseTracking-v0"
CONTACT = "PRP-ForcePosition-v0"


@pytest.fixture(params=prp_gym.list_envs())
def task_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def preset(task_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(learning_id(task_id), **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def task(task_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(task_id, control_frequency=50, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def actions_of(env: PRPEnv, count: int) -> Array:
    size = (count, *(env.action_space.shape or ()))
    return np.random.default_rng(3).uniform(-0.3, 0.3, size)


def errors_of(env: PRPEnv, observation: Array) -> dict[str, Array]:
    return env.observation_layout.split(observation)


def test_id_is_a_preset_of_its_task_and_not_listed(task_id: str) -> None:
    env = preset(task_id)
    assert env.spec is not None
    assert env.spec.id == learning_id(task_id)
    assert env.spec.max_episode_steps == 250
    assert (env.control_frequency, env.action_mode) == (50.0, "torque")
    assert (env.task.environment_id, env.config.scenario) == (task_id, "randomized")
    assert learning_id(task_id) not in prp_gym.list_envs()
    assert find_preset(learning_id(task_id)).task is TASKS[task_id]


def test_names_of_presets_keep_the_version() -> None:
    assert learning_id("PRP-Force-v0") == "PRP-Force-RL-v0"
    assert learning_id("Own") == "Own-RL"
    with pytest.raises(UnknownNameError):
        find_preset("PRP-Forces-RL-v0")


@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_episodes_are_those_of_the_task_to_the_last_bit(task_id: str, scenario: str) -> None:
    """Physics, reward, info and the sensor's errors; the observation is a function of the fields."""
    env, twin = preset(task_id, scenario=scenario, **SHORT), task(task_id, scenario=scenario, **SHORT)
    read = ErrorObservation(twin.task.layout, twin.task.model)
    starts = env.reset(seed=5), twin.reset(seed=5)
    np.testing.assert_array_equal(starts[0][0], read(starts[1][0][None])[0])
    for action in actions_of(env, 20):
        (observation, *found), (fields, *expected) = env.step(action), twin.step(action)
        assert found == expected
        np.testing.assert_array_equal(observation, read(fields[None])[0])
        np.testing.assert_array_equal(env.ground_truth, twin.ground_truth)


def test_action_mode_reads_the_fields_of_the_task() -> None:
    mode = {"action_mode": "admittance", **SHORT}
    env, twin = preset("PRP-Force-v0", **mode), task("PRP-Force-v0", **mode)
    env.reset(seed=1)
    twin.reset(seed=1)
    for action in actions_of(env, 20):
        assert env.step(action)[1:] == twin.step(action)[1:]
        np.testing.assert_array_equal(env.ground_truth, twin.ground_truth)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_vector_environment_gives_the_bits_of_single_ones(task_id: str, mode: str) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", **SHORT}
    made = gymnasium.make_vec(
        learning_id(task_id), num_envs=3, autoreset_mode=AutoresetMode(mode), **keywords
    )
    together = made.unwrapped
    assert isinstance(together, PRPVectorEnv)
    singles = [preset(task_id, **keywords) for _ in range(3)]
    observations, _ = together.reset(seed=[4, 5, 6])
    first = [env.reset(seed=seed)[0] for env, seed in zip(singles, (4, 5, 6), strict=True)]
    np.testing.assert_array_equal(observations, first)
    for action in actions_of(singles[0], 20):
        outcomes = [env.step(action * scale) for env, scale in zip(singles, (1.0, -1.0, 0.5), strict=True)]
        observations, rewards, _, truncated, info = together.step(np.outer((1.0, -1.0, 0.5), action))
        last = observations if "final_obs" not in info else np.stack(list(info["final_obs"]))
        np.testing.assert_array_equal(last, [outcome[0] for outcome in outcomes])
        np.testing.assert_array_equal(rewards, [outcome[1] for outcome in outcomes])
    assert truncated.all()
    assert ("final_obs" in info) == (mode == "SameStep")


def test_checkers_are_satisfied(task_id: str) -> None:
    check_env(preset(task_id), skip_render_check=True)
    check_env_for_sb3(preset(task_id), warn=True, skip_render_check=True)


def test_observation_is_of_order_one_and_within_its_bounds(task_id: str) -> None:
    env = preset(task_id)
    env.action_space.seed(0)
    rows = [env.reset(seed=0)[0]]
    for _ in range(env.config.horizon):
        rows.append(env.step(env.action_space.sample())[0])
        assert env.observation_space.contains(rows[-1])
    space = env.observation_space
    assert isinstance(space, Box)
    assert space.high.max() == 10.0
    np.testing.assert_array_equal(space.low, -space.high)
    assert 0.1 < np.sqrt(np.mean(np.square(rows))) < 5.0


COPIES: dict[str, Callable[[PRPEnv], PRPEnv]] = {
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize("how", COPIES)
def test_copies_and_saved_states_go_on_alike(task_id: str, how: str) -> None:
    env, other = preset(task_id, scenario="realistic"), preset(task_id, scenario="realistic")
    env.reset(seed=2)
    actions = actions_of(env, 12)
    observation = [env.step(action) for action in actions[:6]][-1][0]
    clone, state = COPIES[how](env), env.get_state()
    expected = [env.step(action) for action in actions[6:]]
    np.testing.assert_array_equal(other.set_state(state), observation)
    for following in (clone, other):
        for action, outcome in zip(actions[6:], expected, strict=True):
            found = following.step(action)
            np.testing.assert_array_equal(found[0], outcome[0])
            assert found[1:] == outcome[1:]


def test_state_of_the_task_itself_is_refused() -> None:
    env, twin = preset(POSE), task(POSE)
    twin.reset(seed=0)
    with pytest.raises(InvalidValueError, match="keywords"):
        env.set_state(twin.get_state())


def test_errors_of_a_pose_reference_are_those_of_its_joint_trajectory() -> None:
    """The reference was made from a motion of the joints, which the observation does not contain."""
    env = preset(POSE)
    observation, _ = env.reset(seed=9)
    for action in actions_of(env, 20):
        observation = env.step(action)[0]
    found = errors_of(env, observation)
    time = np.array([[20 / 50.0]])
    desired = env.task.parts.reference.trajectory.sample(time)[0, 0]
    actual = env.task.ground_truth_layout.split(env.ground_truth)
    q, velocity = actual["joint_position"], actual["joint_velocity"]
    scale = {part.name: np.array(part.scale) for part in read_parts()["arm"]}
    # a pose and its two derivatives, inverted: some dozens of roundings of numbers of order 10
    near: Any = {"rtol": 0, "atol": 1e-9}
    np.testing.assert_allclose(found["joint_error"] * scale["joint_error"], desired[:3] - q, **near)
    saturating = found["small_joint_error"]
    z = saturating / (1 - np.abs(saturating))
    np.testing.assert_allclose(z * scale["small_joint_error"], desired[:3] - q, **near)
    error = found["joint_velocity_error"] * scale["joint_velocity_error"]
    np.testing.assert_allclose(error, desired[3:6] - velocity, **near)
    rate = found["scaled_desired_acceleration"] * scale["scaled_desired_acceleration"]
    np.testing.assert_allclose(rate, desired[6:], **near)
    np.testing.assert_allclose(found["revolute_sine"], np.sin(q[[0, 2]]), **near)
    np.testing.assert_allclose(found["revolute_cosine"], np.cos(q[[0, 2]]), **near)
    assert np.abs(desired[:3] - q).max() > 1e-3


def test_contact_loads_follow_from_virtual_work() -> None:
    """τ·dq = h·dp, with dp from differences of the direct kinematics."""
    env = preset(CONTACT, surface_stiffness=500.0)
    arm = env.arm
    assert isinstance(arm, PRPArm)
    layout = env.task.layout
    rng = np.random.default_rng(0)
    fields = rng.uniform(-0.2, 0.2, (1, layout.size))
    force, desired = np.array([1.0, -2.0, 0.5]), np.array([0.3, 1.0, 0.0])
    fields[0, layout.index("contact_force")], fields[0, layout.index("desired_force")] = force, desired
    found = {
        name: part[0]
        for name, part in ErrorObservation(layout, arm)
        .layout.split(ErrorObservation(layout, arm)(fields))
        .items()
    }
    q, step = fields[0, layout.index("joint_position")], 1e-6
    columns = [
        (arm.forward_kinematics(q + step * unit)[:3] - arm.forward_kinematics(q - step * unit)[:3])
        / (2 * step)
        for unit in np.eye(3)
    ]
    scale = {part.name: np.array(part.scale) for part in read_parts()["arm"]}
    for name, value in {
        "contact_load": force,
        "desired_contact_load": desired,
        "contact_load_error": desired - force,
    }.items():
        # central differences of second order over a micrometre
        np.testing.assert_allclose(found[name] * scale[name], np.array(columns) @ value, atol=1e-8)


def test_parts_are_declared_once_each_with_its_unit() -> None:
    for parts in read_parts().values():
        assert len({part.name for part in parts}) == len(parts)
        assert all(part.description and len(part.unit) == len(part.scale) for part in parts)
    layouts = {len(preset(task_id).observation_layout.names) for task_id in prp_gym.list_envs()}
    assert max(layouts) == len(read_parts()["arm"])


def test_controller_is_refused_with_what_to_do(task_id: str) -> None:
    for env in (preset(task_id), gymnasium.make_vec(learning_id(task_id), num_envs=2)):
        with pytest.raises(
            ErrorObservationError, match=f"gymnasium.make\\('{task_id}', control_frequency=50"
        ):
            prp_gym.make_baseline("joint_pd", env)


def test_unknown_kind_of_observation_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="observation"):
        gymnasium.make(POSE, observation="error")


class Still:
    """A policy of zero actions."""

    batched: ClassVar[bool] = True

    def predict(self, observation: Any, *_: Any, **__: Any) -> tuple[Any, None]:
        return np.zeros((*np.shape(observation)[:-1], 3)), None


def test_policy_is_evaluated_as_one_of_the_task() -> None:
    found = prp_gym.evaluate(Still(), preset(POSE, **SHORT), episodes=3, seed=1)
    expected = prp_gym.evaluate(Still(), task(POSE, **SHORT), episodes=3, seed=1)
    assert {rollout.environment_id for rollout in found.rollouts} == {POSE}
    assert found.metrics.keys() == expected.metrics.keys()
    for name, values in found.metrics.items():
        np.testing.assert_array_equal(values, expected.metrics[name])


def test_agent_keeps_the_preset_on_its_card_and_counts_for_the_task(tmp_path: Path) -> None:
    env = preset("PRP-Adaptive-v0", **SHORT)
    model = PPO("MlpPolicy", env, seed=0, device="cpu", n_steps=20, batch_size=10, n_epochs=1)
    environment_id = learning_id("PRP-Adaptive-v0")
    facts = AgentFacts(environment_id, dict(SHORT), env.observation_layout, RUN)
    save_agent(export_agent(model, identity_normalizer(env.observation_layout.size), facts), tmp_path / "own")
    policy = load_agent(tmp_path / "own")
    card = policy.card
    assert (card.environment_id, card.task_id) == (environment_id, "PRP-Adaptive-v0")
    assert (card.control_frequency, card.action_mode) == (50.0, "torque")
    made = policy.make_env()
    observation, _ = made.reset(seed=0)
    np.testing.assert_allclose(
        policy.predict(observation)[0], model.predict(observation, deterministic=True)[0], atol=1e-5
    )
    with pytest.raises(InvalidValueError, match="of the environment"):
        policy.check_env(task("PRP-Adaptive-v0", **SHORT))
    (agent,) = [item for item in find_agents(["PRP-Adaptive-v0"], [tmp_path / "own"]) if "own" in item.path]
    assert (agent.environment_id, agent.group, agent.control_frequency) == (
        "PRP-Adaptive-v0",
        "own (RL)",
        50.0,
    )


def test_stock_ppo_learns_with_its_default_numbers() -> None:
    torch.set_num_threads(1)
    env = preset("PRP-Adaptive-v0")
    model = PPO("MlpPolicy", env, seed=0, device="cpu")
    before = prp_gym.evaluate(model, env, episodes=10, seed=1_000_000).metrics["score"].mean()
    after = prp_gym.evaluate(model.learn(2 * 2048), env, episodes=10, seed=1_000_000).metrics["score"].mean()
    assert after > before + 0.02


@pytest.fixture
def blind_task() -> Iterator[str]:
    """A task of another package that observes the arm alone, without a desired motion."""

    def compose(setup: TaskSetup) -> TaskParts:
        parts = TASKS[POSE].entry.compose(setup)
        reference = copy.copy(parts.reference)
        kind = type(reference)
        reference.__class__ = type("Blind", (kind,), {"fields": (replace(kind.fields[0], name="aim"),)})
        return replace(parts, reference=reference)

    found = TASKS[POSE]
    entry = TaskEntry(compose, found.entry.options)
    register_task(replace(found, id="Test-Blind-v0", entry=entry, summary="blind"))
    yield "Test-Blind-v0"
    TASKS.unregister("Test-Blind-v0")
    del gymnasium.registry["Test-Blind-v0"], gymnasium.registry["Test-Blind-RL-v0"]


def test_task_without_a_desired_motion_has_no_errors(blind_task: str) -> None:
    with pytest.raises(
        InvalidValueError, match="errors need joint_position, joint_velocity and a desired motion"
    ):
        gymnasium.make(learning_id(blind_task))


def test_errors_need_the_measured_fields() -> None:
    with pytest.raises(PRPError, match="observation is 'errors'"):
        ErrorObservation(ObservationLayout(MEASURED_FIELDS), PRPArm())
    assert isinstance(task("PRP-Adaptive-v0").task.model, Link)
