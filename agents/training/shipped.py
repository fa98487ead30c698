"""The agents that are shipped with the package: groups of training seeds, listed in `shipped.yml`."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from prp_gym.agents.sb3.packages import require
from prp_gym.agents.training.recipes import SEEDS, Recipe, load_recipe
from prp_gym.errors import DataFileError, InvalidValueError, shortened
from prp_gym.files.file_reader import FileReader
from prp_gym.files.typed_reader import TypedReader

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
        InvalidValueError: no training seed, or too many.
    """

    environment: str
    algorithm: str
    action_mode: str
    seeds: int

    def __post_init__(self) -> None:
        if not 1 <= self.seeds <= SEEDS:
            raise InvalidValueError("seeds of a group", self.seeds, f"a whole number, 1 to {SEEDS}")

    def recipe(self, config: Path | None = None, overrides: Iterable[str] = ()) -> Recipe:
        """The recipe that trains the agents; see `load_recipe`."""
        return load_recipe(self.algorithm, self.environment, self.action_mode, config, overrides)


def read_groups(manifest: Path | None = None) -> tuple[ShippedGroup, ...]:
    """The groups of agents in a list.

    Args:
        manifest: path of the list, a YAML file; None for the list of the package.

    Raises:
        DataFileError: a file that cannot be read or lists no group, or an entry that is not a group.
        InvalidValueError: a group that is listed twice.
        MissingPackageError: a package for learning is not installed.
    """
    require("yaml")
    path = manifest or _LIST
    content = FileReader().read_yaml(path)
    if not isinstance(content, list) or not content:
        raise DataFileError(path, f"holds {shortened(content)}; expected a list of groups of agents")
    reader = TypedReader(path)
    groups = tuple(reader.read(ShippedGroup, entry, f"[{n}]") for n, entry in enumerate(content))
    kinds = [(group.environment, group.algorithm, group.action_mode) for group in groups]
    for kind in kinds:
        if kinds.count(kind) > 1:
            raise InvalidValueError(f"group in {path.name}", kind, "one that is listed once")
    return groups


def default_action_mode(environment_id: str, config: Path | None = None) -> str | None:
    """The action mode in which agents are trained unless another one is chosen.

    It is the mode of the first group of shipped agents of the environment. None stands for the mode that the
    recipe names: where no agents are shipped, or the recipes are a user's.

    Args:
        environment_id: id of the environment.
        config: path of a user's recipe file; None for the recipes of the package.
    """
    if config is not None:
        return None
    modes = (group.action_mode for group in read_groups() if group.environment == environment_id)
    return next(modes, None)
