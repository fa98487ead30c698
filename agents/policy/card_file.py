"""An `AgentCard` as a JSON file with a checksum, which reveals alterations."""

import hashlib
import json
from pathlib import Path
from typing import Any

from prp_gym.agents.policy.agent_card import FORMAT, AgentCard
from prp_gym.agents.policy.strict_json import StrictReader, parse_json
from prp_gym.artifacts import to_plain
from prp_gym.errors import AgentFileError

_KEYS = {"format", "card", "checksum"}


def pack_card(card: AgentCard) -> bytes:
    """The content of the file of a card."""
    plain = to_plain(card)
    return _render({"format": FORMAT, "card": plain, "checksum": _checksum(plain)})


def unpack_card(path: Path, content: bytes) -> AgentCard:
    """The card from the content of its file.

    Args:
        path: path of the file, for messages.
        content: content of the file.

    Raises:
        AgentFileError: content that is not a card, that has another format, that was altered, or that has a
            key or value that a card cannot have.
    """
    plain = parse_json(path, content)
    try:
        return _checked(path, content, plain)
    except RecursionError:
        raise AgentFileError(path, "has more levels than any card") from None


def _checked(path: Path, content: bytes, plain: Any) -> AgentCard:
    """The card, if the content is to the byte what this package writes for it."""
    reader = StrictReader(path)
    if isinstance(plain, dict) and plain.get("format", FORMAT) != FORMAT:
        raise AgentFileError(path, f"key 'format' is {plain['format']!r}; this version reads {FORMAT}")
    whole = reader.members(plain, "", _KEYS)
    card = reader.read(AgentCard, whole["card"], "card")
    if whole["checksum"] != _checksum(whole["card"]):
        raise AgentFileError(path, "key 'checksum' does not fit the rest: the card is damaged or altered")
    if content != _render(whole):
        raise AgentFileError(path, "is not written as this package writes cards: it is damaged or altered")
    return card


def _render(plain: Any) -> bytes:
    return (json.dumps(plain, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode(
        "utf-8", "surrogatepass"
    )


def _checksum(plain: Any) -> str:
    """SHA-256 of the card in a form that does not depend on the order of its keys."""
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()
