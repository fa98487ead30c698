"""A recipe's plain values as the constructor arguments of a Stable-Baselines3 algorithm."""

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from prp_gym.agents.sb3.packages import require
from prp_gym.errors import InvalidValueError, UnknownNameError

if TYPE_CHECKING:
    from stable_baselines3.common.noise import ActionNoise

ACTIVATIONS = {"tanh": "Tanh", "relu": "ReLU", "elu": "ELU", "leaky_relu": "LeakyReLU", "silu": "SiLU"}
"""Class of `torch.nn` by the name of the activation in a recipe."""

NOISES = ("normal",)
NOISE_KEYS = ("noise_type", "noise_std")
"""Keys of a recipe that describe the exploration noise on actions."""

_SCHEDULED = ("learning_rate", "clip_range", "clip_range_vf")
_LINEAR = "lin_"


def constructor_arguments(settings: Mapping[str, Any], action_size: int) -> dict[str, Any]:
    """A recipe's settings as the constructor of an algorithm takes them.

    Args:
        settings: values by name, as in a recipe.
        action_size: number of components of an action.

    Raises:
        UnknownNameError: an activation or noise that does not exist.
        InvalidValueError: a schedule that cannot be read.
    """
    arguments = {key: value for key, value in settings.items() if key not in NOISE_KEYS}
    for key in _SCHEDULED:
        if key in arguments:
            arguments[key] = parse_schedule(key, arguments[key])
    policy = dict(arguments.get("policy_kwargs", {}))
    if "activation_fn" in policy:
        policy["activation_fn"] = _activation(policy["activation_fn"])
    noise = _noise(settings, action_size)
    return {**arguments, "policy_kwargs": policy, **({"action_noise": noise} if noise else {})}


def parse_schedule(what: str, value: object) -> float | Callable[[float], float] | None:
    """A constant, or for a text such as `lin_5e-4` a schedule that falls linearly from that value to zero.

    Args:
        what: name of the setting, for messages and because `clip_range_vf` may be None.
        value: number or text of the recipe.

    Raises:
        InvalidValueError: neither a positive number nor a linear schedule.
    """
    if value is None and what == "clip_range_vf":
        return None
    text = value.removeprefix(_LINEAR) if isinstance(value, str) and value.startswith(_LINEAR) else value
    try:
        start = math.nan if isinstance(text, bool) else float(text)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        start = math.nan
    if not 0.0 < start < math.inf:
        allowed = f"a number above 0, or a schedule that falls linearly from one: {_LINEAR}5e-4"
        raise InvalidValueError(what, value, allowed)
    if text is value:
        return start
    return lambda remaining: remaining * start


def _activation(name: object) -> Any:
    if name not in ACTIVATIONS:
        raise UnknownNameError("activation_fn", name, ACTIVATIONS)
    return getattr(require("torch.nn"), ACTIVATIONS[str(name)])


def _noise(settings: Mapping[str, Any], action_size: int) -> "ActionNoise | None":
    """Gaussian noise with the same standard deviation on every component of an action, which lies in ±1."""
    if "noise_type" not in settings:
        return None
    if settings["noise_type"] not in NOISES:
        raise UnknownNameError("noise_type", settings["noise_type"], NOISES)
    normal: type[Any] = require("stable_baselines3.common.noise").NormalActionNoise
    deviation = float(settings.get("noise_std", 0.1))
    noise: ActionNoise = normal([0.0] * action_size, [deviation] * action_size)
    return noise
