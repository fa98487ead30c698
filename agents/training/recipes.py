"""`Recipe`: how an agent is trained, merged from the files in `hyperparameters/`."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from prp_gym.agents.sb3.algorithms import (
    ALGORITHMS,
    constructor_arguments,
    policy_names,
    require,
    setting_names,
)
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.tasks.registration import list_envs

_COMMON = frozenset(("n_timesteps", "n_envs", "policy", "policy_kwargs", "normalize", "env_kwargs"))
_MODES = "action_modes"
_DEFAULT = "default"
_NORMALIZED = ("obs", "reward")
_EXPONENT = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?[eE][+-]?[0-9]+")

EPISODES_A_SEED = 1_000_000
"""Seeds of episodes that belong to a training seed: seed k has those from (k + 1) times this."""

FIRST_HELD_OUT_SEED = 500_000_000
"""Seed of the first held-out episode; the others follow."""

SEEDS = FIRST_HELD_OUT_SEED // EPISODES_A_SEED - 1
"""How many training seeds there are, so that none has a held-out episode."""


@dataclass(frozen=True)
class Recipe:
    """How an agent is trained.

    Attributes:
        algorithm: one of `ALGORITHMS`.
        environment_id: where.
        n_timesteps: steps of all environments together.
        n_envs: environments side by side.
        policy: the algorithm's name of a kind of network.
        normalize: whether `obs` and `reward` are scaled by running statistics.
        env_kwargs: keywords of the environment, `action_mode` among them.
        settings: of the algorithm's constructor, `policy_kwargs` among them, as plain values.
    """

    algorithm: str
    environment_id: str
    n_timesteps: int
    n_envs: int
    policy: str
    normalize: Mapping[str, bool]
    env_kwargs: Mapping[str, Any]
    settings: Mapping[str, Any]

    @property
    def action_mode(self) -> str:
        """What the agent's actions mean."""
        return str(self.env_kwargs["action_mode"])

    @property
    def name(self) -> str:
        """Of the group of agents that are trained like this; a folder's name."""
        return f"{self.algorithm}_{self.action_mode.replace(':', '-')}"

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
    """The recipe for an environment: `default`, its part for the action mode, then the id's own and its part.

    Args:
        algorithm: one of `ALGORITHMS`.
        environment_id: of this suite.
        action_mode: what actions mean; None for what the file says.
        config: file in place of the one that comes with the suite.
        overrides: texts `key=value` that replace what the file says, values as in YAML; dots lead into
            nested keys, as in `policy_kwargs.net_arch=[32, 32]`.

    Raises:
        UnknownNameError: an algorithm, environment, or key that does not exist.
        InvalidValueError: a file, override or value that is not as it must be.
        MissingPackageError: a package for learning is not installed.
    """
    if algorithm not in ALGORITHMS:
        raise UnknownNameError("algorithm", algorithm, ALGORITHMS)
    if environment_id not in list_envs():
        raise UnknownNameError("environment", environment_id, list_envs())
    entries = _read(algorithm, config)
    merged: dict[str, Any] = {}
    for entry in (_DEFAULT, environment_id):
        merged = _merge(merged, {k: v for k, v in entries.get(entry, {}).items() if k != _MODES})
    own_mode = _mapping("env_kwargs", merged.get("env_kwargs", {})).get("action_mode", "torque")
    mode = action_mode or str(own_mode)
    merged = {}
    for entry in (_DEFAULT, environment_id):
        own = dict(entries.get(entry, {}))
        of_mode = own.pop(_MODES, {}).get(mode, {})
        merged = _merge(_merge(merged, own), of_mode)
    for text in overrides:
        merged = _merge(merged, _parse_override(text))
    keywords = _mapping("env_kwargs", merged.get("env_kwargs", {}))
    merged["env_kwargs"] = {**keywords, "action_mode": mode}
    return make_recipe(algorithm, environment_id, merged)


def make_recipe(algorithm: str, environment_id: str, merged: Mapping[str, Any]) -> Recipe:
    """A recipe of a merged entry, checked.

    Raises:
        UnknownNameError: a key that does not exist.
        InvalidValueError: a key that is missing, or a value that is not as it must be.
    """
    valid = setting_names(algorithm) | _COMMON
    for key in merged:
        if key not in valid:
            raise UnknownNameError(f"key of a recipe for {algorithm}", key, valid)
    for key in ("n_timesteps", "n_envs", "policy"):
        if key not in merged:
            raise InvalidValueError(
                f"recipe of {algorithm} for {environment_id}", merged, f"one with {key!r}"
            )
    allowed = policy_names(algorithm, merged["policy"])
    for key in _mapping("policy_kwargs", merged.get("policy_kwargs", {})):
        if key not in allowed:
            raise UnknownNameError(f"key of policy_kwargs of {algorithm}", key, allowed)
    if "train_freq" in merged:
        _count("train_freq", merged["train_freq"])
    settings = {key: value for key, value in merged.items() if key not in _COMMON or key == "policy_kwargs"}
    constructor_arguments(settings, joints=1)  # refuses what it cannot read
    return Recipe(
        algorithm,
        environment_id,
        _count("n_timesteps", merged["n_timesteps"]),
        _count("n_envs", merged["n_envs"]),
        merged["policy"],
        _normalize(merged.get("normalize", {})),
        _mapping("env_kwargs", merged.get("env_kwargs", {})),
        settings,
    )


def _read(algorithm: str, config: Path | None) -> dict[str, Any]:
    """The entries of a file of hyperparameters."""
    yaml = require("yaml")
    built_in = files("prp_gym.agents") / "hyperparameters" / f"{algorithm}.yml"
    where = config or f"{algorithm}.yml"
    try:
        content = yaml.safe_load((config or built_in).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InvalidValueError("config", str(where), f"a readable file in YAML ({error})") from error
    entries = _mapping(f"content of {where}", _with_numbers(content))
    for name, entry in entries.items():
        if name not in (_DEFAULT, *list_envs()):
            raise UnknownNameError(f"environment in {where}", name, (_DEFAULT, *list_envs()))
        for mode, part in _mapping(_MODES, _mapping(f"{name} in {where}", entry).get(_MODES, {})).items():
            _mapping(f"{_MODES}.{mode} of {name} in {where}", part)
    return entries


def _parse_override(text: str) -> dict[str, Any]:
    yaml = require("yaml")
    key, equals, value = text.partition("=")
    try:
        parsed = _with_numbers(yaml.safe_load(value))
    except yaml.YAMLError:
        equals = ""
    steps = key.strip().split(".")
    if not equals or not all(steps):
        raise InvalidValueError("override", text, "key=value, with the value as in YAML")
    for step in reversed(steps):
        parsed = {step: parsed}
    made: dict[str, Any] = parsed
    return made


def _with_numbers(value: object) -> Any:
    """A value of YAML with texts such as `5e-4`, which YAML does not take for numbers, as numbers."""
    if isinstance(value, Mapping):
        return {key: _with_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_numbers(item) for item in value]
    if isinstance(value, str) and _EXPONENT.fullmatch(value):
        return float(value)
    return value


def _merge(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Both, the second before the first, in nested mappings as well."""
    merged = dict(below)
    for key, value in above.items():
        both = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merge(merged[key], value) if both else value
    return merged


def _mapping(what: str, value: object) -> dict[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise InvalidValueError(what, value, "names with values")
    return dict(value)


def _count(what: str, value: object) -> int:
    whole = isinstance(value, int | float) and not isinstance(value, bool) and float(value).is_integer()
    if not whole or value < 1:  # type: ignore[operator]
        raise InvalidValueError(what, value, "a whole number, at least 1")
    return int(value)  # type: ignore[call-overload, no-any-return]


def _normalize(value: object) -> dict[str, bool]:
    given = _mapping("normalize", value)
    for key, item in given.items():
        if key not in _NORMALIZED:
            raise UnknownNameError("key of normalize", key, _NORMALIZED)
        if not isinstance(item, bool):
            raise InvalidValueError(f"normalize.{key}", item, "true or false")
    return {key: given.get(key, True) for key in _NORMALIZED}
