"""An `AgentCard` as a JSON file with a checksum, which reveals alterations."""

import json
from pathlib import Path
from typing import Any

from prp_gym.agents.policy.agent_card import FORMAT, AgentCard
from prp_gym.artifacts import to_plain
from prp_gym.errors import AgentFileError, shortened
from prp_gym.files.checksum import checksum
from prp_gym.files.file_reader import FileReader
from prp_gym.files.typed_reader import TypedReader

_KEYS = {"format", "card", "checksum"}
_LARGEST = 16 * 2**20  # [bytes]

READER = FileReader(_LARGEST, AgentFileError)
"""Reader of cards."""


def pack_card(card: AgentCard) -> bytes:
    """The content of the file of a card."""
    plain = to_plain(card)
    return _render({"format": FORMAT, "card": plain, "checksum": checksum(plain)})


def unpack_card(path: Path, content: bytes) -> AgentCard:
    """The card from the content of its file.

    Args:
        path: path of the file, for messages.
        content: content of the file.

    Raises:
        AgentFileError: content that is not a card, that has another format, that was altered, or that has a
            key or value that a card cannot have.
    """
    plain = READER.parse_json(path, content)
    reader = TypedReader(path, AgentFileError)
    if isinstance(plain, dict) and plain.get("format", FORMAT) != FORMAT:
        found = shortened(plain["format"])
        raise AgentFileError(path, f"key 'format' is {found}; this version reads {FORMAT}")
    whole = reader.members(plain, "", _KEYS)
    card = reader.read(AgentCard, whole["card"], "card")
    if whole["checksum"] != checksum(whole["card"]):
        raise AgentFileError(path, "key 'checksum' does not fit the rest: the card is damaged or altered")
    if content != _render(whole):
        raise AgentFileError(path, "is not written as this package writes cards: it is damaged or altered")
    return card


def _render(plain: Any) -> bytes:
    return (json.dumps(plain, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode(
        "utf-8", "surrogatepass"
    )
