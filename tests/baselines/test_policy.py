"""What all controllers share: the interface to environments, settings, and Stable-Baselines3's `predict`."""

import pickle
from collections.abc import Callable, Iterator, Mapping
from dataclasses import FrozenInstanceError, dataclass, replace
from functools import partial
from typing import Any, ClassVar

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import ClipAction, FrameStackObservation, RecordEpisodeStatistics, TimeLimit
from numpy.typing import NDArray
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv

import prp_gym
from prp_gym.baselines import (
    BASELINES,
    Baseline,
    ControlInterface,
    Settings,
    StaticBaseline,
    Vector,
    make_baseline,
)
from prp_gym.baselines.base.force_loop import ForceLoop
from prp_gym.baselines.base.references import REFERENCE_FIELDS
from prp_gym.baselines.force_feedforward import ForceFeedforwardController
from prp_gym.errors import InvalidValueError, MissingFieldError, ShapeError
from prp_gym.evaluation import evaluate
from prp_gym.robot import PRPArm
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import SCENARIOS
from tests.support.controller_episodes import COMBINATIONS, COVERING, ONE_EACH, fields_read

Array = NDArray[np.float64]
Env = gymnasium.Env[Any, Any]

LIMIT = np.array([50.0, 100.0, 10.0])
# batched and single matrix products may round differently: torques up to 1e3, a few dozen operations
ROUNDING = 1e-12


def make(environment_id: str, **options: Any) -> Env:
    return gymnasium.make(environment_id, **{"duration": 0.1, **options})


@pytest.fixture(params=COVERING, ids="-".join)
def env_and_policy(request: pytest.FixtureRequest) -> Iterator[tuple[Env, Baseline[Any]]]:
    """Every controller on every kind of environment that it distinguishes."""
    environment_id, controller = request.param
    env = make(environment_id)
    yield env, make_baseline(controller, env)
    env.close()


@pytest.fixture
def env() -> Iterator[Env]:
    made = make("PRP-JointTracking-v0", control_frequency=1000, torque_limit=(50.0, 100.0, 10.0))
    yield made
    made.close()


def torques_of(policy: Baseline[Any], observation: Array) -> Array:
    """The unlimited torques of the first step of an episode."""
    observed = policy.interface.layout.split(observation)
    return policy.control(observed, policy.initial_state(observed))[0]


def observations(env: Env, seed: int, count: int) -> Array:
    """Random observations near those of an episode, (count, size)."""
    size = env.get_wrapper_attr("observation_layout").size
    return np.random.default_rng(seed).uniform(-1.0, 1.0, size=(count, size))


@dataclass(frozen=True, eq=False)
class HoldSettings(Settings):
    torque: Any

    vectors: ClassVar = {"torque": Vector("joint", "N·m")}


class Hold(StaticBaseline[HoldSettings]):
    """A controller that reads one field and always commands the same torque."""

    name = "hold"
    summary = "constant torque"
    measured_fields = ("joint_velocity",)
    settings_class = HoldSettings

    def torque(self, observed: Mapping[str, Array]) -> Array:
        torque: Array = self.settings.torque + 0.0 * observed["joint_velocity"]
        return torque


def test_every_environment_has_a_controller_and_every_controller_an_environment() -> None:
    assert {name for name, _ in COMBINATIONS} == set(prp_gym.list_envs())
    assert {controller for _, controller in COMBINATIONS} == set(BASELINES)


def test_interface_holds_what_a_controller_may_know(env: Env) -> None:
    interface = ControlInterface.of(env)
    assert interface.environment_id == "PRP-JointTracking-v0"
    assert interface.layout == env.get_wrapper_attr("observation_layout")
    np.testing.assert_array_equal(interface.torque_limit, LIMIT)
    assert interface.model == env.get_wrapper_attr("task").model == PRPArm()
    assert interface.period == 1.0 / 1000
    with pytest.raises(FrozenInstanceError):
        interface.period = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(
    "wrap",
    [
        lambda env: env.unwrapped,
        partial(TimeLimit, max_episode_steps=5),
        ClipAction,
        RecordEpisodeStatistics,
        Monitor,
        lambda env: FrameStackObservation(env, 2),
    ],
)
def test_interface_is_the_same_through_wrappers(env: Env, wrap: Callable[[Env], Any]) -> None:
    bare, wrapped = ControlInterface.of(env), ControlInterface.of(wrap(env))
    np.testing.assert_array_equal(bare.torque_limit, wrapped.torque_limit)
    assert (bare.environment_id, bare.layout, bare.period) == (
        wrapped.environment_id,
        wrapped.layout,
        wrapped.period,
    )


@pytest.mark.parametrize("foreign", [gymnasium.make("CartPole-v1"), None, "PRP-JointTracking-v0"])
def test_interface_of_another_suite_is_refused(foreign: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"env is .*; allowed: an environment of prp_gym"):
        ControlInterface.of(foreign)


def test_missing_field_is_named_before_anything_runs(env: Env) -> None:
    layout = env.get_wrapper_attr("observation_layout")
    controllers: tuple[type[Baseline[Any]], ...] = (*(spec.policy for spec in BASELINES.values()), Hold)
    for controller in controllers:
        for absent in set(controller.measured_fields) & set(layout.names):
            reduced = ObservationLayout([field for field in layout.fields if field.name != absent])
            interface = ControlInterface("PRP-JointTracking-v0", reduced, LIMIT, 0.002, PRPArm())
            with pytest.raises(MissingFieldError) as caught:
                controller(interface, HoldSettings(1.0))
            assert caught.value.controller == controller.__name__
            assert absent in caught.value.missing
            assert caught.value.available == reduced.names


def test_controller_reads_its_declared_fields_a_reference_and_a_force_where_one_is_desired(
    env_and_policy: tuple[Env, Baseline[Any]],
) -> None:
    env, policy = env_and_policy
    read = fields_read(policy, observations(env, 1, 4))
    reference = {name for fields in REFERENCE_FIELDS for name in fields}
    declared = set(policy.measured_fields)
    assert declared <= read
    of_the_task, of_action_modes = (
        {"desired_force"},
        {"force_offset", "approach_speed_factor", "bandwidth_factor"},
    )
    force_fields = of_the_task | of_action_modes
    pressing = isinstance(policy, ForceLoop | ForceFeedforwardController)
    assert read - declared - reference <= (force_fields if pressing else set())


def test_unread_fields_may_be_absent_and_read_fields_may_be_in_any_order(
    env_and_policy: tuple[Env, Baseline[Any]],
) -> None:
    env, policy = env_and_policy
    layout, interface = policy.interface.layout, policy.interface
    read = fields_read(policy, observations(env, 1, 4))
    # making a controller requires a reference, even if it holds its initial pose
    read |= {name for fields in REFERENCE_FIELDS for name in fields}
    kept = [field for field in reversed(layout.fields) if field.name in read]
    smaller = replace(interface, layout=ObservationLayout(kept))
    observation = observations(env, 1, 4)
    parts = layout.split(observation)
    rearranged = np.concatenate([parts[field.name] for field in kept], axis=-1)
    expected, _ = policy.predict(observation)
    action, _ = type(policy)(smaller, policy.settings).predict(rearranged)
    np.testing.assert_array_equal(action, expected)


def test_action_is_torque_over_its_limit_within_one(env: Env) -> None:
    policy = Hold(ControlInterface.of(env), HoldSettings([25.0, 300.0, 0.0]))
    action, _ = policy.predict(observations(env, 2, 1)[0])
    np.testing.assert_array_equal(action, np.array([0.5, 1.0, 0.0], dtype=np.float32))


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_action_lies_in_the_action_space(env_and_policy: tuple[Env, Baseline[Any]], scale: float) -> None:
    env, policy = env_and_policy
    for observation in scale * observations(env, 3, 20):
        torque = torques_of(policy, observation)
        action, _ = policy.predict(observation)
        assert action.dtype == np.float32
        assert env.action_space.contains(action)
        limited = np.clip(torque, -policy.interface.torque_limit, policy.interface.torque_limit)
        # float32 actions
        np.testing.assert_allclose(action, limited / policy.interface.torque_limit, rtol=1e-6)


def test_batch_of_observations_gives_the_actions_of_each(env_and_policy: tuple[Env, Baseline[Any]]) -> None:
    env, policy = env_and_policy
    batch = observations(env, 4, 16)
    together, _ = policy.predict(batch)
    torques = torques_of(policy, batch)
    joints = policy.model.joint_count
    assert together.shape == torques.shape == (16, joints)
    for row, observation in enumerate(batch):
        action, _ = policy.predict(observation)
        assert action.shape == (joints,)
        # torques agree to rounding, which float32 may round either way
        np.testing.assert_allclose(action, together[row], rtol=1.2e-7)
        single = torques_of(policy, observation)
        np.testing.assert_allclose(single, torques[row], rtol=ROUNDING, atol=ROUNDING * np.abs(torques).max())


def test_first_actions_do_not_depend_on_flags(env_and_policy: tuple[Env, Baseline[Any]]) -> None:
    env, policy = env_and_policy
    batch = observations(env, 5, 2)
    expected, _ = policy.predict(batch)
    flags = np.array([True, False])
    action, _ = policy.predict(batch, episode_start=flags, deterministic=False)
    np.testing.assert_array_equal(action, expected)


def test_observation_is_left_as_it_was_and_may_be_a_list(env_and_policy: tuple[Env, Baseline[Any]]) -> None:
    env, policy = env_and_policy
    observation = observations(env, 6, 1)[0]
    observation.flags.writeable = False
    from_list, _ = policy.predict(observation.tolist())
    np.testing.assert_array_equal(from_list, policy.predict(observation)[0])


@pytest.mark.parametrize("change", [lambda size: size - 1, lambda size: size + 1, lambda size: 0])
def test_observation_of_another_size_is_refused(
    env_and_policy: tuple[Env, Baseline[Any]], change: Callable[[int], int]
) -> None:
    _, policy = env_and_policy
    with pytest.raises(ShapeError, match="observation has shape"):
        policy.predict(np.zeros(change(policy.interface.layout.size)))


def test_observation_of_a_wrapper_that_changes_it_is_refused(
    env_and_policy: tuple[Env, Baseline[Any]],
) -> None:
    env, policy = env_and_policy
    flattened = gymnasium.wrappers.FlattenObservation(FrameStackObservation(env, 3))
    observation, _ = flattened.reset(seed=0)
    with pytest.raises(ShapeError) as caught:
        policy.predict(observation)
    assert caught.value.shape == (3 * policy.interface.layout.size,)


def test_policy_survives_pickling(env_and_policy: tuple[Env, Baseline[Any]]) -> None:
    env, policy = env_and_policy
    batch = observations(env, 7, 4)
    back = pickle.loads(pickle.dumps(policy))
    np.testing.assert_array_equal(back.predict(batch)[0], policy.predict(batch)[0])


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(("environment_id", "controller"), ONE_EACH, ids=map("-".join, ONE_EACH))
def test_evaluator_of_stable_baselines_finds_the_same_returns(
    environment_id: str, controller: str, scenario: str
) -> None:
    single = partial(make, environment_id, scenario=scenario)
    env = single()
    policy: Any = make_baseline(controller, env)
    ours = [rollout.reward.sum() for rollout in evaluate(policy, env, episodes=3, seed=11).rollouts]
    venv = DummyVecEnv([single] * len(ours))
    venv.seed(11)  # the i-th environment starts with seed 11 + i
    returns, lengths = evaluate_policy(policy, venv, len(ours), return_episode_rewards=True, warn=False)
    assert lengths == [50] * len(ours)
    # rewards are float32 in a DummyVecEnv: fifty of at most 2e-3 s, each rounded to 6e-8 of itself
    np.testing.assert_allclose(returns, ours, atol=1e-8)
    monitored = Monitor(single())
    monitored.np_random = np.random.Generator(np.random.PCG64(np.random.SeedSequence(11)))
    mean, deviation = evaluate_policy(policy, monitored, n_eval_episodes=1)
    assert mean == pytest.approx(ours[0], abs=1e-6)  # Monitor rounds to 1e-6
    assert deviation == 0.0
