"""`KeywordSpace`: the search space of a user's class with `predict`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.tuning.search_space import Parameter

_RANGE = (0.1, 10.0)


@dataclass(frozen=True, eq=False)
class KeywordSpace:
    """A factor from 0.1 to 10 on each keyword argument that is a number or several.

    Attributes:
        centre: keyword arguments where every factor is 1.
    """

    centre: Mapping[str, Any]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The factors.

        Raises:
            InvalidValueError: there are none.
        """
        names = [name for name, value in self.centre.items() if _is_numeric(value)]
        if not names:
            allowed = "at least one keyword argument whose default is a number or several"
            raise InvalidValueError("settings to tune", sorted(self.centre), allowed)
        return tuple(Parameter(name, *_RANGE, {name: 1.0}, slice(None)) for name in names)

    @property
    def start(self) -> dict[str, float]:
        """The factors that give the centre."""
        return {parameter.name: 1.0 for parameter in self.parameters}

    def settings(self, factors: Mapping[str, float]) -> dict[str, Any]:
        """All keyword arguments.

        Args:
            factors: factors by the names of the parameters.

        Returns:
            values by name, as the class takes them.
        """
        return {
            name: _scaled(value, factors[name]) if name in factors else value
            for name, value in self.centre.items()
        }


def _is_numeric(value: Any) -> bool:
    """Whether a value is a number, or several."""
    if isinstance(value, bool):
        return False
    if isinstance(value, (list, tuple)):
        return bool(value) and all(_is_numeric(item) for item in value)
    return isinstance(value, (int, float, np.number)) or (
        isinstance(value, np.ndarray) and np.issubdtype(value.dtype, np.number)
    )


def _scaled(value: Any, factor: float) -> Any:
    """A number, or several, times a factor; a sequence keeps its type."""
    if isinstance(value, (list, tuple)):
        return type(value)(_scaled(item, factor) for item in value)
    return value * factor
