"""Stable-Baselines3 on many environments together: construction, learning, evaluation of controllers."""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.vector import SyncVectorEnv
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecMonitor, VecNormalize

import prp_gym
from prp_gym import extras
from prp_gym.agents.sb3.vec_env import SB3VecEnv
from prp_gym.errors import InvalidValueError, MissingPackageError, UnknownNameError
from tests.support.sb3_environments import assert_same

N = 4
ID = "PRP-JointRegulation-v0"
SHORT: dict[str, Any] = {"duration": 0.2, "control_frequency": 50}  # [s], [Hz]: episodes of ten steps

torch.set_num_threads(1)


def many(environment_id: str = ID, seed: int | None = None, **keywords: Any) -> VecEnv:
    return prp_gym.make_sb3_vec_env(environment_id, N, seed, **{**SHORT, **keywords})


def singles(environment_id: str = ID, seed: int | None = None, **keywords: Any) -> VecEnv:
    """What Stable-Baselines3 makes by itself, with the statistics of many environments together."""
    env_kwargs = {**SHORT, **keywords, "render_mode": None}
    return VecMonitor(
        DummyVecEnv([partial(gymnasium.make, environment_id, **env_kwargs)] * N)
        if seed is None
        else make_vec_env(environment_id, N, seed, env_kwargs=env_kwargs)
    )


def ppo(env: VecEnv) -> PPO:
    return PPO("MlpPolicy", env, n_steps=16, batch_size=32, n_epochs=2, seed=3, device="cpu")


def sac(env: VecEnv) -> SAC:
    return SAC("MlpPolicy", env, learning_starts=40, batch_size=16, buffer_size=500, seed=3, device="cpu")


def weights(model: BaseAlgorithm) -> list[Any]:
    return [parameter.detach().numpy() for parameter in model.policy.parameters()]


def test_seeds_are_those_of_stable_baselines() -> None:
    ours = many(seed=21)
    theirs = make_vec_env(ID, N, seed=21, env_kwargs=SHORT)
    np.testing.assert_array_equal(ours.action_space.sample(), theirs.action_space.sample())
    for _ in range(2):  # the seeds, then the generators that go on
        assert_same(ours.reset(), theirs.reset(), "reset")


def test_without_a_seed_numpys_global_generator_draws_it() -> None:
    starts: list[Any] = []
    for seed in (1, 1, 2):
        np.random.seed(seed)  # noqa: NPY002 (what Stable-Baselines3 draws from)
        starts.append(many().reset())
    np.testing.assert_array_equal(starts[0], starts[1])
    assert not np.array_equal(starts[0], starts[2])


def test_keywords_reach_the_environments() -> None:
    env = prp_gym.make_sb3_vec_env(f"prp_gym:{ID}", 3, num_threads=1, control_frequency=250)
    assert isinstance(env, VecMonitor)
    assert isinstance(env.unwrapped, SB3VecEnv)
    assert env.get_attr("control_frequency") == [250.0] * 3
    assert env.unwrapped.spec is not None
    assert env.unwrapped.spec.kwargs["num_threads"] == 1
    env.close()


def test_module_of_an_id_is_imported_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = (
        "import gymnasium\nfrom prp_gym.envs.vector import PRPVectorEnv\n"
        "gymnasium.register('Own-v0', vector_entry_point=PRPVectorEnv, kwargs={'task': 'PRP-Force-v0'})"
    )
    (tmp_path / "module_with_an_id.py").write_text(code, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    env = prp_gym.make_sb3_vec_env("module_with_an_id:Own-v0", 2)
    del gymnasium.registry["Own-v0"]
    assert env.get_attr("task")[0].environment_id == "PRP-Force-v0"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("autoreset_mode", "SameStep"),
        ("num_envs", 3),
        ("vectorization_mode", "sync"),
        ("vector_kwargs", {}),
        ("wrappers", ()),
    ],
)
def test_what_stable_baselines_settles_is_refused(name: str, value: Any) -> None:
    with pytest.raises(InvalidValueError, match="Stable-Baselines3 leaves no choice") as caught:
        prp_gym.make_sb3_vec_env(ID, N, **{name: value})
    assert (caught.value.what, caught.value.value) == (name, value)


@pytest.mark.parametrize("environment_id", ["CartPole-v1", "Pendulum-v1"])
def test_environments_of_other_suites_are_refused(environment_id: str) -> None:
    with pytest.raises(InvalidValueError, match=r"allowed: an environment of prp_gym; see prp_gym.list_envs"):
        prp_gym.make_sb3_vec_env(environment_id, 2)


def test_unknown_ids_and_keywords_are_refused_as_by_gymnasium() -> None:
    with pytest.raises(gymnasium.error.NameNotFound, match="JointRegulation"):
        prp_gym.make_sb3_vec_env("PRP-JointRegulations-v0")
    with pytest.raises(UnknownNameError, match="control_frequency"):
        prp_gym.make_sb3_vec_env(ID, control_frequncy=50)
    with pytest.raises(InvalidValueError, match="num_envs"):
        prp_gym.make_sb3_vec_env(ID, 0)
    with pytest.raises(InvalidValueError, match="num_threads"):
        prp_gym.make_sb3_vec_env(ID, num_threads=-1)


@pytest.mark.parametrize("package", ["stable_baselines3", "torch"])
def test_missing_package_is_named_with_the_command_that_installs_it(
    package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingPackageError, match=rf"^{package} .* pip install 'prp-gym\[agents\]'$"):
        many()


def test_what_an_installed_package_lacks_is_not_taken_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: str) -> None:
        raise ModuleNotFoundError("No module named 'pandas'", name="pandas")

    monkeypatch.setattr(extras, "import_module", broken)
    with pytest.raises(ModuleNotFoundError, match="pandas"):
        many()


@pytest.mark.parametrize("make_agent", [ppo, sac])
def test_agent_learns_to_the_bit_what_it_learns_on_single_environments(make_agent: Any) -> None:
    agents = [make_agent(env()).learn(256) for env in (many, many, singles)]
    before = make_agent(many())
    assert all((new != old).any() for new, old in zip(weights(agents[0])[:1], weights(before), strict=False))
    batch = np.array([agents[0].observation_space.sample() for _ in range(8)]).clip(-1.0, 1.0)
    for other in agents[1:]:
        for ours, theirs in zip(weights(agents[0]), weights(other), strict=True):
            np.testing.assert_array_equal(ours, theirs)
        predictions = [agent.predict(batch, deterministic=True)[0] for agent in (agents[0], other)]
        np.testing.assert_array_equal(*predictions)
    lengths = [int(episode["l"]) for episode in agents[0].ep_info_buffer]
    assert lengths == [10] * (6 * N)  # 64 steps each
    assert agents[0].num_timesteps == 256


def test_agent_learns_on_normalised_observations() -> None:
    env = VecNormalize(many("PRP-Force-v0"))
    agent = ppo(env).learn(128)
    assert all(np.isfinite(values).all() for values in weights(agent))


def test_saved_agent_acts_as_before_without_environments(tmp_path: Path) -> None:
    env = many(seed=5)
    agent = ppo(env).learn(64)
    agent.save(tmp_path / "agent.zip")
    back = PPO.load(tmp_path / "agent.zip", device="cpu")
    assert back.get_env() is None
    observation = env.reset()
    assert isinstance(observation, np.ndarray)
    found, expected = (each.predict(observation, deterministic=True)[0] for each in (back, agent))
    np.testing.assert_array_equal(found, expected)
    back.set_env(env)
    assert back.learn(64).num_timesteps == 64


@pytest.mark.parametrize(
    ("environment_id", "controller"),
    [
        ("PRP-Force-v0", "force_inner_position"),
        ("PRP-JointTracking-v0", "adaptive"),
        (ID, "joint_pd"),
    ],
)
def test_evaluate_policy_gives_the_returns_of_a_controller(environment_id: str, controller: str) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "control_frequency": 500, "duration": 0.1}
    env = many(environment_id, 11, **keywords)
    policy: Any = prp_gym.make_baseline(controller, env)
    returns: Any
    returns, lengths = evaluate_policy(policy, env, 2 * N, return_episode_rewards=True)
    assert lengths == [50] * (2 * N)
    single = gymnasium.make(environment_id, **keywords)
    rollouts = prp_gym.evaluate(prp_gym.make_baseline(controller, single), single, N, seed=11).rollouts
    # fifty rewards of at most 1 in float32, summed in float32: fifty roundings of 6e-8 of at most 50
    np.testing.assert_allclose(returns[:N], [r.reward.sum() for r in rollouts], rtol=0, atol=1.5e-4)
    theirs = singles(environment_id, **keywords)
    theirs.seed(11)
    assert returns == evaluate_policy(policy, theirs, 2 * N, return_episode_rewards=True)[0]


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_controller_is_the_same_for_single_and_vectorised_environments(environment_id: str) -> None:
    single = gymnasium.make(environment_id)
    name = "adaptive" if "Adaptive" in environment_id else "joint_pd"
    expected = prp_gym.make_baseline(name, single)
    makers: list[Callable[[], Any]] = [
        lambda: gymnasium.make_vec(environment_id, 2),
        lambda: SyncVectorEnv([partial(gymnasium.make, environment_id)] * 2),
        lambda: prp_gym.make_sb3_vec_env(environment_id, 2),
        lambda: prp_gym.make_sb3_vec_env(environment_id, 2).unwrapped,
        lambda: VecNormalize(DummyVecEnv([partial(gymnasium.make, environment_id)] * 2)),
    ]
    batch = np.random.default_rng(0).uniform(-0.2, 0.2, (5, *(single.observation_space.shape or ())))
    for make in makers:
        controller = prp_gym.make_baseline(name, make())
        assert controller.interface.environment_id == environment_id
        assert controller.interface.period == expected.interface.period
        assert controller.interface.layout == expected.interface.layout
        assert controller.interface.target_impedance.keys() == expected.interface.target_impedance.keys()
        np.testing.assert_array_equal(controller.interface.torque_limit, expected.interface.torque_limit)
        np.testing.assert_array_equal(controller.predict(batch)[0], expected.predict(batch)[0])


@pytest.mark.parametrize(
    "env", [DummyVecEnv([partial(gymnasium.make, "CartPole-v1")]), gymnasium.make_vec("CartPole-v1", 2), 3]
)
def test_controller_refuses_vectorised_environments_of_another_suite(env: object) -> None:
    with pytest.raises(InvalidValueError, match="an environment of prp_gym"):
        prp_gym.make_baseline("joint_pd", env)
