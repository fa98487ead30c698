"""The episode loop for the keywords of an environment."""

from collections.abc import Callable

from prp_gym.envs.action_mode import TORQUE, ModeSetup, make_action_mode
from prp_gym.envs.config import EnvConfig
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.core.mode_loop import ModeLoop
from prp_gym.tasks.task import Task

TaskMaker = Callable[[EnvConfig], Task]


def make_loop(make_task: TaskMaker, config: EnvConfig, num_envs: int, num_threads: int) -> EpisodeLoop:
    """Make the loop of N environments of a task, in the action mode of the keywords.

    Args:
        make_task: Makes the task at the control frequency of given keywords.
        config: Common keywords.
        num_envs: Number of environments N.
        num_threads: Number of threads of the physics; 0 takes all cores.

    Raises:
        PRPError: a mode that does not exist, or that reads observation fields that the task does not have;
            a task without the fields from which errors are computed.
    """
    inner = config.inner
    task = make_task(inner)
    if config.action_mode == TORQUE:
        return EpisodeLoop(task, inner, num_envs, num_threads)
    limit = config.limits(task.model.parameters.torque_limit)
    mode = make_action_mode(config.action_mode, ModeSetup(task, limit, 1.0 / inner.control_frequency))
    return ModeLoop(task, inner, mode, config.periods, num_envs, num_threads)
