"""`make_sb3_vec_env`: environments by their id, ready for Stable-Baselines3."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

import gymnasium
from gymnasium.envs.registration import load_env_creator
from gymnasium.vector import AutoresetMode

from prp_gym.agents.sb3.packages import require
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.errors import InvalidValueError

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv

_FIXED = ("autoreset_mode", "num_envs", "vector_kwargs", "vectorization_mode", "wrappers")
"""Keywords of `gymnasium.make_vec` that Stable-Baselines3's interface fixes."""


def make_sb3_vec_env(
    env_id: str, n_envs: int = 1, seed: int | None = None, num_threads: int = 0, **env_keywords: Any
) -> "VecEnv":
    """Environments stepped together on MuJoCo's native threads, for Stable-Baselines3's algorithms.

    It replaces Stable-Baselines3's own `make_vec_env`; episode statistics come from its `VecMonitor`.

    Args:
        env_id: id of an environment of this suite, or `module:id`, as Gymnasium understands it.
        n_envs: number N of environments.
        seed: the first episode of environment i has the seed `seed + i`, and the action space `seed`;
            None draws seeds from numpy's global generator, as Stable-Baselines3 does.
        num_threads: number of threads that step the physics; 0 takes all cores.
        env_keywords: keywords of the single environment; they are the same for every environment.

    Returns:
        `SB3VecEnv` within `VecMonitor`.

    Raises:
        MissingPackageError: Stable-Baselines3 is not installed.
        InvalidValueError: an environment of another suite; a keyword about how environments are vectorised.
        PRPError: a keyword that does not exist or a value that is not allowed.
    """
    require()
    from stable_baselines3.common.vec_env import VecMonitor

    from prp_gym.agents.sb3.vec_env import SB3VecEnv

    for name in _FIXED:
        if name in env_keywords:
            raise InvalidValueError(name, env_keywords[name], "nothing; Stable-Baselines3 leaves no choice")
    if not _is_ours(env_id):
        raise InvalidValueError("env_id", env_id, "an environment of prp_gym; see prp_gym.list_envs()")
    together = gymnasium.make_vec(
        env_id, n_envs, num_threads=num_threads, autoreset_mode=AutoresetMode.SAME_STEP, **env_keywords
    )
    vec_env = VecMonitor(SB3VecEnv(cast(PRPVectorEnv, together)))
    if seed is not None:
        vec_env.action_space.seed(seed)
    vec_env.seed(seed)
    return vec_env


def _is_ours(env_id: str) -> bool:
    """Whether Gymnasium makes vector environments of this suite for an id, also for one of a plugin."""
    module, _, name = env_id.rpartition(":")
    if module:  # the caller's module, which registers the id
        import_module(module)
    entry = gymnasium.spec(name).vector_entry_point
    made_by = load_env_creator(entry) if isinstance(entry, str) else entry
    return isinstance(made_by, type) and issubclass(made_by, PRPVectorEnv)
