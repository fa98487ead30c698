"""The Gymnasium environments: one single and one vectorised class for all tasks."""

from typing import Any

from prp_gym.envs.config import EnvConfig
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.saved_state import EnvState, VectorState
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.envs.view import EnvironmentView

__all__ = [
    "EnvConfig",
    "EnvState",
    "EnvironmentView",
    "EpisodeLoop",
    "PRPEnv",
    "PRPVectorEnv",
    "VectorState",
]


def __getattr__(name: str) -> Any:
    """Names of 0.1 that are deprecated."""
    from prp_gym.envs.former_names import find_former_name

    return find_former_name(name)
