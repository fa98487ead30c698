"""`Recipe`: how an agent is trained, merged from the entries of an algorithm's recipe file."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from prp_gym.agents.algorithms import ALGORITHMS, AlgorithmSpec
from prp_gym.agents.policy.environments import check_environment
from prp_gym.agents.sb3.packages import require
from prp_gym.agents.sb3.settings import ENVIRONMENTS, TIMESTEPS
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import DataTextError, InvalidValueError, UnknownNameError
from prp_gym.files.file_reader import FileReader
from prp_gym.files.limits import DEPTH
from prp_gym.files.yaml_text import parse_yaml
from prp_gym.tasks.presets import find_preset, learning_id
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.setup import MUJOCO

_COMMON = frozenset(("n_timesteps", "n_envs", "policy", "policy_kwargs", "normalize", "env_kwargs"))
_MODES = "action_modes"
_DEFAULT = "default"
_NORMALIZED = ("obs", "reward")
_EXPONENT = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?[eE][+-]?[0-9]+")

EPISODES_A_SEED = 1_000_000
"""Number of episode seeds of one training seed; those of training seed k start at (k + 1) times it."""

FIRST_HELD_OUT_SEED = 500_000_000
"""Seed of the first held-out episode; the following episodes have the following seeds."""

SEEDS = FIRST_HELD_OUT_SEED // EPISODES_A_SEED - 1
"""Number of training seeds that have no held-out episode among their own."""


@dataclass(frozen=True)
class Recipe:
    """How an agent is trained.

    Attributes:
        algorithm: name of a declared algorithm.
        environment_id: id of the environment.
        n_timesteps: number of training steps, summed over the parallel environments.
        n_envs: number of parallel environments.
        policy: name of the policy network, such as `MlpPolicy`.
        normalize: whether `obs` and `reward` are normalised by running statistics.
        env_kwargs: keywords of the environment, `action_mode` among them.
        settings: arguments of the algorithm's constructor, `policy_kwargs` among them, as plain values.

    Raises:
        UnknownNameError: an environment that is not registered, or a keyword that it does not declare.
    """

    algorithm: str
    environment_id: str
    n_timesteps: int
    n_envs: int
    policy: str
    normalize: Mapping[str, bool]
    env_kwargs: Mapping[str, Any]
    settings: Mapping[str, Any]

    def __post_init__(self) -> None:
        check_environment(self.environment_id, self.env_kwargs)

    @property
    def action_mode(self) -> str:
        """Name of the action mode, which says what the agent's actions mean."""
        return str(self.env_kwargs.get("action_mode", EnvConfig.action_mode))

    @property
    def name(self) -> str:
        """Name of the group of agents that this recipe trains, usable as the name of a folder."""
        return f"{self.algorithm}_{self.action_mode.replace(':', '-')}"

    def with_engine(self, engine: str) -> "Recipe":
        """The recipe with an engine of the environment; MuJoCo, which is the default, is not written down.

        Args:
            engine: name of the engine.

        Raises:
            UnknownNameError: an engine that does not exist.
        """
        others = {name: value for name, value in self.env_kwargs.items() if name != "engine"}
        chosen = {} if engine == MUJOCO else {"engine": engine}
        return replace(self, env_kwargs={**others, **chosen})

    def to_plain(self) -> dict[str, Any]:
        """The recipe as an entry of a file, with the algorithm and the environment beside it."""
        return {
            "algorithm": self.algorithm,
            "environment": self.environment_id,
            "n_timesteps": self.n_timesteps,
            "n_envs": self.n_envs,
            "policy": self.policy,
            "normalize": dict(self.normalize),
            "env_kwargs": dict(self.env_kwargs),
            **self.settings,
        }


def load_recipe(
    algorithm: str,
    environment_id: str,
    action_mode: str | None = None,
    config: Path | None = None,
    overrides: Iterable[str] = (),
) -> Recipe:
    """The recipe for an environment, merged from four entries of the recipe file.

    They are `default`, its part for the action mode, the entry of the environment id, and its part for the
    action mode; later ones replace earlier ones, key by key. What the id of a learning preset sets replaces
    the keywords of `default`.

    Args:
        algorithm: name of a declared algorithm.
        environment_id: id of a registered environment.
        action_mode: name of the action mode; None for the one that the file names.
        config: path of a recipe file to use instead of the algorithm's own.
        overrides: texts `key=value` that replace values of the file, with the value as in YAML; dots lead
            into nested keys, as in `policy_kwargs.net_arch=[32, 32]`.

    Raises:
        UnknownNameError: an algorithm, environment, key or environment keyword that does not exist.
        InvalidValueError: an override or a value that is not allowed.
        DataFileError: a file that cannot be read, or that is not plain YAML.
        MissingPackageError: a package for learning is not installed.
    """
    spec = ALGORITHMS.find(algorithm)
    check_environment(environment_id, {})
    entries = _read(spec, config)
    merged: dict[str, Any] = {}
    for entry in (_DEFAULT, environment_id):
        merged = _merge(merged, {k: v for k, v in entries.get(entry, {}).items() if k != _MODES})
    own_mode = _mapping("env_kwargs", merged.get("env_kwargs", {})).get("action_mode", "torque")
    mode = action_mode or str(own_mode)
    merged = {}
    for entry in (_DEFAULT, environment_id):
        own = dict(entries.get(entry, {}))
        of_mode = own.pop(_MODES, {}).get(mode, {})
        set_by_id = find_preset(environment_id).keywords if entry == _DEFAULT else {}
        merged = _merge(_merge(_merge(merged, own), of_mode), {"env_kwargs": set_by_id})
    for text in overrides:
        merged = _merge(merged, _parse_override(text))
    keywords = _mapping("env_kwargs", merged.get("env_kwargs", {}))
    merged["env_kwargs"] = {**keywords, "action_mode": mode}
    return make_recipe(algorithm, environment_id, merged)


def make_recipe(algorithm: str, environment_id: str, merged: Mapping[str, Any]) -> Recipe:
    """A recipe from a merged entry, checked.

    Args:
        algorithm: name of a declared algorithm.
        environment_id: id of a registered environment.
        merged: values of the recipe by their keys.

    Raises:
        UnknownNameError: an algorithm, environment, key or environment keyword that does not exist.
        InvalidValueError: a key that is missing, or a value that is not allowed.
    """
    spec = ALGORITHMS.find(algorithm)
    kinds = spec.settings()
    valid = _COMMON | set(kinds)
    for key in merged:
        if key not in valid:
            raise UnknownNameError(f"key of a recipe for {algorithm}", key, valid)
    for key in ("n_timesteps", "n_envs", "policy"):
        if key not in merged:
            raise InvalidValueError(
                f"recipe of {algorithm} for {environment_id}", merged, f"one with {key!r}"
            )
    policy = _policy_settings(spec, merged["policy"], merged.get("policy_kwargs", {}))
    settings = {
        key: policy if key == "policy_kwargs" else kinds[key].read(key, value)
        for key, value in merged.items()
        if key not in _COMMON or key == "policy_kwargs"
    }
    n_envs = ENVIRONMENTS.read("n_envs", merged["n_envs"])
    spec.scope.check(settings, n_envs)
    return Recipe(
        algorithm,
        environment_id,
        TIMESTEPS.read("n_timesteps", merged["n_timesteps"]),
        n_envs,
        merged["policy"],
        _normalize(merged.get("normalize", {})),
        _mapping("env_kwargs", merged.get("env_kwargs", {})),
        settings,
    )


def _read(spec: AlgorithmSpec, config: Path | None) -> dict[str, Any]:
    """The entries of a recipe file."""
    require("yaml")
    where = config or spec.recipes.name
    content = FileReader().read_yaml(config or spec.recipes)
    entries = _mapping(f"content of {where}", _with_numbers(content))
    tasks = list_envs()
    valid = (_DEFAULT, *tasks, *map(learning_id, tasks))
    for name, entry in entries.items():
        if name not in valid:
            raise UnknownNameError(f"environment in {where}", name, valid)
        for mode, part in _mapping(_MODES, _mapping(f"{name} in {where}", entry).get(_MODES, {})).items():
            _mapping(f"{_MODES}.{mode} of {name} in {where}", part)
    return entries


def _parse_override(text: str) -> dict[str, Any]:
    key, equals, value = text.partition("=")
    steps = key.strip().split(".")
    allowed = "key=value, with the value as in YAML"
    if not equals or not all(steps) or len(steps) > DEPTH:
        raise InvalidValueError("override", text, allowed)
    try:
        parsed = _with_numbers(parse_yaml(value))
    except DataTextError as error:
        raise InvalidValueError("override", text, f"{allowed} ({error.what})") from error
    for step in reversed(steps):
        parsed = {step: parsed}
    made: dict[str, Any] = parsed
    return made


def _with_numbers(value: object) -> Any:
    """A value of YAML in which texts such as `5e-4`, which YAML does not read as numbers, are numbers."""
    if isinstance(value, Mapping):
        return {key: _with_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_numbers(item) for item in value]
    if isinstance(value, str) and _EXPONENT.fullmatch(value):
        return float(value)
    return value


def _merge(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Both mappings merged; values of the second replace those of the first, in nested mappings too."""
    merged = dict(below)
    for key, value in above.items():
        both = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merge(merged[key], value) if both else value
    return merged


def _mapping(what: str, value: object) -> dict[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise InvalidValueError(what, value, "names with values")
    return dict(value)


def _policy_settings(spec: AlgorithmSpec, policy: object, given: object) -> dict[str, Any]:
    """The settings of a policy network, checked."""
    kinds = spec.policy_settings(policy)
    for key in _mapping("policy_kwargs", given):
        if key not in kinds:
            raise UnknownNameError(f"key of policy_kwargs of {spec.name}", key, kinds)
    return {
        key: kinds[key].read(f"policy_kwargs.{key}", value)
        for key, value in _mapping("policy_kwargs", given).items()
    }


def _normalize(value: object) -> dict[str, bool]:
    given = _mapping("normalize", value)
    for key, item in given.items():
        if key not in _NORMALIZED:
            raise UnknownNameError("key of normalize", key, _NORMALIZED)
        if not isinstance(item, bool):
            raise InvalidValueError(f"normalize.{key}", item, "true or false")
    return {key: given.get(key, True) for key in _NORMALIZED}
