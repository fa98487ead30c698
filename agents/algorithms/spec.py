"""`AlgorithmSpec`: the declaration of a learning algorithm, and the registry of algorithms."""

import inspect
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from prp_gym.agents.sb3.actors import ActorReader
from prp_gym.agents.sb3.arguments import NOISE_KEYS
from prp_gym.agents.sb3.packages import require
from prp_gym.checks import instance
from prp_gym.errors import UnknownNameError
from prp_gym.registry import NOT_IN_THE_REPORT, Registry

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

_SET_BY_TRAINING = frozenset(
    (
        *("self", "policy", "env", "policy_kwargs", "seed", "verbose", "tensorboard_log", "device"),
        *("_init_setup_model", "action_noise", "optimize_memory_usage", "replay_buffer_class"),
        *("replay_buffer_kwargs", "rollout_buffer_class", "rollout_buffer_kwargs"),
        *("use_sde", "sde_sample_freq", "use_sde_at_warmup"),
    )
)
"""Constructor arguments that training sets, that take no plain value, or that prevent an export."""

_POLICY_SET_BY_TRAINING = frozenset(
    (
        *("self", "observation_space", "action_space", "lr_schedule", "features_extractor_class"),
        *("features_extractor_kwargs", "normalize_images", "optimizer_class", "optimizer_kwargs"),
        *("use_sde", "squash_output", "full_std", "use_expln", "clip_mean", "args", "kwargs"),
    )
)


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


@dataclass(frozen=True)
class RecipeScope:
    """What a recipe may set of an algorithm, beside the plain arguments of its constructor.

    Attributes:
        policies: names of the policy networks that a recipe may choose and that can be exported.
        replay_buffer: whether the algorithm learns from a replay buffer; a recipe may then set
            `noise_type` and `noise_std`, the exploration noise on actions.
        excluded: names of constructor arguments that a recipe may not set, beside those that training sets.
    """

    policies: tuple[str, ...] = ("MlpPolicy",)
    replay_buffer: bool = False
    excluded: frozenset[str] = frozenset()


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

    def setting_names(self) -> frozenset[str]:
        """Names of the constructor's arguments that a recipe may set."""
        arguments = set(inspect.signature(self.load_class().__init__).parameters)
        noise = set(NOISE_KEYS) if self.scope.replay_buffer else set()
        return frozenset((arguments - _SET_BY_TRAINING - self.scope.excluded) | noise)

    def policy_setting_names(self, policy: object) -> frozenset[str]:
        """Names of the arguments that a recipe may set of a policy network's constructor.

        Args:
            policy: name of the policy network.

        Raises:
            UnknownNameError: a policy network that the declaration does not name.
        """
        if policy not in self.scope.policies:
            raise UnknownNameError("policy", policy, self.scope.policies)
        network = self.load_class().policy_aliases[str(policy)]
        return frozenset(set(inspect.signature(network.__init__).parameters) - _POLICY_SET_BY_TRAINING)


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
