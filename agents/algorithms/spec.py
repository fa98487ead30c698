"""`AlgorithmSpec`: the declaration of a learning algorithm, and the registry of algorithms."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from prp_gym.agents.sb3.actors import ActorReader
from prp_gym.agents.sb3.arguments import NOISE_KEYS
from prp_gym.agents.sb3.packages import require
from prp_gym.agents.sb3.setting_kinds import SettingKind
from prp_gym.agents.sb3.settings import (
    NETWORK_SETTINGS,
    REPLAY_NETWORK_SETTINGS,
    REPLAY_SETTINGS,
    SETTINGS,
)
from prp_gym.checks import instance
from prp_gym.errors import UnknownNameError
from prp_gym.registry import NOT_IN_THE_REPORT, Registry

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm


@dataclass(frozen=True)
class AlgorithmEntry:
    """The code of an algorithm.

    Attributes:
        package: import name of the package that holds the algorithm's class, imported on first use.
        class_name: name of the class, which has the interface of Stable-Baselines3's `BaseAlgorithm`.
        read_actor: function that finds the layers of the actor in a trained model, for export.
    """

    package: str
    class_name: str
    read_actor: ActorReader


def _accept(settings: Mapping[str, Any], n_envs: int) -> None:
    """Accept settings that are within their bounds, however they are combined."""


@dataclass(frozen=True)
class RecipeScope:
    """What a recipe may set of an algorithm and of its policy network.

    These are the arguments of their constructors whose type and bounds are declared, for all algorithms in
    `prp_gym.agents.sb3.settings` and for one algorithm here; all others are refused.

    Attributes:
        policies: names of the policy networks that a recipe may choose and that can be exported.
        replay_buffer: whether the algorithm learns from a replay buffer; a recipe may then set
            `noise_type` and `noise_std`, the exploration noise on actions.
        excluded: names of constructor arguments that a recipe may not set.
        settings: type and bounds of further constructor arguments by name.
        policy_settings: type and bounds of further arguments of the policy network's constructor by name.
        check: function of a recipe's settings and of its number of environments, which raises
            `InvalidValueError` about settings that do not go together.
    """

    policies: tuple[str, ...] = ("MlpPolicy",)
    replay_buffer: bool = False
    excluded: frozenset[str] = frozenset()
    settings: Mapping[str, SettingKind] = field(default_factory=dict)
    policy_settings: Mapping[str, SettingKind] = field(default_factory=dict)
    check: Callable[[Mapping[str, Any], int], None] = _accept


@dataclass(frozen=True)
class AlgorithmSpec:
    """The declaration of a learning algorithm; it stands in the algorithm's file, beside its recipes.

    Attributes:
        name: name in recipes and on the command line, such as `ppo`.
        summary: one line for lists.
        entry: class of the library, and how the actor of a model is read.
        recipes: path of the YAML file with the recipes by environment id.
        scope: what a recipe may set.
        chapter: chapter of the report, for the order of lists.
        revision: number of the present behaviour; a change of what the algorithm learns raises it.
    """

    name: str
    summary: str
    entry: AlgorithmEntry
    recipes: Path
    scope: RecipeScope = RecipeScope()
    chapter: float = NOT_IN_THE_REPORT
    revision: int = 1

    def load_class(self) -> "type[BaseAlgorithm]":
        """The class of the algorithm.

        Raises:
            MissingPackageError: the package that holds it is not installed.
            UnknownNameError: the package has no class of this name.
        """
        package = require(self.entry.package)
        if not hasattr(package, self.entry.class_name):
            kind = f"class of package {self.entry.package!r}"
            raise UnknownNameError(kind, self.entry.class_name, [n for n in dir(package) if n[0].isupper()])
        found: type[BaseAlgorithm] = getattr(package, self.entry.class_name)
        return found

    def settings(self) -> dict[str, SettingKind]:
        """Type and bounds of the constructor's arguments that a recipe may set, by name."""
        scope = self.scope
        declared = {**(REPLAY_SETTINGS if scope.replay_buffer else SETTINGS), **scope.settings}
        arguments = {*inspect.signature(self.load_class().__init__).parameters, *NOISE_KEYS} - scope.excluded
        return {name: kind for name, kind in declared.items() if name in arguments}

    def policy_settings(self, policy: object) -> dict[str, SettingKind]:
        """Type and bounds of the arguments that a recipe may set of a policy network's constructor, by name.

        Args:
            policy: name of the policy network.

        Raises:
            UnknownNameError: a policy network that the declaration does not name.
        """
        if policy not in self.scope.policies:
            raise UnknownNameError("policy", policy, self.scope.policies)
        declared = REPLAY_NETWORK_SETTINGS if self.scope.replay_buffer else NETWORK_SETTINGS
        network = self.load_class().policy_aliases[str(policy)]
        arguments = inspect.signature(network.__init__).parameters
        return {
            name: kind
            for name, kind in {**declared, **self.scope.policy_settings}.items()
            if name in arguments
        }


ALGORITHMS: Registry[AlgorithmSpec] = Registry("algorithm", "prp_gym.agents.algorithms")
"""The declared learning algorithms by their names."""


def register_algorithm(spec: AlgorithmSpec) -> AlgorithmSpec:
    """Declare a learning algorithm, of this package or of another one.

    Args:
        spec: the declaration.

    Returns:
        the declaration.

    Raises:
        InvalidValueError: a name that is taken or that cannot be the name of a file; a revision below 1.
    """
    return ALGORITHMS.register(instance("algorithm", spec, AlgorithmSpec))
