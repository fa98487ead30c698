"""`read_network`: the actor of a Stable-Baselines3 model as a `Network`."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from stable_baselines3.common.base_class import BaseAlgorithm
from torch import nn

from prp_gym.agents.policy.network import Array32, Network, NetworkShape
from prp_gym.agents.sb3.actors import ActorReader
from prp_gym.agents.sb3.arguments import ACTIVATIONS
from prp_gym.errors import InvalidValueError, NonFiniteError

_ACTIVATIONS: Mapping[type[nn.Module], str] = {getattr(nn, kind): name for name, kind in ACTIVATIONS.items()}


def read_network(model: BaseAlgorithm, read_actor: ActorReader) -> Network:
    """The network that computes the actions of a model.

    Args:
        model: trained model.
        read_actor: function that finds the layers of the model's actor.

    Raises:
        InvalidValueError: a space or network that has no counterpart in `Network`.
        NonFiniteError: NaN or infinity among the weights.
    """
    outputs = _check_spaces(model)
    if getattr(model, "use_sde", False):
        raise InvalidValueError("use_sde", True, "False: generalised exploration is not exported")
    actor = read_actor(model)
    memory = actor.memory
    linears, activation = _split(actor.modules)
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
        head=actor.head,
    )
    for name, values in tensors.items():
        if not np.all(np.isfinite(values)):
            raise NonFiniteError(f"tensor {name!r} of the model", values)
    return Network(shape, tensors)


def _check_spaces(model: BaseAlgorithm) -> int:
    """The number of components of an action, if both spaces are flat boxes and actions lie in ±1.

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


def _split(modules: list[nn.Module]) -> tuple[list[nn.Linear], str]:
    """The linear layers, and the name of the activation that stands between all of them.

    Raises:
        InvalidValueError: other modules, or modules in another order.
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
            "layers of the network", modules, "each with as many inputs as the layer before it has outputs"
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
