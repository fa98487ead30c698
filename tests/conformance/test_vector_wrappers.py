"""Many environments under Gymnasium's vector wrappers, its other ways of making vectors, and their specs."""

import json
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from gymnasium.wrappers import vector as wrappers

from prp_gym.envs import PRPVectorEnv
from tests.support.vector_episodes import (
    IDS,
    MODES,
    SHORT,
    actions_for,
    assert_same,
    one_by_one,
    single,
    together,
)

N = 3
FORCE = "PRP-Force-v0"
TWICE = np.array([[-2.0] * 3, [2.0] * 3], dtype=np.float32)
Wrapper = Callable[[Any], Any]

EVERY_MODE: dict[str, Wrapper] = {
    "statistics": wrappers.RecordEpisodeStatistics,
    "reward": wrappers.NormalizeReward,
    "clipped reward": lambda env: wrappers.ClipReward(env, 0.001, 0.005),
    "rescaled": lambda env: wrappers.RescaleAction(env, *TWICE),
    "clipped": wrappers.ClipAction,
    "list": wrappers.DictInfoToList,
    "transformed action": lambda env: wrappers.TransformAction(env, lambda action: 0.5 * action),
    "each action": lambda env: wrappers.VectorizeTransformAction(
        env, gymnasium.wrappers.TransformAction, func=lambda action: -action, action_space=None
    ),
    "together": lambda env: wrappers.DictInfoToList(
        wrappers.RecordEpisodeStatistics(wrappers.ClipAction(wrappers.NormalizeReward(env)))
    ),
}
NOT_IN_THE_SAME_STEP: dict[str, Wrapper] = {  # by Gymnasium's own rule for wrappers of observations
    "transformed": lambda env: wrappers.TransformObservation(env, lambda seen: 2.0 * seen),
    "each observation": lambda env: wrappers.VectorizeTransformObservation(
        env, gymnasium.wrappers.TransformObservation, func=lambda seen: seen + 1.0, observation_space=None
    ),
}
CASES = [
    ("observation", wrappers.NormalizeObservation, "NextStep"),  # by its own rule in no other mode
    *((name, wrap, mode) for name, wrap in EVERY_MODE.items() for mode in MODES),
    *((name, wrap, mode) for name, wrap in NOT_IN_THE_SAME_STEP.items() for mode in ("NextStep", "Disabled")),
]
# the first takes no others; the statistics of SyncVectorEnv forget episodes that go on, for it takes the mask
# out of the options before they see it
WHOLE_RESETS = ("observation", "statistics", "together")


def plain(value: Any) -> Any:
    """Without what is the clock's."""
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items() if name not in ("t", "_t")}
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


@pytest.mark.parametrize(("name", "wrap", "mode"), CASES, ids=["-".join(case[::2]) for case in CASES])
def test_wrapped_environments_are_gymnasiums_own_vector_wrapped(name: str, wrap: Wrapper, mode: str) -> None:
    if name == "together" and gymnasium.__version__.startswith("1.1."):
        pytest.skip("DictInfoToList of Gymnasium 1.1 fails on its own RecordEpisodeStatistics")
    ours, theirs = wrap(together(FORCE, mode, N, **SHORT)), wrap(one_by_one(FORCE, mode, N, **SHORT))
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.action_space == theirs.action_space
    assert_same(plain(ours.reset(seed=3)), plain(theirs.reset(seed=3)), "reset")
    for count, action in enumerate(actions_for(ours, 6 if mode == "Disabled" else 16)):
        if count == 2 and name not in WHOLE_RESETS:  # so that episodes end at different steps
            options = [{"reset_mask": np.array([True, False, False])} for _ in range(2)]
            again = ours.reset(options=options[0]), theirs.reset(options=options[1])
            assert_same(plain(again[0]), plain(again[1]), "reset of some")
        found, expected = ours.step(action.copy()), theirs.step(action)  # some wrappers write into actions
        assert_same(plain(found), plain(expected), f"step {count}")
    for env in (ours, theirs):
        env.close()
    assert ours.unwrapped.closed


def test_episode_statistics_are_sums_of_rewards() -> None:
    env = wrappers.RecordEpisodeStatistics(together(FORCE, "NextStep", N, **SHORT))
    env.reset(seed=0)
    rewards = []
    for action in actions_for(env, 6):
        _, reward, _, truncated, info = env.step(action)
        rewards.append(reward)
    assert truncated.all()
    np.testing.assert_allclose(info["episode"]["r"], np.sum(rewards, axis=0), rtol=1e-6)  # single precision
    np.testing.assert_array_equal(info["episode"]["l"], [6, 6, 6])


def test_episode_statistics_go_on_where_others_begin_anew() -> None:
    env = wrappers.RecordEpisodeStatistics(together(FORCE, "Disabled", N, **SHORT))
    env.reset(seed=0)
    rewards = []
    for count, action in enumerate(actions_for(env, 6)):
        if count == 2:
            env.reset(options={"reset_mask": np.array([True, False, False])})
        _, reward, _, truncated, info = env.step(action)
        rewards.append(reward)
    assert truncated.tolist() == [False, True, True]
    expected = np.where(truncated, np.sum(rewards, axis=0), 0.0)
    np.testing.assert_allclose(info["episode"]["r"], expected, rtol=1e-6)  # single precision
    np.testing.assert_array_equal(info["episode"]["l"], [0, 6, 6])


@pytest.mark.parametrize("environment_id", IDS)
def test_spec_makes_the_same_environments_again(environment_id: str) -> None:
    env = together(environment_id, "SameStep", N, scenario="realistic", **SHORT)
    assert env.spec is not None
    again = gymnasium.make_vec(env.spec)
    told = gymnasium.make_vec(EnvSpec.from_json(env.spec.to_json()))
    assert json.loads(env.spec.to_json())["kwargs"]["autoreset_mode"] == "SameStep"
    for other in (again, told):
        assert isinstance(other, PRPVectorEnv)
        assert (other.num_envs, other.config, other.metadata) == (N, env.config, env.metadata)
        assert other.spec == env.spec
        assert str(other) == f"{type(env).__name__}({environment_id}, num_envs={N})"
    assert_same(again.reset(seed=1), env.reset(seed=1), "reset")
    for action in actions_for(env, 7):
        assert_same(again.step(action), env.step(action), "step")


def test_one_environment_is_what_is_made_without_a_number() -> None:
    env = gymnasium.make_vec(FORCE)
    assert isinstance(env, PRPVectorEnv)
    assert env.num_envs == 1
    np.testing.assert_array_equal(env.reset(seed=3)[0][0], single(FORCE).reset(seed=3)[0])
    assert env.spec is not None
    assert gymnasium.make_vec(env.spec).num_envs == 1


def test_modes_are_gymnasiums_and_next_step_without_one() -> None:
    for mode in gymnasium.vector.AutoresetMode:
        env = gymnasium.make_vec(FORCE, N, autoreset_mode=mode)
        assert env.metadata["autoreset_mode"] is mode
        assert together(FORCE, mode.value).metadata["autoreset_mode"] is mode
    assert gymnasium.make_vec(FORCE, N).metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.NEXT_STEP


@pytest.mark.parametrize(("how", "kind"), [("sync", SyncVectorEnv), ("async", AsyncVectorEnv)])
def test_gymnasiums_other_vectors_give_the_same(how: str, kind: type) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", **SHORT}
    ours = together("PRP-JointTracking-v0", "NextStep", N, **keywords)
    theirs = gymnasium.make_vec("PRP-JointTracking-v0", N, how, **keywords)
    assert isinstance(theirs, kind)
    try:
        assert_same(ours.reset(seed=3), theirs.reset(seed=3), "reset")
        for count, action in enumerate(actions_for(ours, 8)):
            assert_same(ours.step(action), theirs.step(action), f"step {count}")
    finally:
        theirs.close()


FRESH = """
import sys, gymnasium
env = gymnasium.make_vec("prp_gym:PRP-Impedance-v0", num_envs=2)
observation, _ = env.reset(seed=0)
print(type(env).__name__, observation.shape[0], env.spec.id, float(observation.sum()).hex())
"""


def test_environments_are_made_in_a_fresh_interpreter_that_imports_nothing() -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", FRESH],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    total = float(together("PRP-Impedance-v0", num_envs=2).reset(seed=0)[0].sum()).hex()
    assert done.stdout.split() == ["PRPVectorEnv", "2", "PRP-Impedance-v0", total]


@pytest.mark.parametrize("environment_id", IDS)
def test_everything_that_is_returned_is_in_the_spaces(environment_id: str) -> None:
    env = together(environment_id, "SameStep", N, scenario="realistic", **SHORT)
    env.action_space.seed(0)
    assert env.observation_space.contains(env.reset(seed=0)[0])
    for _ in range(8):
        action = env.action_space.sample()
        assert env.action_space.contains(action)
        observation, reward, terminated, truncated, info = env.step(action)
        assert env.observation_space.contains(observation)
        assert [str(array.dtype) for array in (reward, terminated, truncated)] == ["float64", "bool", "bool"]
        for final in info.get("final_obs", ()):
            assert final is None or env.single_observation_space.contains(final)
