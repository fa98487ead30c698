"""`Network`: a trained policy's network in numpy, in the single precision in which it was trained."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array32 = NDArray[np.float32]
Memory = tuple[Array32, ...]


def _sigmoid(values: Array32) -> Array32:
    half = np.float32(0.5)
    return np.asarray(half + half * np.tanh(half * values))  # no exponential that overflows


def _elu(values: Array32) -> Array32:
    return np.where(values > 0, values, np.expm1(np.minimum(values, 0)))


ACTIVATIONS: Mapping[str, Callable[[Array32], Array32]] = {
    "elu": _elu,
    "leaky_relu": lambda values: np.where(values > 0, values, np.float32(0.01) * values),
    "relu": lambda values: np.maximum(values, np.float32(0)),
    "silu": lambda values: values * _sigmoid(values),
    "tanh": np.tanh,
}
"""Between the layers, with torch's default numbers."""

HEADS: Mapping[str, Callable[[Array32], Array32]] = {
    "clip": lambda values: np.clip(values, np.float32(-1), np.float32(1)),
    "tanh": np.tanh,
}
"""From the last layer to an action within [-1, 1]: a Gaussian's mean clipped, or squashed."""


@dataclass(frozen=True)
class NetworkShape:
    """All of a network but its numbers.

    Attributes:
        inputs: number of features.
        memory: sizes of the LSTM layers, from the input on; none without memory.
        hidden: sizes of the hidden layers after them.
        outputs: components of an action.
        activation: after each hidden layer, by its name in `ACTIVATIONS`.
        head: by its name in `HEADS`.
    """

    inputs: int
    memory: tuple[int, ...]
    hidden: tuple[int, ...]
    outputs: int
    activation: str
    head: str

    def tensor_shapes(self) -> dict[str, tuple[int, ...]]:
        """The names of the network's tensors, with their shapes."""
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
    """LSTM layers, if any, then layers with an activation, then the head.

    Args:
        shape: of the network.
        tensors: by the names of `NetworkShape.tensor_shapes`, of these shapes. The rows of an LSTM layer are
            those of its input gate, forget gate, cell and output gate.
    """

    def __init__(self, shape: NetworkShape, tensors: Mapping[str, Array32]) -> None:
        self.shape = shape
        self.tensors = {name: np.array(tensors[name], dtype=np.float32) for name in shape.tensor_shapes()}
        for tensor in self.tensors.values():
            tensor.flags.writeable = False

    def initial_memory(self, lead: tuple[int, ...]) -> Memory:
        """The memory at the start of an episode.

        Args:
            lead: leading dimensions of the features.

        Returns:
            output and cell (*lead, units) of each LSTM layer; none without memory.
        """
        return tuple(np.zeros((*lead, units), np.float32) for units in self.shape.memory for _ in range(2))

    def __call__(self, features: NDArray[np.floating], memory: Memory) -> tuple[Array32, Memory]:
        """The action.

        Args:
            features: (..., inputs), normalised.
            memory: of `initial_memory` or of the last call.

        Returns:
            action (..., outputs) within [-1, 1], and the memory for the next call.
        """
        values = np.asarray(features, dtype=np.float32)
        after: Memory = ()
        for index in range(len(self.shape.memory)):
            output, cell = self._remember(index, values, memory[2 * index], memory[2 * index + 1])
            after, values = (*after, output, cell), output
        for index in range(len(self.shape.hidden)):
            values = ACTIVATIONS[self.shape.activation](self._layer(index, values))
        return HEADS[self.shape.head](self._layer(len(self.shape.hidden), values)), after

    def _layer(self, index: int, values: Array32) -> Array32:
        weight, bias = self.tensors[f"layer_{index}.weight"], self.tensors[f"layer_{index}.bias"]
        return np.asarray(values @ weight.T + bias)

    def _remember(self, index: int, values: Array32, output: Array32, cell: Array32) -> tuple[Array32, ...]:
        """Output and cell of an LSTM layer after these values."""
        own = (self.tensors[f"lstm_{index}.{name}"] for name in ("input_weight", "state_weight", "bias"))
        input_weight, state_weight, bias = own
        gates = values @ input_weight.T + output @ state_weight.T + bias
        enter, keep, candidate, show = np.split(gates, 4, axis=-1)
        cell = _sigmoid(keep) * cell + _sigmoid(enter) * np.tanh(candidate)
        return _sigmoid(show) * np.tanh(cell), cell
