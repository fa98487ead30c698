"""The laws' gains, read from the data file beside this module."""

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from functools import cache
from importlib.resources import files
from typing import Any

from prp_gym.errors import UnknownNameError


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads(files("prp_gym.baselines").joinpath("gains.toml").read_text(encoding="utf-8"))


def gain_sets(controller: str) -> tuple[str, ...]:
    """Names of a law's gain sets."""
    return tuple(_table().get(controller, {}))


def load_gains(controller: str, name: str, environment_id: str) -> dict[str, Any]:
    """A gain set of a law on an environment.

    Args:
        controller: its name.
        name: of the set.
        environment_id: whose own values, where it has some, replace the set's.

    Returns:
        settings by name, with the set's `source`.

    Raises:
        UnknownNameError: no such set.
    """
    sets = _table().get(controller, {})
    if name not in sets:
        raise UnknownNameError(f"gain set of law {controller!r}", name, sets)
    shared: Mapping[str, Any] = sets[name]
    own: dict[str, Any] = shared.get(environment_id, {})
    return deepcopy({key: value for key, value in shared.items() if not isinstance(value, dict)} | own)
