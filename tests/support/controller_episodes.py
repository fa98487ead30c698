"""What the tests of every law on every environment share: the pairs, and observations of real episodes."""

from contextlib import closing
from functools import cache
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import prp_gym
from prp_gym.baselines import Baseline, list_baselines, make_baseline

Array = NDArray[np.float64]


def make(environment_id: str, **options: Any) -> Any:
    return gymnasium.make(environment_id, **options)


def laws_of(environment_id: str) -> list[str]:
    """The laws that can run on an environment."""
    with closing(make(environment_id)) as env:
        return list_baselines(env.get_wrapper_attr("observation_layout"))


PAIRS = [(name, controller) for name in prp_gym.list_envs() for controller in laws_of(name)]


@cache
def observed_episodes(
    environment_id: str, controller: str, count: int, length: int
) -> tuple[Baseline[Any], Array]:
    """A law, and what it observes in the first second of realistic episodes (length, count, size)."""
    with closing(make(environment_id, scenario="realistic", duration=1.0)) as env:
        policy, loop = make_baseline(controller, env), env.unwrapped.make_loop(count)
    rngs = [np.random.default_rng(seed) for seed in range(count)]
    observation, state = loop.reset(np.arange(count), rngs, {}), None
    starts, seen = np.ones(count, dtype=np.bool_), []
    for _ in range(500):
        seen.append(observation)
        action, state = policy.predict(observation, state, starts)
        observation, starts = (
            loop.step(action.astype(np.float64)).observation,
            np.zeros(count, dtype=np.bool_),
        )
    return policy, np.array(seen)[:: 500 // length]
