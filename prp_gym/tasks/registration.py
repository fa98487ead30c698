"""Registration of tasks and of their learning presets, here and with Gymnasium."""

import pkgutil
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium

from prp_gym.checks import instance
from prp_gym.tasks.presets import LEARNING_KEYWORDS, learning_id
from prp_gym.tasks.spec import TASKS, TaskSpec

_ENTRY_POINT = "prp_gym.envs.environment:PRPEnv"
_VECTOR_ENTRY_POINT = "prp_gym.envs.vector:PRPVectorEnv"


def register_task(spec: TaskSpec) -> TaskSpec:
    """Declare a task, which makes it an environment of Gymnasium, with a learning preset.

    Args:
        spec: Declaration, in this package or in another one.

    Returns:
        The declaration.

    Raises:
        InvalidValueError: an id that is taken or not allowed as a name, or a revision below 1.
    """
    TASKS.register(instance("task", spec, TaskSpec))
    _register_id(spec.id)
    return spec


def list_envs() -> list[str]:
    """The ids of all tasks: those of the suite, and of tasks registered by other packages.

    Every task has a learning preset beside, `PRP-<Task>-RL-v0`, which is not listed.
    """
    return list(TASKS)


def register_environments() -> None:
    """Make the suite's ids known to Gymnasium without importing a task; done by `import prp_gym`.

    The id of a task follows from the name of its file: `force_position` is `PRP-ForcePosition-v0`.
    """
    package = find_spec("prp_gym.envs")
    for folder in (package.submodule_search_locations if package is not None else None) or []:
        for module in pkgutil.iter_modules([str(Path(folder) / "tasks")]):
            _register_id(f"PRP-{module.name.title().replace('_', '')}-v0")


def _register_id(task_id: str) -> None:
    """Make a task and its learning preset known to Gymnasium."""
    presets: dict[str, Mapping[str, Any]] = {task_id: {}, learning_id(task_id): LEARNING_KEYWORDS}
    for environment_id, keywords in presets.items():
        if environment_id not in gymnasium.registry:
            gymnasium.register(
                environment_id,
                entry_point=_ENTRY_POINT,
                vector_entry_point=_VECTOR_ENTRY_POINT,
                kwargs={"task": task_id, **keywords},
                order_enforce=False,  # the environments raise their own error
            )
