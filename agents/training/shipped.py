"""The agents that are shipped with the package: groups of training seeds, listed in `shipped.yml`."""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from prp_gym.agents.sb3.packages import require
from prp_gym.agents.training.recipes import SEEDS, Recipe, load_recipe
from prp_gym.errors import InvalidValueError, UnknownNameError

_LIST = Path(__file__).with_name("shipped.yml")


@dataclass(frozen=True)
class ShippedGroup:
    """Agents that differ in their training seed only.

    Attributes:
        environment: id of the environment.
        algorithm: name of the algorithm that trains the agents.
        action_mode: name of the agents' action mode.
        seeds: number of training seeds, which are 0, 1, ...

    Raises:
        InvalidValueError: a value of another type, no training seed, or too many.
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
        """The recipe that trains the agents; see `load_recipe`."""
        return load_recipe(self.algorithm, self.environment, self.action_mode, config, overrides)


def read_groups(manifest: Path | None = None) -> tuple[ShippedGroup, ...]:
    """The groups of agents in a list.

    Args:
        manifest: path of the list, a YAML file; None for the list of the package.

    Raises:
        InvalidValueError: a file that cannot be read or lists no group, an entry that is not a group, or a
            group that is listed twice.
        UnknownNameError: a key that a group does not have.
        MissingPackageError: a package for learning is not installed.
    """
    yaml = require("yaml")
    where = str(manifest or _LIST.name)
    try:
        content = yaml.safe_load((manifest or _LIST).read_text(encoding="utf-8"))
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
