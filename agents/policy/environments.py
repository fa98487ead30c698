"""The environment that a card or recipe names: which id and keywords it may have, and its revision."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from gymnasium.envs.registration import load_env_creator

from prp_gym.envs.config import EnvConfig
from prp_gym.errors import UnknownNameError
from prp_gym.registration import ENVIRONMENTS, EnvironmentEntry

_NOT_FOR_FILES = frozenset(("action_modes",))
"""Keywords that would import code that a file names."""


def declared_keywords(environment_id: str) -> frozenset[str]:
    """Names of the keywords that an environment declares: the common ones and those of its task.

    Args:
        environment_id: id of a registered environment of this suite or of a plugin.

    Raises:
        UnknownNameError: an id that is not registered.
    """
    declared: Any = load_env_creator(_find(environment_id).entry_point)
    options: type[Any] = declared.options_class
    names = {entry.name for kind in (EnvConfig, options) for entry in fields(kind)}
    return frozenset(names) - _NOT_FOR_FILES


def check_environment(environment_id: str, keywords: Mapping[str, object]) -> None:
    """Refuse what an agent's card or recipe says about its environment, before anything is imported or made.

    Args:
        environment_id: id that the file names; the form `module:id` is refused.
        keywords: keywords of the environment by their names.

    Raises:
        UnknownNameError: an id that is not registered, or a keyword that the environment does not declare.
    """
    valid = declared_keywords(environment_id)
    for name in keywords:
        if name not in valid:
            raise UnknownNameError(f"keyword of environment {environment_id!r}", name, valid)


def environment_revision(environment_id: str) -> int:
    """The present revision of an environment's behaviour, which agents' cards store.

    Raises:
        UnknownNameError: an id that is not registered.
    """
    _find(environment_id)
    return 1


def _find(environment_id: object) -> EnvironmentEntry:
    declared = {entry.id: entry for entry in ENVIRONMENTS}
    if not isinstance(environment_id, str) or environment_id not in declared:
        raise UnknownNameError("environment", environment_id, declared)
    return declared[environment_id]
