"""Normaliser and network weights of an agent as bytes in the safetensors format, which cannot hold code."""

import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from prp_gym.agents.policy.agent_card import AgentCard
from prp_gym.agents.policy.network import Network, NetworkShape
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.errors import AgentFileError

_NORMALIZER = ("mean", "variance", "epsilon", "clip")


def pack_tensors(normalizer: Normalizer, network: Network) -> bytes:
    """The content of the file; the same values give the same bytes."""
    values = {f"normalizer.{name}": np.array(getattr(normalizer, name), np.float64) for name in _NORMALIZER}
    return bytes(save({**values, **network.tensors}))


def digest(content: bytes) -> str:
    """SHA-256 of a file's content, in hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def unpack_tensors(path: Path, content: bytes, card: AgentCard) -> tuple[Normalizer, Network]:
    """Normaliser and network from the content of a file.

    Args:
        path: path of the file, for messages.
        content: content of the file.
        card: card of the agent, which states names, shapes and the SHA-256 of the content.

    Raises:
        AgentFileError: content that differs from what the card states.
    """
    if digest(content) != card.sha256:
        raise AgentFileError(path, "its SHA-256 is not that on its card: it is damaged, altered or another's")
    try:
        tensors = load(content)
    except (SafetensorError, KeyError, ValueError) as error:
        raise AgentFileError(path, f"is not a safetensors file: {error}") from None
    _check(path, tensors, card.network)
    mean, variance, epsilon, clip = (tensors[f"normalizer.{name}"].copy() for name in _NORMALIZER)
    if min(epsilon, clip) < 0 or np.any(variance + epsilon <= 0):
        raise AgentFileError(path, "the normaliser has a negative clip or epsilon, or no positive variance")
    return Normalizer(mean, variance, float(epsilon), float(clip)), Network(card.network, tensors)


def _expected(shape: NetworkShape) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Data type and shape of each tensor by its name."""
    sizes = ((shape.inputs,), (shape.inputs,), (), ())
    own = {f"normalizer.{name}": ("float64", size) for name, size in zip(_NORMALIZER, sizes, strict=True)}
    return own | {name: ("float32", size) for name, size in shape.tensor_shapes().items()}


def _check(path: Path, tensors: dict[str, NDArray[np.floating]], shape: NetworkShape) -> None:
    """Refuse tensors other than those that the card states, and values that are not finite."""
    expected = _expected(shape)
    if set(tensors) != set(expected):
        differing = sorted(set(tensors) ^ set(expected))
        raise AgentFileError(path, f"tensors missing or not on the card: {', '.join(differing)}")
    for name, (precision, size) in expected.items():
        tensor = tensors[name]
        if (str(tensor.dtype), tensor.shape) != (precision, size):
            found = f"{tensor.dtype} {tensor.shape}"
            raise AgentFileError(path, f"tensor {name!r} is {found}; the card says {precision} {size}")
        if np.any(np.isnan(tensor)) or (name != "normalizer.clip" and not np.all(np.isfinite(tensor))):
            raise AgentFileError(path, f"tensor {name!r} has NaN or infinity in it")
