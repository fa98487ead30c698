"""Learning presets: ids under which tasks are made as stock learning algorithms can use them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from prp_gym.tasks.spec import TASKS, TaskSpec

LEARNING_KEYWORDS: Mapping[str, Any] = MappingProxyType({"observation": "errors", "control_frequency": 50.0})
"""Keywords of the learning presets: errors of order 1 as observation, at a control frequency [Hz]."""

_ID = re.compile(r"(?P<name>.+?)(?P<version>-v\d+)?", re.DOTALL)
_LEARNING_ID = re.compile(r"(?P<name>.+)-RL(?P<version>-v\d+)?", re.DOTALL)


def learning_id(task_id: str) -> str:
    """The id of a task's learning preset: `PRP-Force-v0` has `PRP-Force-RL-v0`."""
    found = _ID.fullmatch(task_id)
    return f"{found['name']}-RL{found['version'] or ''}" if found else task_id


@dataclass(frozen=True)
class Preset:
    """What an environment id stands for: a task, and the keywords that the id sets.

    Attributes:
        task: Declaration of the task.
        keywords: Keywords that the id sets, in place of the defaults; none for the id of a task itself.
    """

    task: TaskSpec
    keywords: Mapping[str, Any] = field(default_factory=dict)

    def complete(self, keywords: Mapping[str, Any]) -> dict[str, Any]:
        """All keywords of an environment that was made with the given ones."""
        return {**self.keywords, **keywords}


def find_preset(environment_id: object) -> Preset:
    """What an environment id stands for.

    Args:
        environment_id: Id of a task or of its learning preset.

    Raises:
        UnknownNameError: neither of them.
    """
    if isinstance(environment_id, str) and environment_id not in TASKS:
        found = _LEARNING_ID.fullmatch(environment_id)
        task_id = f"{found['name']}{found['version'] or ''}" if found else environment_id
        if task_id in TASKS:
            return Preset(TASKS[task_id], LEARNING_KEYWORDS)
    return Preset(TASKS.find(environment_id))
