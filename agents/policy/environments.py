"""The environment that a card or recipe names: which id and keywords it may have, and its revision."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from prp_gym.envs.config import EnvConfig, parse_keywords
from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError
from prp_gym.tasks.presets import find_preset

_LONGEST_LIST = 12
_LONGEST_TEXT = 200
_LARGEST = {"duration": (3600.0, "s"), "width": (4096, "pixel"), "height": (4096, "pixel")}
_PLAIN = f"text, a number, true, false, null or a list of at most {_LONGEST_LIST} numbers"


def declared_keywords(environment_id: str) -> frozenset[str]:
    """Names of the keywords that an environment declares: the common ones and those of its task.

    Args:
        environment_id: id of a registered environment of this suite or of a plugin, or of a learning preset.

    Raises:
        UnknownNameError: an id that is not registered.
    """
    options = find_preset(environment_id).task.entry.options
    return frozenset(entry.name for kind in (EnvConfig, options) for entry in fields(kind))


def check_environment(environment_id: str, keywords: Mapping[str, object]) -> None:
    """Refuse what an agent's card or recipe says about its environment, before anything is imported or made.

    Gymnasium's own arguments of `make`, such as `max_episode_steps`, are no keywords of an environment. A
    file cannot open a window either: `render_mode="human"` is for callers alone.

    Args:
        environment_id: id that the file names, of a task or of its learning preset; the form `module:id` is
            refused.
        keywords: keywords of the environment by their names.

    Raises:
        UnknownNameError: an id that is not registered, a keyword that the environment does not declare, or a
            scenario, action mode or other word that does not exist.
        InvalidValueError: a value of another type, or out of bounds.
        ShapeError: a list of another length.
    """
    valid, preset = declared_keywords(environment_id), find_preset(environment_id)
    for name, value in keywords.items():
        if name not in valid:
            raise UnknownNameError(f"keyword of environment {environment_id!r}", name, valid)
        if not _is_plain(value):
            raise InvalidValueError(f"keyword {name!r} of environment {environment_id!r}", value, _PLAIN)
    if keywords.get("render_mode") == "human":
        raise InvalidValueError("render_mode in a file", "human", "rgb_array, depth_array or null")
    try:
        config, _ = parse_keywords(preset.complete(keywords), preset.task.entry.options)
    except PRPError:
        raise
    except Exception as error:  # options of a plugin may raise any exception about a value
        raise InvalidValueError(
            f"keywords of environment {environment_id!r}", keywords, str(error)
        ) from error
    for name, (largest, unit) in _LARGEST.items():
        if getattr(config, name) > largest:
            raise InvalidValueError(f"{name} in a file", getattr(config, name), f"at most {largest:g}", unit)


def _is_plain(value: Any) -> bool:
    """Whether a value is of a type that keywords have in files."""
    if isinstance(value, str):
        return len(value) <= _LONGEST_TEXT
    if isinstance(value, list | tuple):
        return len(value) <= _LONGEST_LIST and all(type(item) in (int, float) for item in value)
    return value is None or isinstance(value, bool | int | float)


def environment_revision(environment_id: str) -> int:
    """The present revision of an environment's behaviour, which agents' cards store.

    Raises:
        UnknownNameError: an id that is not registered.
    """
    return find_preset(environment_id).task.revision
