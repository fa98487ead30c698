"""What the parts of a task are made from: the numbers of its data file, its scenario, keywords and period."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from prp_gym.files.file_reader import FileReader
from prp_gym.tasks.ranges import Range
from prp_gym.tasks.reward import RewardTerm
from prp_gym.tasks.scenario import Scenario


@dataclass(frozen=True)
class TaskNumbers:
    """The numbers of a task, read from its data file.

    Attributes:
        reward: Terms of the reward.
        ranges: Ranges from which starts and goals are drawn, by name of a kind of draws (`report`,
            `randomized`).
        constants: Other numbers by name, with their units in the data file.
    """

    reward: tuple[RewardTerm, ...]
    ranges: Mapping[str, Mapping[str, Range]]
    constants: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path) -> "TaskNumbers":
        """Read a TOML file: tables `reward` and `constants`, and one for each kind of draws.

        Raises:
            DataFileError: a file that cannot be read, or that is not TOML.
        """
        table = _read_table(path)
        reward = tuple(RewardTerm.from_table(name, row) for name, row in table["reward"].items())
        ranges = {
            kind: {name: Range.from_table(row) for name, row in rows.items()}
            for kind, rows in table.items()
            if kind not in ("reward", "constants")
        }
        return cls(reward, ranges, table.get("constants", {}))


@cache
def _read_table(path: Path) -> dict[str, Any]:
    return FileReader().read_toml(path)


MUJOCO, COMPILED = "mujoco", "compiled"
ENGINES = (MUJOCO, COMPILED)
"""What simulates a world: MuJoCo, or its steps in closed form, in code compiled from the formulas."""


@dataclass(frozen=True)
class TaskSetup:
    """The inputs from which the parts of a task are made.

    Attributes:
        numbers: Numbers of the task's data file.
        scenario: Conditions of the episodes.
        options: The task's own keywords.
        period: Control period [s].
        engine: What simulates the world, one of `ENGINES`.
    """

    numbers: TaskNumbers
    scenario: Scenario
    options: Any
    period: float
    engine: str = MUJOCO

    @property
    def ranges(self) -> Mapping[str, Range]:
        """The ranges from which this scenario draws."""
        return self.numbers.ranges[self.scenario.draws]
