"""`key_of`: what a stored result depends on, by which it is found again."""

from dataclasses import Field, asdict
from typing import Any, ClassVar, Protocol

from prp_gym.tasks.setup import MUJOCO

_ENGINE = "engine"


class Dataclass(Protocol):
    """An instance of any dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


def key_of(settings: Dataclass) -> dict[str, Any]:
    """The fields of a job or of a search by name.

    The engine is one of them unless it is MuJoCo: what was stored before there were others has none.

    Args:
        settings: all that a result depends on, besides the code.
    """
    known = asdict(settings)
    return {name: value for name, value in known.items() if (name, value) != (_ENGINE, MUJOCO)}
