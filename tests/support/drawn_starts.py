"""How one episode starts, as a task draws it from a seed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from prp_gym.tasks.task import Task


def drawn_start(task: Task, rng: np.random.Generator | int, options: Mapping[str, Any]) -> Any:
    """The start of one episode: numbers without the axis of the environments; one plane and one trajectory.

    Args:
        task: Task that draws it.
        rng: Generator of the environment, or its seed.
        options: Reset options by name, each of its own shape.
    """
    given = {name: np.array(value, dtype=np.float64)[None] for name, value in options.items()}
    start = task.draw([np.random.default_rng(rng)], given)
    return replace(start, **{name: _first(value) for name, value in vars(start).items()})


def _first(value: Any) -> Any:
    """The first row of an array or of each array of a tuple; what else there is stays as it is."""
    if isinstance(value, np.ndarray):
        return value[0]
    return type(value)(*map(_first, value)) if isinstance(value, tuple) else value
