"""What tuning may change of a law: factors on its settings, declared in the baselines' data."""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from prp_gym.baselines import Baseline, Settings
from prp_gym.errors import UnknownNameError

GROUPS: Mapping[tuple[str, int], Mapping[str, slice]] = {
    ("joint", 1): {"joint_1": slice(0, 1)},
    ("joint", 3): {f"joint_{index + 1}": slice(index, index + 1) for index in range(3)},
    ("pose", 6): {"translation": slice(0, 3), "rotation": slice(3, 6)},
    ("parameter", 3): {
        "inertia": slice(0, 1),
        "viscous_friction": slice(1, 2),
        "gravity_moment": slice(2, 3),
    },
    ("parameter", 12): {
        "inertia": slice(0, 6),
        "viscous_friction": slice(6, 9),
        "coulomb_friction": slice(9, 12),
    },
}
"""Components of a vector that share a parameter, by what the vector is of and by its length."""

_EVERYTHING = slice(None)


@dataclass(frozen=True)
class Parameter:
    """A factor on some of a law's settings; 1 leaves them as they are.

    Attributes:
        name: of the parameter.
        low: least factor, above 0 [1].
        high: largest factor [1].
        powers: of the factor, by the settings that they multiply.
        components: of these settings, where they are vectors.
    """

    name: str
    low: float
    high: float
    powers: Mapping[str, float]
    components: slice


@dataclass(frozen=True, eq=False)
class SearchSpace:
    """The settings that a law may be given, around those that it has.

    Attributes:
        centre: the law's settings where every factor is 1, vectors at their full length.
        parameters: the factors.
    """

    centre: Settings
    parameters: tuple[Parameter, ...]

    @classmethod
    def of(cls, policy: Baseline[Any]) -> "SearchSpace":
        """The space that the data file declares for a law, around the settings of a policy.

        Raises:
            UnknownNameError: a law for which none is declared.
        """
        table = _table()
        if policy.name not in table:
            raise UnknownNameError("law with a search space", policy.name, table)
        rows = table[policy.name].items()
        parameters = (parameter for name, row in rows for parameter in _expand(name, row, policy.settings))
        return cls(policy.settings, tuple(parameters))

    @property
    def start(self) -> dict[str, float]:
        """The factors that give the centre."""
        return {parameter.name: 1.0 for parameter in self.parameters}

    def settings(self, factors: Mapping[str, float]) -> dict[str, Any]:
        """All of a law's settings but its model.

        Args:
            factors: by the parameters' names.

        Returns:
            values by name, as `make_baseline` takes them.
        """
        names = [entry.name for entry in fields(self.centre) if entry.name != "model"]
        values = {name: getattr(self.centre, name) for name in names}
        for name in self.centre.vectors:
            values[name] = np.array(values[name])
        for parameter in self.parameters:
            for name, power in parameter.powers.items():
                scale = factors[parameter.name] ** power
                if name in self.centre.vectors:
                    values[name][parameter.components] *= scale
                else:
                    values[name] *= scale
        return values


@cache
def _table() -> dict[str, Any]:
    text = files("prp_gym.baselines").joinpath("search_spaces.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def _expand(name: str, row: Mapping[str, Any], settings: Settings) -> Iterator[Parameter]:
    """The parameters that a row of the data file stands for."""
    low, high = row["range"]
    if "of" not in row:
        yield Parameter(name, low, high, row["powers"], _EVERYTHING)
        return
    size = len(getattr(settings, next(iter(row["powers"]))))
    groups = GROUPS[row["of"], size]
    for group in row.get("groups", groups):
        yield Parameter(f"{name}_{group}", low, high, row["powers"], groups[group])
