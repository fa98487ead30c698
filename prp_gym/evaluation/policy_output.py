"""The inputs and outputs of policies: one observation or several at a time, actions and states."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import as_array
from prp_gym.errors import InvalidValueError, PolicyOutputError, shortened
from prp_gym.evaluation.rollout import Policy

_BATCHED_LIBRARY = "stable_baselines3."
_BATCHED_CLASSES = frozenset(("BaseAlgorithm", "BasePolicy"))


def takes_batches(policy: object) -> bool:
    """Whether `predict` of a policy takes several observations at once.

    Those of this suite say so by the attribute `batched`; those of Stable-Baselines3 are known by their base
    classes. Any other policy may keep a state of its own, and gets one observation at a time.

    Args:
        policy: anything with `predict`.
    """
    told = getattr(policy, "batched", None)
    if told is not None:
        return bool(told)
    return any(
        kind.__name__ in _BATCHED_CLASSES and kind.__module__.startswith(_BATCHED_LIBRARY)
        for kind in type(policy).__mro__
    )


def check_output(
    policy: Policy, output: object, shape: tuple[int, ...], finite: bool = True
) -> tuple[NDArray[Any], Any]:
    """Action and state that `predict` has returned.

    Args:
        policy: policy that returned the output, for messages.
        output: value that `predict` returned.
        shape: required shape of the action.
        finite: whether NaN and infinity are refused.

    Returns:
        the action (*shape) and the state for the next call.

    Raises:
        PolicyOutputError: something else than an action of this shape and a state, or NaN or infinity.
    """
    name, single = type(policy).__name__, shape[-1:]
    if not isinstance(output, tuple) or len(output) != 2:
        raise PolicyOutputError(name, f"a {type(output).__name__}, not two values", single)
    action, state = output
    try:
        numbers = as_array("action", action)
    except InvalidValueError:
        raise PolicyOutputError(
            name, f"an action that holds no numbers: {shortened(action)}", single
        ) from None
    if numbers.shape != shape:
        inputs = f" for observations of shape {(*shape[:-1], 'size')}" if shape[:-1] else ""
        raise PolicyOutputError(name, f"an action of shape {numbers.shape}{inputs}", single)
    if finite and not np.isfinite(numbers).all():
        raise PolicyOutputError(
            name, f"an action with NaN or infinity: {shortened(numbers.tolist())}", single
        )
    return np.asarray(action), state
