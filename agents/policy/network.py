"""`Network`: the network of a trained policy in numpy, in single precision as in training."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array32 = NDArray[np.float32]
Memory = tuple[Array32, ...]


def _sigmoid(values: Array32) -> Array32:
    half = np.float32(0.5)
    return np.asarray(half + half * np.tanh(half * values))  # without an exponential that could overflow


def _elu(values: Array32) -> Array32:
    return np.where(values > 0, values, np.expm1(np.minimum(values, 0)))


ACTIVATIONS: Mapping[str, Callable[[Array32], Array32]] = {
    "elu": _elu,
    "leaky_relu": lambda values: np.where(values > 0, values, np.float32(0.01) * values),
    "relu": lambda values: np.maximum(values, np.float32(0)),
    "silu": lambda values: values * _sigmoid(values),
    "tanh": np.tanh,
}
"""Activation functions between the layers, with PyTorch's default parameters."""

HEADS: Mapping[str, Callable[[Array32], Array32]] = {
    "clip": lambda values: np.clip(values, np.float32(-1), np.float32(1)),
    "tanh": np.tanh,
}
"""Functions from the last layer to an action within [-1, 1]: clipping or squashing of a Gaussian's mean."""


@dataclass(frozen=True)
class NetworkShape:
    """Sizes and functions of a network, without its weights.

    Attributes:
        inputs: number of features.
        memory: sizes of the LSTM layers, from the input on; empty for a network without recurrence.
        hidden: sizes of the hidden layers after the LSTM layers.
        outputs: number of components of an action.
        activation: name of the function after each hidden layer, a key of `ACTIVATIONS`.
        head: name of the function after the last layer, a key of `HEADS`.
    """

    inputs: int
    memory: tuple[int, ...]
    hidden: tuple[int, ...]
    outputs: int
    activation: str
    head: str

    def tensor_shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the network's tensors by their names."""
        shapes: dict[str, tuple[int, ...]] = {}
        size = self.inputs
        for index, units in enumerate(self.memory):
            shapes[f"lstm_{index}.input_weight"] = (4 * units, size)
            shapes[f"lstm_{index}.state_weight"] = (4 * units, units)
            shapes[f"lstm_{index}.bias"] = (4 * units,)
            size = units
        for index, units in enumerate((*self.hidden, self.outputs)):
            shapes[f"layer_{index}.weight"] = (units, size)
            shapes[f"layer_{index}.bias"] = (units,)
            size = units
        return shapes


class Network:
    """A network of LSTM layers, if any, linear layers with activations, and a head.

    Args:
        shape: sizes and functions of the network.
        tensors: weights, with the names and shapes of `NetworkShape.tensor_shapes`. The rows of an LSTM layer
            are those of its input gate, forget gate, cell and output gate.
    """

    def __init__(self, shape: NetworkShape, tensors: Mapping[str, Array32]) -> None:
        self.shape = shape
        self.tensors = {name: np.array(tensors[name], dtype=np.float32) for name in shape.tensor_shapes()}
        for tensor in self.tensors.values():
            tensor.flags.writeable = False

    def initial_memory(self, lead: tuple[int, ...]) -> Memory:
        """The recurrent state at the start of an episode.

        Args:
            lead: leading dimensions of the features.

        Returns:
            output and cell (*lead, units) of each LSTM layer; empty for a network without recurrence.
        """
        return tuple(np.zeros((*lead, units), np.float32) for units in self.shape.memory for _ in range(2))

    def __call__(self, features: NDArray[np.floating], memory: Memory) -> tuple[Array32, Memory]:
        """The action for normalised features.

        Args:
            features: normalised features (..., inputs).
            memory: recurrent state from `initial_memory` or from the last call.

        Returns:
            action (..., outputs) within [-1, 1], and the recurrent state for the next call.
        """
        values = np.asarray(features, dtype=np.float32)
        after: Memory = ()
        for index in range(len(self.shape.memory)):
            output, cell = self._lstm_layer(index, values, memory[2 * index], memory[2 * index + 1])
            after, values = (*after, output, cell), output
        for index in range(len(self.shape.hidden)):
            values = ACTIVATIONS[self.shape.activation](self._layer(index, values))
        return HEADS[self.shape.head](self._layer(len(self.shape.hidden), values)), after

    def _layer(self, index: int, values: Array32) -> Array32:
        weight, bias = self.tensors[f"layer_{index}.weight"], self.tensors[f"layer_{index}.bias"]
        return np.asarray(values @ weight.T + bias)

    def _lstm_layer(self, index: int, values: Array32, output: Array32, cell: Array32) -> tuple[Array32, ...]:
        """Output and cell of an LSTM layer after one step."""
        own = (self.tensors[f"lstm_{index}.{name}"] for name in ("input_weight", "state_weight", "bias"))
        input_weight, state_weight, bias = own
        gates = values @ input_weight.T + output @ state_weight.T + bias
        enter, keep, candidate, show = np.split(gates, 4, axis=-1)
        cell = _sigmoid(keep) * cell + _sigmoid(enter) * np.tanh(candidate)
        return _sigmoid(show) * np.tanh(cell), cell
