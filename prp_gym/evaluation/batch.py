"""Episodes of many seeds, simulated side by side."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker

from prp_gym.evaluation.compiled_batch import begin, record_compiled, time_one
from prp_gym.evaluation.policy_output import check_output
from prp_gym.evaluation.recorder import Recorder
from prp_gym.evaluation.rollout import Policy, Rollout, check_environment, inner_time

_TIMED = 64  # actions on which the compute time of a policy is measured
_SIDE_BY_SIDE = 64  # episodes at most; bounds the memory
_TRANSPARENT = (OrderEnforcing, PassiveEnvChecker)


def can_batch(env: gymnasium.Env[Any, Any]) -> bool:
    """Whether the control loop of an environment can simulate its episodes side by side.

    Its only wrappers may be Gymnasium's own checks, its class may not override `step` or `reset`, and it may
    not render frames.
    """
    while isinstance(env, gymnasium.Wrapper):
        if type(env) not in _TRANSPARENT:
            return False
        env = env.env
    owner = next((kind for kind in type(env).__mro__ if "make_loop" in vars(kind)), None)
    if owner is None or env.render_mode is not None:
        return False
    return all(getattr(type(env), name) is getattr(owner, name) for name in ("step", "reset"))


def record_episodes(policy: Policy, env: gymnasium.Env[Any, Any], seeds: Sequence[int]) -> list[Rollout]:
    """Run one episode for each seed, side by side, and record them.

    Each episode is the one that the environment itself would run with that seed. The policy computes all
    actions in one call; its compute time is measured on single observations from time to time. With the
    compiled engine, a controller of this suite runs within the compiled code, with the same results.

    Args:
        policy: policy whose `predict` takes (N, size) observations.
        env: an environment of this suite; wrappers are skipped.
        seeds: random seeds of the episodes, at least one.

    Returns:
        the episodes, in the order of their seeds.

    Raises:
        InvalidValueError: an environment of another suite.
        PolicyOutputError: the policy returns something else than finite actions and a state.
    """
    inner: Any = check_environment(env)
    rollouts: list[Rollout] = []
    for first in range(0, len(seeds), _SIDE_BY_SIDE):
        some = seeds[first : first + _SIDE_BY_SIDE]
        rollouts += record_compiled(policy, inner, some) or _record(policy, inner, some)
    return rollouts


def _record(policy: Policy, inner: Any, seeds: Sequence[int]) -> list[Rollout]:
    """Episodes of an environment, side by side."""
    loop, rngs, observation = begin(inner.make_loop, seeds)
    everyone = np.ones(len(seeds), dtype=np.bool_)
    horizon, recorder, times = inner.config.horizon, Recorder(inner, loop), []
    shape = tuple(inner.action_space.shape)
    state, starts = None, everyone
    pauses = set(np.linspace(0, horizon - 1, _TIMED, dtype=int).tolist())
    with recorder.listening():
        for index in range(horizon):
            if index in pauses:
                times.append(time_one(policy, observation[0]) + inner_time(loop))
            output = policy.predict(observation, state, episode_start=starts, deterministic=True)
            action, state = check_output(policy, output, (len(seeds), *shape))
            step = loop.step(np.asarray(action, dtype=np.float64))
            observation, starts = step.observation, ~everyone
            if step.terminated.any():
                again = np.flatnonzero(step.terminated)
                observation, starts[again] = loop.reset(again, [rngs[row] for row in again], {}), True
    return [recorder.rollout(row, int(seed), np.array(times)) for row, seed in enumerate(seeds)]
