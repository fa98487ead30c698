"""The state of a policy from one call of `predict` to the next."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import as_numbers, check_finite, finite
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import anywhere
from prp_gym.symbolic.array import holds_truth_values, is_symbolic

PolicyState = tuple[NDArray[Any], ...] | None

LARGEST = 1e18
"""Largest magnitude of a state: products with the weights of a network stay within single precision."""

_NOWHERE: NDArray[np.bool_] = np.zeros(1, dtype=np.bool_)


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
        InvalidValueError: a state that is not a tuple of arrays of numbers, or holds huge ones; an
            `episode_start` that does not hold truth values.
        NonFiniteError: NaN or infinity in the state.
    """
    starts = _truth_values(episode_start)
    if state is None:
        return fresh
    if not isinstance(state, (tuple, list)):
        raise InvalidValueError("state", state, "the tuple of arrays that the last call returned, or None")
    if not state:
        return fresh
    state = _require_like(fresh, state)
    if not anywhere(starts):
        return state
    if starts.size == 1:
        starts = starts.reshape((1,) * len(lead))
    elif starts.shape != lead:
        raise ShapeError("episode_start", starts.shape, f"{lead}")
    return tuple(
        np.where(starts.reshape(starts.shape + (1,) * (new.ndim - starts.ndim)), new, old)
        for new, old in zip(fresh, state, strict=True)
    )


def _truth_values(episode_start: object) -> NDArray[np.bool_]:
    """Whether an episode starts, as booleans; numbers are accepted, as in Stable-Baselines3.

    Raises:
        InvalidValueError: values that are neither booleans nor finite numbers.
    """
    if episode_start is None:
        return _NOWHERE
    if isinstance(episode_start, np.ndarray) and episode_start.dtype == np.bool_:
        return episode_start
    if is_symbolic(episode_start):
        started: Any = episode_start
        return started  # type: ignore[no-any-return]
    try:
        values = np.asarray(episode_start)
    except Exception:  # rows of different lengths, or whatever the value's own methods raise
        values = np.asarray(None)
    if values.dtype.kind != "b":
        values = finite("episode_start", episode_start)
    return values.astype(np.bool_)


def _require_like(fresh: tuple[NDArray[Any], ...], state: Sequence[NDArray[Any]]) -> tuple[NDArray[Any], ...]:
    """A state, if it has the shapes of a new one and holds finite numbers.

    Raises:
        ShapeError: another number of arrays, or arrays of another shape.
        InvalidValueError: something else than arrays of numbers, or huge ones.
        NonFiniteError: NaN or infinity.
    """
    if len(state) != len(fresh):
        raise ShapeError("state", (len(state),), f"a tuple of {len(fresh)} arrays")
    checked = []
    for new, old in zip(fresh, state, strict=True):
        if is_symbolic(old):
            checked.append(_require_symbolic_like(new, old))
            continue
        like = isinstance(old, np.ndarray) and old.dtype == new.dtype
        values = old if like else as_numbers("state", old).astype(new.dtype)
        if values.shape != new.shape:
            raise ShapeError("state", values.shape, f"{new.shape}")
        check_finite("state", values, largest=LARGEST)
        checked.append(values)
    return tuple(checked)


def _require_symbolic_like(new: NDArray[Any], old: NDArray[Any]) -> NDArray[Any]:
    """A symbolic state, which is no number in compiled code where numbers would be refused.

    Raises:
        ShapeError: an array of another shape.
    """
    if old.shape != new.shape:
        raise ShapeError("state", old.shape, f"{new.shape}")
    if holds_truth_values(old):
        return old
    kept: NDArray[Any] = np.where(np.abs(old) <= LARGEST, old, np.nan)
    return kept
