"""An `AgentCard` as a JSON file that shows if it was altered."""

import hashlib
import json
from pathlib import Path
from typing import Any

from prp_gym.agents.policy.agent_card import FORMAT, AgentCard
from prp_gym.agents.policy.strict_json import StrictReader, parse_json
from prp_gym.errors import AgentFileError
from prp_gym.evaluation.results import to_plain

_KEYS = {"format", "card", "checksum"}


def pack_card(card: AgentCard) -> bytes:
    """The content of the card's file."""
    plain = to_plain(card)
    return _render({"format": FORMAT, "card": plain, "checksum": _checksum(plain)})


def unpack_card(path: Path, content: bytes) -> AgentCard:
    """The card of a file's content.

    Args:
        path: of the file, for messages.
        content: of the file.

    Raises:
        AgentFileError: not such a file, of another format version, altered, or with a key or value that a
            card does not have.
    """
    plain = parse_json(path, content)
    try:
        return _checked(path, content, plain)
    except RecursionError:
        raise AgentFileError(path, "has more levels than any card") from None


def _checked(path: Path, content: bytes, plain: Any) -> AgentCard:
    """The card, if the file's content is exactly what it is packed as."""
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
