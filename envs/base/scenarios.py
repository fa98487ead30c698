"""The scenarios, read from the data file beside this module."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from prp_gym.checks import choice
from prp_gym.tasks.scenario import Scenario


@cache
def _tables() -> dict[str, Any]:
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def load_scenario(name: str) -> Scenario:
    """Load a scenario by its name.

    Raises:
        UnknownNameError: a scenario that does not exist.
    """
    tables = _tables()
    choice("scenario", name, tables)
    return Scenario.from_table(name, tables[name])
