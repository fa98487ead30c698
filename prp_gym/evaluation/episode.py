"""One episode, run through an environment's wrappers and recorded."""

import time
from typing import Any

import gymnasium
import numpy as np

from prp_gym.evaluation.policy_output import check_output
from prp_gym.evaluation.recorder import Recorder
from prp_gym.evaluation.rollout import Policy, Rollout, check_environment, inner_time

_TIMED = 16  # periods on which the compute time of an inner controller is measured


def record_episode(
    policy: Policy, env: gymnasium.Env[Any, Any], seed: int, options: dict[str, Any] | None = None
) -> Rollout:
    """Run one episode and record it.

    Args:
        policy: policy that reads the environment's observations.
        env: an environment of this suite; wrappers must leave observations as they are.
        seed: random seed of the episode.
        options: reset options.

    Returns:
        the episode.

    Raises:
        InvalidValueError: an environment of another suite.
        PolicyOutputError: the policy returns something else than a finite action and a state.
    """
    inner: Any = check_environment(env)
    shape = tuple(env.action_space.shape or ())
    observation, _ = env.reset(seed=seed, options=options)
    recorder, costs = Recorder(inner, inner.loop), []
    state, start, over = None, np.array([True]), False
    with recorder.listening():
        while not over:
            before = time.perf_counter()
            output = policy.predict(observation, state, episode_start=start, deterministic=True)
            costs.append(time.perf_counter() - before)
            action, state = check_output(policy, output, shape)
            observation, _, terminated, truncated, _ = env.step(action)
            start, over = np.array([False]), terminated or truncated
    inside = np.median([inner_time(inner.loop) for _ in range(_TIMED)])
    return recorder.rollout(0, seed, np.array(costs) + inside)
