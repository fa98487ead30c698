"""The state of a policy from one call of `predict` to the next."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import ShapeError

PolicyState = tuple[NDArray[Any], ...] | None


def state_to_begin_with(
    fresh: tuple[NDArray[Any], ...],
    state: PolicyState,
    episode_start: NDArray[Any] | None,
    lead: tuple[int, ...],
) -> tuple[NDArray[Any], ...]:
    """The state at the start of a call: that of the last call, or a new one where an episode starts.

    Args:
        fresh: state of new episodes, arrays (*lead, any size).
        state: state that the last call returned; None at first.
        episode_start: (*lead), or one for all, whether an episode starts; None for nowhere.
        lead: leading dimensions of the observations.

    Raises:
        ShapeError: a state of another policy or number of environments; an `episode_start` of another number.
    """
    if not state:
        return fresh
    _require_like(fresh, state)
    if episode_start is None or not np.any(episode_start):
        return state
    starts = np.asarray(episode_start, dtype=np.bool_)
    if starts.size == 1:
        starts = starts.reshape((1,) * len(lead))
    elif starts.shape != lead:
        raise ShapeError("episode_start", starts.shape, f"{lead}")
    return tuple(
        np.where(starts.reshape(starts.shape + (1,) * (new.ndim - starts.ndim)), new, old)
        for new, old in zip(fresh, state, strict=True)
    )


def _require_like(fresh: tuple[NDArray[Any], ...], state: tuple[NDArray[Any], ...]) -> None:
    """Raise unless a state has the arrays and shapes of a new one."""
    if len(state) != len(fresh):
        raise ShapeError("state", (len(state),), f"a tuple of {len(fresh)} arrays")
    for new, old in zip(fresh, state, strict=True):
        if np.shape(old) != new.shape:
            raise ShapeError("state", np.shape(old), f"{new.shape}")
