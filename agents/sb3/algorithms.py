"""The learning algorithms by name, and what of a recipe they take; their libraries are imported on use."""

import inspect
import math
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from prp_gym.errors import InvalidValueError, MissingPackageError, UnknownNameError

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.noise import ActionNoise

ALGORITHMS = {
    "ppo": ("stable_baselines3", "PPO"),
    "sac": ("stable_baselines3", "SAC"),
    "td3": ("stable_baselines3", "TD3"),
    "tqc": ("sb3_contrib", "TQC"),
    "recurrent_ppo": ("sb3_contrib", "RecurrentPPO"),
}
"""By name, package and class."""

ACTIVATIONS = {"tanh": "Tanh", "relu": "ReLU", "elu": "ELU", "leaky_relu": "LeakyReLU", "silu": "SiLU"}
"""By name, class of `torch.nn`."""

NOISES = ("normal",)
NOISE_KEYS = ("noise_type", "noise_std")

_SCHEDULED = ("learning_rate", "clip_range", "clip_range_vf")
_LINEAR = "lin_"
_SETTLED = frozenset(
    (
        *("self", "policy", "env", "policy_kwargs", "seed", "verbose", "tensorboard_log", "device"),
        *("_init_setup_model", "action_noise", "optimize_memory_usage", "replay_buffer_class"),
        *("replay_buffer_kwargs", "rollout_buffer_class", "rollout_buffer_kwargs"),
        *("use_sde", "sde_sample_freq", "use_sde_at_warmup"),
    )
)
"""Arguments that training sets, that are no plain values, or whose policies cannot be exported."""

_SETTLED_POLICY = frozenset(
    (
        *("self", "observation_space", "action_space", "lr_schedule", "features_extractor_class"),
        *("features_extractor_kwargs", "normalize_images", "optimizer_class", "optimizer_kwargs"),
        *("use_sde", "squash_output", "full_std", "use_expln", "clip_mean", "args", "kwargs"),
    )
)


def load_algorithm(name: str) -> "type[BaseAlgorithm]":
    """The class of an algorithm.

    Raises:
        UnknownNameError: no such algorithm.
        MissingPackageError: its package is not installed.
    """
    if name not in ALGORITHMS:
        raise UnknownNameError("algorithm", name, ALGORITHMS)
    package, class_name = ALGORITHMS[name]
    found: type[BaseAlgorithm] = getattr(require(package), class_name)
    return found


def require(package: str) -> Any:
    """A package of the extra `agents`.

    Raises:
        MissingPackageError: it, or what it is built on, is not installed.
    """
    for needed in dict.fromkeys(("torch", "stable_baselines3", package)):
        try:
            module = import_module(needed)
        except ModuleNotFoundError as error:
            if error.name != needed.partition(".")[0] and error.name != needed:
                raise  # it is there, and something else is not
            raise MissingPackageError(needed, "agents") from None
    return module


def setting_names(name: str) -> frozenset[str]:
    """What a recipe may set of an algorithm's constructor."""
    arguments = set(inspect.signature(load_algorithm(name).__init__).parameters) - _SETTLED
    takes_noise = "learning_starts" in arguments
    return frozenset(arguments | (set(NOISE_KEYS) if takes_noise else set()))


def policy_names(name: str, policy: str) -> frozenset[str]:
    """What a recipe may set of a policy's constructor.

    Raises:
        UnknownNameError: the algorithm has no such policy for observations that are arrays.
    """
    aliases = load_algorithm(name).policy_aliases
    valid = [alias for alias in aliases if alias.startswith("Mlp")]
    if policy not in valid:
        raise UnknownNameError("policy", policy, valid)
    return frozenset(set(inspect.signature(aliases[policy].__init__).parameters) - _SETTLED_POLICY)


def constructor_arguments(settings: Mapping[str, Any], joints: int) -> dict[str, Any]:
    """A recipe's settings as an algorithm's constructor takes them.

    Args:
        settings: by name, as in a recipe.
        joints: number of actions.

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
    noise = _noise(settings, joints)
    return {**arguments, "policy_kwargs": policy, **({"action_noise": noise} if noise else {})}


def parse_schedule(what: str, value: object) -> float | Callable[[float], float] | None:
    """A constant, or of a text such as `lin_5e-4` what falls linearly from that to zero.

    Raises:
        InvalidValueError: neither.
    """
    if value is None and what == "clip_range_vf":
        return None
    text = value.removeprefix(_LINEAR) if isinstance(value, str) and value.startswith(_LINEAR) else value
    try:
        start = math.nan if isinstance(text, bool) else float(text)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        start = math.nan
    if not 0.0 < start < math.inf:
        raise InvalidValueError(what, value, f"a number above 0, or one that falls: {_LINEAR}5e-4")
    if text is value:
        return start
    return lambda remaining: remaining * start


def _activation(name: object) -> Any:
    if name not in ACTIVATIONS:
        raise UnknownNameError("activation_fn", name, ACTIVATIONS)
    return getattr(require("torch.nn"), ACTIVATIONS[str(name)])


def _noise(settings: Mapping[str, Any], joints: int) -> "ActionNoise | None":
    """Noise on actions, the same on each, of a standard deviation in actions' own unit."""
    if "noise_type" not in settings:
        return None
    if settings["noise_type"] not in NOISES:
        raise UnknownNameError("noise_type", settings["noise_type"], NOISES)
    normal: type[Any] = require("stable_baselines3.common.noise").NormalActionNoise
    noise: ActionNoise = normal([0.0] * joints, [float(settings.get("noise_std", 0.1))] * joints)
    return noise
