"""Files of an agent that were altered, by accident or on purpose."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from safetensors.numpy import load, save

from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.agents.policy.agent_tensors import pack_tensors
from prp_gym.errors import AgentFileError
from tests.support.synthetic_agents import synthetic_policy

POLICY = synthetic_policy({"realistic": 0.5})


def tensors_of(stem: Path) -> Path:
    return stem.with_name(f"{stem.name}.safetensors")


def card_of(stem: Path) -> Path:
    return stem.with_name(f"{stem.name}.json")


def checksum(card: Any) -> str:
    """As documented: SHA-256 over the card's JSON with sorted keys and no spaces."""
    return hashlib.sha256(json.dumps(card, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def rewrite(stem: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    """Change a card as one would who knows how to make its checksum right again."""
    whole = json.loads(card_of(stem).read_text(encoding="utf-8"))
    change(whole["card"])
    whole["checksum"] = checksum(whole["card"])
    text = json.dumps(whole, indent=2, ensure_ascii=False) + "\n"
    card_of(stem).write_bytes(text.encode("utf-8", "surrogatepass"))


def replace_tensors(stem: Path, content: bytes) -> None:
    """Put other numbers in the place of an agent's, with a card that vouches for them."""
    tensors_of(stem).write_bytes(content)
    rewrite(stem, lambda card: card.update(sha256=hashlib.sha256(content).hexdigest()))


def refusal(path: str | Path) -> str:
    with pytest.raises(AgentFileError) as caught:
        load_agent(path)
    assert caught.value.path in str(caught.value)
    return str(caught.value)


def put(*keys: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(card: dict[str, Any]) -> None:
        inner: Any = card
        for key in keys[:-1]:
            inner = inner[key]
        inner[keys[-1]] = value

    return change


def with_tensors(**changes: Any) -> bytes:
    """The made-up agent's numbers with some replaced, and those of value None left out."""
    tensors = {**load(pack_tensors(POLICY.normalizer, POLICY.network))}
    tensors |= {name.replace("__", "."): value for name, value in changes.items()}
    return bytes(save({name: value for name, value in tensors.items() if value is not None}))
