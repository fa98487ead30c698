"""`key_of`: what a stored result depends on, by which it is found again."""

from dataclasses import Field, asdict
from typing import Any, ClassVar, Protocol

from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning.task import FINAL_EPISODES, SAMPLING

_LATER = {"engine": MUJOCO, "method": SAMPLING, "final_episodes": FINAL_EPISODES}
"""Fields that were added later, with the value for which results that were stored before stand."""


class Dataclass(Protocol):
    """An instance of any dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


def key_of(settings: Dataclass) -> dict[str, Any]:
    """The fields of a job or of a search by name.

    Fields that were added later are among them unless they have their first value: what was stored before
    has none.

    Args:
        settings: all that a result depends on, besides the code.
    """
    known = asdict(settings)
    return {name: value for name, value in known.items() if name not in _LATER or value != _LATER[name]}
