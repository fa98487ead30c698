"""The environment that a card or recipe names: which id and keywords it may have, and its revision."""

from collections.abc import Mapping
from dataclasses import fields

from prp_gym.envs.config import EnvConfig
from prp_gym.errors import UnknownNameError
from prp_gym.tasks.spec import TASKS


def declared_keywords(environment_id: str) -> frozenset[str]:
    """Names of the keywords that an environment declares: the common ones and those of its task.

    Args:
        environment_id: id of a registered environment of this suite or of a plugin.

    Raises:
        UnknownNameError: an id that is not registered.
    """
    options = TASKS.find(environment_id).entry.options
    return frozenset(entry.name for kind in (EnvConfig, options) for entry in fields(kind))


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
    return TASKS.find(environment_id).revision
