"""Which agents come with the package: groups of training seeds, by `hyperparameters/shipped.yml`."""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import Any

from prp_gym.agents.sb3.algorithms import require
from prp_gym.agents.training.recipes import SEEDS, Recipe, load_recipe
from prp_gym.errors import InvalidValueError, UnknownNameError


@dataclass(frozen=True)
class ShippedGroup:
    """Agents that differ in their training seed alone.

    Attributes:
        environment: id of this suite.
        algorithm: that trains them.
        action_mode: what their actions mean.
        seeds: how many; they are 0, 1, ...

    Raises:
        InvalidValueError: a value of another type, no seed or too many.
    """

    environment: str
    algorithm: str
    action_mode: str
    seeds: int

    def __post_init__(self) -> None:
        for name in ("environment", "algorithm", "action_mode"):
            if not isinstance(getattr(self, name), str):
                raise InvalidValueError(f"{name} of a group", getattr(self, name), "a text")
        if type(self.seeds) is not int or not 1 <= self.seeds <= SEEDS:
            raise InvalidValueError("seeds of a group", self.seeds, f"a whole number, 1 to {SEEDS}")

    def recipe(self, config: Path | None = None, overrides: Iterable[str] = ()) -> Recipe:
        """How they are trained; see `load_recipe`."""
        return load_recipe(self.algorithm, self.environment, self.action_mode, config, overrides)


def read_groups(manifest: Path | None = None) -> tuple[ShippedGroup, ...]:
    """The groups of a list.

    Args:
        manifest: the list, a file in YAML; None for the one that comes with the suite.

    Raises:
        InvalidValueError: a file that cannot be read or lists no group, an entry that is none, or one twice.
        UnknownNameError: a key that a group does not have.
        MissingPackageError: a package for learning is not installed.
    """
    yaml = require("yaml")
    built_in = files("prp_gym.agents") / "hyperparameters" / "shipped.yml"
    where = str(manifest or "shipped.yml")
    try:
        content = yaml.safe_load((manifest or built_in).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InvalidValueError("manifest", where, f"a readable file in YAML ({error})") from error
    if not isinstance(content, list) or not content:
        raise InvalidValueError(f"content of {where}", content, "a list of groups of agents")
    groups = tuple(_group(entry, where) for entry in content)
    kinds = [(group.environment, group.algorithm, group.action_mode) for group in groups]
    for kind in kinds:
        if kinds.count(kind) > 1:
            raise InvalidValueError(f"group in {where}", kind, "one that is listed once")
    return groups


def _group(entry: Any, where: str) -> ShippedGroup:
    names = [field.name for field in fields(ShippedGroup)]
    if not isinstance(entry, dict) or not set(names) <= set(entry):
        raise InvalidValueError(f"group in {where}", entry, f"{', '.join(names)} with their values")
    for key in entry:
        if key not in names:
            raise UnknownNameError(f"key of a group in {where}", key, names)
    return ShippedGroup(**entry)
