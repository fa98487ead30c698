"""The specification of environments tells the length of their episodes, however they were made."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.wrappers import TimeAwareObservation

import prp_gym
from prp_gym.envs import PRPEnv, PRPVectorEnv

FORCE = "PRP-Force-v0"
RATE = 50.0  # [Hz]
SHORT: dict[str, Any] = {"control_frequency": RATE, "duration": 0.2}
STEPS = 10
WAYS: dict[str, tuple[dict[str, Any], int]] = {
    "as registered": ({}, 2500),
    "shorter": ({"duration": 2.0}, 1000),
    "longer": ({"duration": 10.0}, 5000),
    "slower": ({"control_frequency": RATE}, 250),
    "by steps": ({"max_episode_steps": 100}, 100),
    "in a mode": ({"action_mode": "impedance", "control_frequency": RATE, "duration": 1.0}, 50),
}


@pytest.mark.parametrize("way", WAYS)
def test_spec_tells_the_number_of_steps(way: str) -> None:
    keywords, steps = WAYS[way]
    for env in (gymnasium.make(FORCE, **keywords), gymnasium.make_vec(FORCE, 2, **keywords)):
        assert env.spec is not None
        assert env.spec.max_episode_steps == steps


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_registered_spec_leaves_the_number_to_the_keywords(environment_id: str) -> None:
    env = gymnasium.make(environment_id, **SHORT)
    assert env.spec is not None
    assert env.spec.max_episode_steps == STEPS
    assert gymnasium.spec(environment_id).max_episode_steps is None


def test_environment_that_gymnasium_did_not_make_has_no_spec() -> None:
    assert PRPEnv.spec is None
    assert PRPEnv(FORCE).spec is None
    assert PRPVectorEnv(FORCE).spec is None


def test_assigned_spec_is_copied() -> None:
    env = PRPEnv(FORCE, **SHORT)
    registered = gymnasium.spec(FORCE)
    env.spec = registered
    assert registered.max_episode_steps is None
    assert env.spec is not None
    assert env.spec.max_episode_steps == STEPS
    env.spec = None
    assert env.spec is None


def test_copies_keep_the_spec() -> None:
    env = gymnasium.make(FORCE, **SHORT).unwrapped
    for clone in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert clone.spec == env.spec


def truncations(env: Any, steps: int) -> list[bool]:
    env.reset(seed=0)
    flags = [env.step(np.zeros(3, dtype=np.float32))[2:4] for _ in range(steps)]
    assert not any(terminated for terminated, _ in flags)
    return [truncated for _, truncated in flags]


def test_environment_made_from_a_spec_or_its_text_ends_episodes_at_the_same_step() -> None:
    env = gymnasium.make(FORCE, **SHORT)
    assert env.spec is not None
    made = [gymnasium.make(spec) for spec in (env.spec, EnvSpec.from_json(env.spec.to_json()))]
    for other in (env, *made):
        assert other.spec == env.spec
        assert truncations(other, STEPS) == [False] * (STEPS - 1) + [True]


def test_fewer_steps_end_the_episode_with_the_same_info() -> None:
    limited, whole = gymnasium.make(FORCE, **SHORT, max_episode_steps=4), gymnasium.make(FORCE, **SHORT)
    for env in (limited, whole):
        env.reset(seed=0)
    for count in range(4):
        ours, theirs = (env.step(np.zeros(3, dtype=np.float32)) for env in (limited, whole))
        assert ours[3] == (count == 3)
        assert ours[4] == theirs[4]


@pytest.mark.parametrize("mode", ["vector_entry_point", "sync"])
def test_vectors_from_a_spec_end_episodes_at_the_same_step(mode: str) -> None:
    first = gymnasium.make_vec(FORCE, 2, vectorization_mode=mode, **SHORT, max_episode_steps=4)
    assert first.spec is not None
    for env in (first, gymnasium.make_vec(first.spec)):
        env.reset(seed=0)
        flags = [env.step(np.zeros((2, 3), dtype=np.float32))[3].tolist() for _ in range(4)]
        assert flags == [[False, False]] * 3 + [[True, True]]
        env.close()


def test_time_can_be_observed() -> None:
    env = TimeAwareObservation(gymnasium.make(FORCE, **SHORT), normalize_time=True)
    observation, _ = env.reset(seed=0)
    shares = [observation[-1]]
    for _ in range(STEPS):
        observation, _, _, truncated, _ = env.step(np.zeros(3, dtype=np.float32))
        shares.append(observation[-1])
    assert truncated
    np.testing.assert_allclose(shares, np.linspace(0.0, 1.0, STEPS + 1), rtol=1e-6)  # single precision
