"""Masks of vector environments: which of them are reset, and which have a number in `info`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array

RESET_MASK = "reset_mask"
Mask = NDArray[np.bool_]


def checked_mask(mask: object, num_envs: int, started: bool) -> Mask:
    """Validate the mask of environments to reset (N).

    Args:
        mask: Mask as the user gives it.
        num_envs: Number of environments N.
        started: Whether all environments were reset before; the first reset covers all.

    Raises:
        ShapeError: a mask of another shape.
        InvalidValueError: values that are not booleans, none of them True, or one False at the first reset.
    """
    try:
        values = np.asarray(mask)
    except Exception:  # rows of different lengths, or whatever the value's own methods raise
        raise InvalidValueError(RESET_MASK, mask, f"truth values ({num_envs},)") from None
    if values.shape != (num_envs,):
        raise ShapeError(RESET_MASK, values.shape, f"({num_envs},)")
    if values.dtype != np.bool_ or not values.any():
        raise InvalidValueError(RESET_MASK, values.tolist(), "truth values, at least one of them True")
    if not (started or values.all()):
        raise InvalidValueError(f"{RESET_MASK} of the first reset", values.tolist(), "True everywhere")
    return values


def checked_ended(ended: object, num_envs: int, mode: AutoresetMode) -> Mask:
    """Validate which environments of a saved state wait for their reset (N).

    Raises:
        InvalidValueError: anything but an array of N truth values; an environment that waits in mode
            `SameStep`, where none does.
    """
    if not isinstance(ended, np.ndarray) or ended.dtype != np.bool_ or ended.shape != (num_envs,):
        raise InvalidValueError("saved state's ended environments", ended, f"truth values ({num_envs},)")
    if mode is AutoresetMode.SAME_STEP and ended.any():
        which = np.flatnonzero(ended).tolist()
        raise InvalidValueError("saved state's ended environments", which, "none with SameStep autoreset")
    return ended


def masked_info(names: Sequence[str], values: Array, concerned: Mask) -> dict[str, Any]:
    """The `info` of some environments, in the form of Gymnasium's vector environments.

    Args:
        names: Names of the numbers.
        values: Values of the numbers (N, number of names).
        concerned: Mask (N) of the environments that have an `info`, at least one.

    Returns:
        For every name an array (N), 0 where an environment has no such number, and under the name with a
        leading underscore the mask (N) of those that have it.
    """
    info: dict[str, Any] = {}
    if np.count_nonzero(concerned) < len(concerned):
        values = np.where(concerned[:, None], values, 0.0)
    for column, name in enumerate(names):
        info[name] = values[:, column]
        info[f"_{name}"] = concerned.copy()
    return info


def final_info(names: Sequence[str], values: Array, observation: Array, ended: Mask) -> dict[str, Any]:
    """The results of the last steps of ended episodes, beside the observations of the new ones.

    Args:
        names: Names of the numbers.
        values: Values of the numbers (N, number of names).
        observation: Observations of the last step (N, size).
        ended: Mask (N) of the environments whose episode ended, at least one.
    """
    last = np.full(len(ended), None, dtype=object)
    for index in np.flatnonzero(ended):
        last[index] = observation[index].copy()
    return {
        "final_obs": last,
        "_final_obs": ended.copy(),
        "final_info": masked_info(names, values, ended),
        "_final_info": ended.copy(),
    }
