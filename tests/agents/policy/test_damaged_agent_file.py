"""Files of trained agents in which anything is damaged or altered are refused."""

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.card_file import pack_card, unpack_card
from prp_gym.errors import AgentFileError
from tests.support.agent_files import POLICY, card_of, refusal, replace_tensors, tensors_of
from tests.support.synthetic_agents import synthetic_policy


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Path of an agent's files, without suffix."""
    save_agent(POLICY, tmp_path / "agent")
    return tmp_path / "agent"


def flipped(content: bytes, position: int, bit: int) -> bytes:
    return content[:position] + bytes([content[position] ^ 1 << bit]) + content[position + 1 :]


@settings(max_examples=300, deadline=None, derandomize=True)
@given(where=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_any_bit_of_the_card_matters(where: float, bit: int) -> None:
    content = pack_card(POLICY.card)
    with pytest.raises(AgentFileError):
        unpack_card(Path("x.json"), flipped(content, int(where * len(content)), bit))


def test_bit_that_leaves_every_value_as_it_is_is_noticed() -> None:
    content = pack_card(POLICY.card)
    position = content.index(b"3e-07") + 1
    assert float(flipped(content, position, 5)[position - 1 : position + 4]) == 3e-7  # 3E-07
    with pytest.raises(AgentFileError, match="not written as this package writes cards"):
        unpack_card(Path("x.json"), flipped(content, position, 5))


@pytest.mark.parametrize("position", [0, 1, 8, 9, 30, 200, 700, 1200, -200, -9, -1])
@pytest.mark.parametrize("bit", [0, 3, 7])
def test_any_bit_of_the_numbers_matters(saved: Path, position: int, bit: int) -> None:
    content = tensors_of(saved).read_bytes()
    tensors_of(saved).write_bytes(flipped(content, position % len(content), bit))
    assert "its SHA-256 is not that on its card" in refusal(saved)


@pytest.mark.parametrize("left", [0, 1, 7, 8, 9, 100, 700, -100, -2, -1])
def test_truncated_file_is_refused(saved: Path, left: int) -> None:
    card, tensors = card_of(saved).read_bytes(), tensors_of(saved).read_bytes()
    card_of(saved).write_bytes(card[:left])
    assert card_of(saved).name in refusal(saved)
    card_of(saved).write_bytes(card)
    tensors_of(saved).write_bytes(tensors[:left])
    assert "its SHA-256 is not" in refusal(saved)
    replace_tensors(saved, tensors[:left])  # with a card that vouches for it
    assert "is not a safetensors file" in refusal(saved)


@pytest.mark.parametrize("name", [".json", ".safetensors"])
def test_file_with_something_behind_it_is_refused(saved: Path, name: str) -> None:
    path = saved.with_name(f"agent{name}")
    path.write_bytes(path.read_bytes() + b"\n")
    refusal(saved)


def test_numbers_of_another_agent_are_refused(saved: Path) -> None:
    save_agent(synthetic_policy(seed=1), saved.parent / "other")
    tensors_of(saved).write_bytes(tensors_of(saved.parent / "other").read_bytes())
    assert "damaged, altered or another's" in refusal(saved)


def test_altered_card_is_refused(saved: Path) -> None:
    text = card_of(saved).read_text(encoding="utf-8")
    card_of(saved).write_text(text.replace('"score": 0.5', '"score": 0.9'), encoding="utf-8")
    assert "key 'checksum' does not fit the rest" in refusal(saved)
    card_of(saved).write_text(json.dumps(json.loads(text)), encoding="utf-8")
    assert "not written as this package writes cards" in refusal(saved)
