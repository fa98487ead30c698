"""Checks of the environments and actions that an episode loop is given."""

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, NonFiniteError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.array import is_symbolic


def check_ids(ids: NDArray[np.intp], num_envs: int, *, started: bool) -> None:
    """Refuse environments to reset that are not a rising choice of those of a loop.

    Args:
        ids: Environments to reset (n).
        num_envs: Number of environments of the loop.
        started: Whether every environment has been reset before; if not, ids must contain all.

    Raises:
        InvalidValueError: ids out of order or out of range, or not all at the first reset.
    """
    rising = len(ids) > 0 and ids[0] >= 0 and ids[-1] < num_envs
    if not rising or np.count_nonzero(ids[1:] > ids[:-1]) < len(ids) - 1:
        raise InvalidValueError("ids", ids.tolist(), f"rising, from 0 to {num_envs - 1}")
    if not started and len(ids) < num_envs:
        raise InvalidValueError("ids of the first reset", ids.tolist(), "all environments")


def clip_actions(action: Array) -> Array:
    """Clip actions (N, size) to ±1.

    Raises:
        NonFiniteError: NaN or infinity in an action.
    """
    if not is_symbolic(action):
        bad = np.flatnonzero(~np.isfinite(action).all(axis=1))
        if len(bad):
            what = "action" if len(action) == 1 else f"action of environments {bad.tolist()}"
            raise NonFiniteError(what, action[bad].tolist())
    within: Array = np.clip(action, -1.0, 1.0)
    return within


def limit_actions(action: Array, largest: Array) -> tuple[Array, NDArray[np.bool_] | None]:
    """Actions clipped to ±1, and a mask (N, joints) of those at or beyond ±1; None if there are none.

    Args:
        action: Actions (N, joints).
        largest: Ones (N, joints).

    Raises:
        NonFiniteError: NaN or infinity in an action.
    """
    inside = np.abs(action) < largest
    if not is_symbolic(inside) and np.count_nonzero(inside) == inside.size:
        return action, None
    return clip_actions(action), ~inside
