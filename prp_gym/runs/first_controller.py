"""`first_controller`: the controller of an environment where a command is given none."""

from contextlib import closing

import gymnasium

from prp_gym.baselines import CONTROLLERS, list_baselines
from prp_gym.tasks.presets import find_preset


def first_controller(environment_id: str) -> str:
    """The first controller that is meant for an environment, or else the first that runs on it.

    Args:
        environment_id: id of a task or of its learning preset.
    """
    task = find_preset(environment_id).task.id
    for name, spec in CONTROLLERS.items():
        if task in spec.data.intended:
            return name
    with closing(gymnasium.make(task)) as env:
        return list_baselines(env.get_wrapper_attr("observation_layout"))[0]
