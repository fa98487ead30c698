"""The tasks' and scenarios' numbers, read from the data files beside this module."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any

from prp_gym.errors import UnknownNameError
from prp_gym.tasks.reward import RewardTerm
from prp_gym.tasks.scenario import Range, Scenario
from prp_gym.tasks.task import TaskNumbers


@cache
def _table(name: str) -> dict[str, Any]:
    return tomllib.loads(files("prp_gym.envs").joinpath(name).read_text(encoding="utf-8"))


def load_scenario(name: str) -> Scenario:
    """A scenario by name.

    Raises:
        UnknownNameError: no such scenario.
    """
    table = _table("scenarios.toml")
    if not isinstance(name, str) or name not in table:
        raise UnknownNameError("scenario", name, table)
    return Scenario.from_table(name, table[name])


def load_task_numbers(environment_id: str) -> TaskNumbers:
    """The reward terms, draw ranges and constants of a task."""
    table = _table("tasks.toml")[environment_id]
    reward = tuple(RewardTerm.from_table(name, row) for name, row in table["reward"].items())
    ranges = {
        kind: {name: Range.from_table(row) for name, row in rows.items()}
        for kind, rows in table.items()
        if kind not in ("reward", "constants")
    }
    return TaskNumbers(reward, ranges, table.get("constants", {}))
