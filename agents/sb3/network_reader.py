"""What a model of Stable-Baselines3 computes its actions with, as a `Network`."""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.torch_layers import FlattenExtractor
from torch import nn

from prp_gym.agents.policy.network import Array32, Network, NetworkShape
from prp_gym.errors import InvalidValueError, NonFiniteError

_ACTIVATIONS: Mapping[type[nn.Module], str] = {
    nn.ELU: "elu",
    nn.LeakyReLU: "leaky_relu",
    nn.ReLU: "relu",
    nn.SiLU: "silu",
    nn.Tanh: "tanh",
}
Parts = tuple[nn.LSTM | None, list[nn.Module], str]
"""Memory, layers and activations in order, head."""


def read_network(model: BaseAlgorithm) -> Network:
    """The actor of a model.

    Raises:
        InvalidValueError: an algorithm, space or network that has no counterpart in `Network`.
        NonFiniteError: NaN or infinity among the weights.
    """
    algorithm = type(model).__name__
    if algorithm not in _READERS:
        raise InvalidValueError("algorithm", algorithm, f"one of {', '.join(sorted(_READERS))}")
    outputs = _check_spaces(model)
    if getattr(model, "use_sde", False):
        raise InvalidValueError("use_sde", True, "False: generalised exploration is not exported")
    memory, modules, head = _READERS[algorithm](model)
    linears, activation = _split(modules)
    tensors = _lstm_tensors(memory) if memory is not None else {}
    for index, linear in enumerate(linears):
        tensors[f"layer_{index}.weight"], tensors[f"layer_{index}.bias"] = map(
            _plain, (linear.weight, linear.bias)
        )
    shape = NetworkShape(
        inputs=memory.input_size if memory is not None else linears[0].in_features,
        memory=(memory.hidden_size,) * memory.num_layers if memory is not None else (),
        hidden=tuple(linear.out_features for linear in linears[:-1]),
        outputs=outputs,
        activation=activation,
        head=head,
    )
    for name, values in tensors.items():
        if not np.all(np.isfinite(values)):
            raise NonFiniteError(f"tensor {name!r} of the model", values)
    return Network(shape, tensors)


def _check_spaces(model: BaseAlgorithm) -> int:
    """Components of an action, where spaces are flat boxes and actions reach from -1 to 1.

    Raises:
        InvalidValueError: other spaces.
    """
    observations, actions = model.observation_space, model.action_space
    if not isinstance(observations, Box) or len(observations.shape) != 1:
        raise InvalidValueError("observation space of the model", observations, "a flat Box")
    if (
        not isinstance(actions, Box)
        or len(actions.shape) != 1
        or set(actions.low) != {-1}
        or set(actions.high) != {1}
    ):
        raise InvalidValueError("action space of the model", actions, "Box(-1, 1, (size,))")
    return actions.shape[0]


def _clipped(model: Any) -> Parts:
    policy = model.policy
    if policy.squash_output:
        raise InvalidValueError("squash_output", True, "False: the mean is clipped")
    _check_extractor(policy.pi_features_extractor)
    return None, [*policy.mlp_extractor.policy_net, policy.action_net], "clip"


def _remembering(model: Any) -> Parts:
    _, modules, head = _clipped(model)
    lstm = model.policy.lstm_actor
    plain = nn.LSTM(lstm.input_size, lstm.hidden_size, lstm.num_layers)
    for name in ("bias", "batch_first", "dropout", "bidirectional", "proj_size"):
        if getattr(lstm, name) != getattr(plain, name):
            raise InvalidValueError(f"{name} of the LSTM", getattr(lstm, name), f"{getattr(plain, name)}")
    return lstm, modules, head


def _squashed(model: Any) -> Parts:
    _check_extractor(model.actor.features_extractor)
    return None, [*model.actor.latent_pi, model.actor.mu], "tanh"


def _squashed_within(model: Any) -> Parts:
    """The actor whose last layer has its tanh in the same sequence."""
    _check_extractor(model.actor.features_extractor)
    *modules, last = model.actor.mu
    if type(last) is not nn.Tanh:
        raise InvalidValueError("last layer of the actor", last, "Tanh")
    return None, modules, "tanh"


_READERS: Mapping[str, Callable[[Any], Parts]] = {
    "PPO": _clipped,
    "RecurrentPPO": _remembering,
    "SAC": _squashed,
    "TD3": _squashed_within,
    "TQC": _squashed,
}


def _check_extractor(extractor: nn.Module) -> None:
    if type(extractor) is not FlattenExtractor:
        raise InvalidValueError("features extractor", type(extractor).__name__, "FlattenExtractor")


def _split(modules: list[nn.Module]) -> tuple[list[nn.Linear], str]:
    """The linear layers, and the one activation between them.

    Raises:
        InvalidValueError: other modules, or in another order.
    """
    linears, between = modules[::2], modules[1::2]
    kinds = {type(module) for module in between} or {nn.Tanh}
    fine = len(modules) % 2 == 1 and all(type(module) is nn.Linear for module in linears) and len(kinds) == 1
    name = _ACTIVATIONS.get(next(iter(kinds)))
    found = [module for module in linears if isinstance(module, nn.Linear) and module.bias is not None]
    if not fine or name is None or len(found) < len(linears):
        allowed = (
            f"linear layers with one activation of {', '.join(sorted(_ACTIVATIONS.values()))} between them"
        )
        raise InvalidValueError("layers of the network", modules, allowed)
    if any(before.out_features != after.in_features for before, after in pairwise(found)):
        raise InvalidValueError(
            "layers of the network", modules, "each of as many inputs as there are outputs"
        )
    return found, name


def _lstm_tensors(lstm: nn.LSTM) -> dict[str, Array32]:
    tensors = {}
    for index in range(lstm.num_layers):
        weights = {"input": f"weight_ih_l{index}", "state": f"weight_hh_l{index}"}
        for name, attribute in weights.items():
            tensors[f"lstm_{index}.{name}_weight"] = _plain(getattr(lstm, attribute))
        biases = [_plain(getattr(lstm, f"bias_{kind}_l{index}")) for kind in ("ih", "hh")]
        tensors[f"lstm_{index}.bias"] = biases[0] + biases[1]
    return tensors


def _plain(parameter: Any) -> Array32:
    return np.array(parameter.detach().cpu().numpy(), dtype=np.float32)
