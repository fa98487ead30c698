"""Readers of actors: which layers of a Stable-Baselines3 model compute its actions."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from prp_gym.agents.sb3.packages import require
from prp_gym.errors import InvalidValueError

if TYPE_CHECKING:
    from torch import nn


@dataclass(frozen=True, eq=False)
class Actor:
    """The layers that compute an action from features.

    Attributes:
        memory: LSTM layers before all others; None for a network without recurrence.
        modules: linear layers and the activations between them, in order.
        head: name of the function after the last layer, a key of `prp_gym.agents.policy.network.HEADS`.
    """

    memory: "nn.LSTM | None"
    modules: "list[nn.Module]"
    head: str


ActorReader = Callable[[Any], Actor]
"""Function that finds the actor of a trained model."""


def read_gaussian_actor(model: Any) -> Actor:
    """The actor of an on-policy algorithm: the mean of a Gaussian, clipped to the action bounds.

    Args:
        model: PPO, or a model with the same policy class.

    Raises:
        InvalidValueError: a squashed mean, or a features extractor other than `FlattenExtractor`.
    """
    policy = model.policy
    if policy.squash_output:
        raise InvalidValueError("squash_output", True, "False: the mean is clipped")
    _check_extractor(policy.pi_features_extractor)
    return Actor(None, [*policy.mlp_extractor.policy_net, policy.action_net], "clip")


def read_recurrent_actor(model: Any) -> Actor:
    """The actor of a recurrent on-policy algorithm: LSTM layers, then as `read_gaussian_actor`.

    Args:
        model: RecurrentPPO, or a model with the same policy class.

    Raises:
        InvalidValueError: as `read_gaussian_actor`; an LSTM with other options than PyTorch's defaults.
    """
    actor = read_gaussian_actor(model)
    lstm = model.policy.lstm_actor
    plain = require("torch.nn").LSTM(lstm.input_size, lstm.hidden_size, lstm.num_layers)
    for name in ("bias", "batch_first", "dropout", "bidirectional", "proj_size"):
        if getattr(lstm, name) != getattr(plain, name):
            raise InvalidValueError(f"{name} of the LSTM", getattr(lstm, name), f"{getattr(plain, name)}")
    return Actor(lstm, actor.modules, actor.head)


def read_squashed_actor(model: Any) -> Actor:
    """The actor of an off-policy algorithm with a stochastic policy: the mean, squashed by tanh.

    Args:
        model: SAC, TQC, or a model with the same policy class.

    Raises:
        InvalidValueError: a features extractor other than `FlattenExtractor`.
    """
    _check_extractor(model.actor.features_extractor)
    return Actor(None, [*model.actor.latent_pi, model.actor.mu], "tanh")


def read_deterministic_actor(model: Any) -> Actor:
    """The actor of an off-policy algorithm with a deterministic policy, whose last module is a tanh.

    Args:
        model: TD3, or a model with the same policy class.

    Raises:
        InvalidValueError: another last module, or a features extractor other than `FlattenExtractor`.
    """
    _check_extractor(model.actor.features_extractor)
    *modules, last = model.actor.mu
    if type(last) is not require("torch.nn").Tanh:
        raise InvalidValueError("last layer of the actor", last, "Tanh")
    return Actor(None, modules, "tanh")


def _check_extractor(extractor: object) -> None:
    if type(extractor) is not require("stable_baselines3.common.torch_layers").FlattenExtractor:
        raise InvalidValueError("features extractor", type(extractor).__name__, "FlattenExtractor")
