"""What tuning may change of a controller: factors on its settings, declared in the controller's data.

A table `[search.<name>]` of a controller's TOML file is a parameter: a factor on the controller's `tuned`
settings, 1 at the start and searched on a logarithmic scale within `range`. The settings in `powers` are
multiplied by the factor raised to these powers. So a bandwidth ω and a damping ratio ζ are K_P ~ ω²,
K_D ~ ζω, and with a target inertia M that keeps both, K_P ~ M ω², K_D ~ M ζω. A setting that is a vector
names what it has components `of`; then there is one parameter for every group of components (each joint;
translation and rotation; inertia, viscous and Coulomb friction, or each parameter of the link), or for those
in `groups` alone. A search widens the range of a factor where its best candidate lies at the edge, unless
that end is a physical limit or one of stability, whose reason stands in `limit_low` or `limit_high`.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from types import EllipsisType
from typing import Any

import numpy as np

from prp_gym.baselines.base.settings import Settings
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.errors import InvalidValueError

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
"""Components of a vector that share a parameter, by the vector's quantity and length."""

DEFAULT_RANGE = (0.1, 10.0)
"""Range of the factor on each vector setting of a controller that declares no search space [1]."""

_Components = slice | EllipsisType


@dataclass(frozen=True)
class Parameter:
    """A factor on some of a controller's settings; 1 leaves them as they are.

    Attributes:
        name: name of the parameter.
        low: smallest factor, above 0 [1].
        high: largest factor [1].
        powers: exponents of the factor, by the names of the settings that the powers multiply.
        components: indices of the components that are multiplied in settings that are vectors.
        limits: reasons for which the smallest and the largest factor are limits; empty for an end that a
            search may move.
    """

    name: str
    low: float
    high: float
    powers: Mapping[str, float]
    components: _Components
    limits: tuple[str, str] = ("", "")


@dataclass(frozen=True, eq=False)
class SearchSpace:
    """The settings over which a search runs, around those of a controller.

    Attributes:
        centre: the controller's settings where every factor is 1, vectors at their full length.
        parameters: parameters of the search, one factor each.
    """

    centre: Settings
    parameters: tuple[Parameter, ...]

    @classmethod
    def of(cls, controller: ControllerSpec, centre: Settings) -> "SearchSpace":
        """The space that a controller declares, or a factor on each of its vector settings.

        Args:
            controller: declaration of the controller.
            centre: settings of one of its policies.

        Raises:
            InvalidValueError: a declared parameter that does not fit the settings.
            GainsFileError: a data file that cannot be read.
        """
        rows = controller.data.search or {
            name: {"range": DEFAULT_RANGE, "powers": {name: 1}} for name in centre.vectors
        }
        parameters = (item for name, row in rows.items() for item in _expand(name, row, centre))
        return cls(centre, tuple(item for item in parameters if _matters(item, centre)))

    @property
    def start(self) -> dict[str, float]:
        """The factors that give the centre."""
        return {parameter.name: 1.0 for parameter in self.parameters}

    def settings(self, factors: Mapping[str, float]) -> dict[str, Any]:
        """All of a controller's settings but its model.

        Args:
            factors: factors by the names of the parameters.

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


def _matters(parameter: Parameter, settings: Settings) -> bool:
    """Whether a factor changes anything: settings of 0, such as an absent integral action, stay 0."""
    return any(np.any(getattr(settings, name)) for name in parameter.powers)


def _expand(name: str, row: Mapping[str, Any], settings: Settings) -> Iterator[Parameter]:
    """The parameters that a row of the data file stands for.

    Raises:
        InvalidValueError: a row that does not fit the settings.
    """
    low, high = _range(name, row.get("range"))
    powers = _powers(name, row.get("powers"), settings)
    limits = (_limit(name, row, "limit_low"), _limit(name, row, "limit_high"))
    if "of" not in row:
        yield Parameter(name, low, high, powers, ..., limits)
        return
    groups = _groups(name, str(row["of"]), np.size(getattr(settings, next(iter(powers)))))
    for group in row.get("groups", groups):
        if group not in groups:
            raise InvalidValueError(f"group of search parameter {name!r}", group, ", ".join(groups))
        yield Parameter(f"{name}_{group}", low, high, powers, groups[group], limits)


def _range(name: str, given: Any) -> tuple[float, float]:
    """The smallest and the largest factor."""
    try:
        low, high = (float(value) for value in given)
    except (TypeError, ValueError):
        low = high = math.nan
    if not 0.0 < low <= 1.0 <= high < math.inf:
        raise InvalidValueError(f"range of search parameter {name!r}", given, "[low, high] around 1, above 0")
    return low, high


def _limit(name: str, row: Mapping[str, Any], key: str) -> str:
    """The reason for which an end of the range is a limit; empty where it is none."""
    reason = row.get(key, "")
    if not isinstance(reason, str) or (key in row and not reason.strip()):
        raise InvalidValueError(f"{key} of search parameter {name!r}", reason, "the reason, as text")
    return reason


def _powers(name: str, given: Any, settings: Settings) -> Mapping[str, float]:
    """The powers of the factor, by the settings that they multiply."""
    known = (*settings.vectors, *settings.numbers)
    if not isinstance(given, Mapping) or not given or not set(given) <= set(known):
        allowed = f"numbers by names of settings, of {', '.join(known)}"
        raise InvalidValueError(f"powers of search parameter {name!r}", given, allowed)
    return given


def _groups(name: str, of: str, size: int) -> Mapping[str, slice]:
    """The groups of components of a vector setting."""
    if (of, size) not in GROUPS:
        allowed = " or ".join(f"{kind!r} of {count}" for kind, count in GROUPS)
        raise InvalidValueError(f"components of search parameter {name!r}", (of, size), allowed)
    return GROUPS[of, size]
