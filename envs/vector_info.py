"""`info` of many environments, in Gymnasium's form: an array a number, and a mask of who has it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array

Mask = NDArray[np.bool_]


def start_info(started: Mask) -> dict[str, Any]:
    """`info` of environments that begin an episode: the time, 0 [s]."""
    return {"time": np.zeros(len(started)), "_time": started.copy()}


def step_info(names: Sequence[str], values: Array, stepped: Mask) -> dict[str, Any]:
    """`info` of a step.

    Args:
        names: of the numbers.
        values: (N, number of names).
        stepped: (N) whose step this is.

    Returns:
        for every name an array (N), 0 where an environment has no such number, and under the name
        with an underscore before it a mask (N) of those that have; nothing where nobody was stepped.
    """
    info: dict[str, Any] = {}
    count = np.count_nonzero(stepped)
    if count < len(stepped):
        values = np.where(stepped[:, None], values, 0.0)
    for column, name in enumerate(names) if count else ():
        info[name] = values[:, column]
        info[f"_{name}"] = stepped.copy()
    return info


def final_info(names: Sequence[str], values: Array, observation: Array, ended: Mask) -> dict[str, Any]:
    """What the last steps of ended episodes returned, beside the observations of the new ones.

    Args:
        names: of the numbers.
        values: (N, number of names).
        observation: (N, size) of the last step.
        ended: (N) whose episode ended, at least one.
    """
    last = np.full(len(ended), None, dtype=object)
    for index in np.flatnonzero(ended):
        last[index] = observation[index].copy()
    return {
        "final_obs": last,
        "_final_obs": ended.copy(),
        "final_info": step_info(names, values, ended),
        "_final_info": ended.copy(),
    }
