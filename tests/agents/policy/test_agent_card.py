"""A card or numbers with another key, type, shape or value than an agent has are refused, and told where."""

import hashlib
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.agents.policy import agent_file
from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.card_file import pack_card, unpack_card
from prp_gym.errors import AgentFileError
from prp_gym.files.file_reader import FileReader
from tests.support.agent_files import (
    POLICY,
    card_of,
    put,
    refusal,
    replace_tensors,
    rewrite,
    with_tensors,
)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Path of an agent's files, without suffix."""
    save_agent(POLICY, tmp_path / "agent")
    return tmp_path / "agent"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda card: card.pop("algorithm"), "key 'card.algorithm' is missing"),
        (lambda card: card["run"].pop("seed"), "key 'card.run.seed' is missing"),
        (put("extra", value=1), "key 'card.extra' is unknown"),
        (put("run", "curve", 1, "extra", value=1), "key 'card.run.curve[1].extra' is unknown"),
        (put("run", "seed", value=1.0), "key 'card.run.seed' is 1.0; expected a whole number"),
        (put("run", "seed", value=True), "key 'card.run.seed' is True; expected a whole number"),
        (put("run", "seconds", value="1"), "key 'card.run.seconds' is '1'; expected a number"),
        (put("run", "seconds", value=10**400), "has more than 40 digits"),
        (put("run", "curve", value={}), "key 'card.run.curve' is {}; expected a list"),
        (
            put("run", "curve", 0, "score", value=None),
            "key 'card.run.curve[0].score' is None; expected a number",
        ),
        (put("run", "hyperparameters", value=[]), "key 'card.run.hyperparameters' is []; expected an object"),
        (put("run", value=None), "key 'card.run' is None; expected an object"),
        (put("algorithm", value=7), "key 'card.algorithm' is 7; expected text"),
        (put("scores", "realistic", value=0.5), "key 'card.scores.realistic' is 0.5; expected an object"),
        (put("interface", "keywords", "a", value={}), "key 'card.interface.keywords.a' is {}; expected text"),
        (put("interface", "keywords", "a", value=["b"]), "key 'card.interface.keywords.a[0]' is 'b'"),
        (put("interface", "observation", value=[]), "key 'card': observation fields is []"),
        (
            put("interface", "observation", 0, "size", value=0),
            "size of part 'joint_position' is 0; allowed: 1",
        ),
        (put("interface", "observation", 0, "size", value=10**12), "size of part 'joint_position'"),
        (
            put("interface", "observation", value=[{"name": f"x{n}", "size": 10_000} for n in range(5000)]),
            "size of the observation is 50000000; allowed: at most 10000",
        ),
        (put("interface", "features", 0, value="x"), "unknown list of features"),
        (
            put("interface", "action", 0, "size", value=2),
            "output of the network has shape (3,); expected (4,)",
        ),
        (put("network", "inputs", value=7), "input of the network has shape (7,); expected (33,)"),
        (put("network", "hidden", 0, value=0), "layer sizes is (33, 0, 3); allowed: at least 1"),
        (put("network", "activation", value="tanhh"), "unknown activation 'tanhh'. Did you mean 'tanh'?"),
        (put("network", "head", value="exec"), "unknown head 'exec'"),
        (put("network", "hidden", value=[5]), "tensor 'layer_0.weight' is float32 (4, 33); the card says"),
        (put("network", "hidden", value=[4, 4]), "tensors missing or not on the card: layer_2.bias"),
        (put("network", "memory", value=[10**12]), "tensors missing or not on the card: lstm_0.bias"),
        (put("run", "command", value="\ud800"), "is not text in UTF-8"),
        (put("interface", "environment_revision", value=0), "environment_revision is 0; allowed: a whole"),
        (put("interface", "environment_revision", value="1"), "revision' is '1'; expected a whole number"),
        (put("interface", "environment_revision", value=True), "is True; expected a whole number"),
    ],
)
def test_card_with_another_key_or_value_is_refused(
    saved: Path, change: Callable[[dict[str, Any]], Any], message: str
) -> None:
    rewrite(saved, change)
    assert message in refusal(saved)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "cannot be read as JSON"),
        (b"[]", "the content is []; expected an object"),
        (b"{}", "key 'card' is missing"),
        (b'{"format": 2}', "key 'format' is 2; this version reads 1"),
        (b'{"format": 1, "format": 1}', "key 'format' is given twice"),
        (b'{"format": NaN}', "NaN is not a finite number"),
        (b'{"format": -Infinity}', "-Infinity is not a finite number"),
        (b'{"format": 1e999}', "'1e999' is not a finite number"),
        (b'{"format": \xff}', "is not text in UTF-8"),
        (b"[" * 100_000, "more than 32 levels"),
        (b"9" * 10_000, "more than 40 digits"),
    ],
)
def test_file_that_is_no_card_is_refused(saved: Path, content: bytes, message: str) -> None:
    card_of(saved).write_bytes(content)
    assert message in refusal(saved)


def nested_card(levels: int) -> bytes:
    """A card with lists within lists, and a checksum that fits."""
    nested = "[" * levels + "]" * levels
    whole = json.loads(pack_card(POLICY.card))
    whole["card"]["run"]["hyperparameters"] = {"x": 0}
    compact = json.dumps(whole["card"], sort_keys=True, separators=(",", ":")).replace(
        '"x":0', f'"x":{nested}'
    )
    whole["checksum"] = hashlib.sha256(compact.encode()).hexdigest()
    return json.dumps(whole).replace('"x": 0', f'"x": {nested}').encode()


@pytest.mark.parametrize("levels", [100, 800, 900, 1500, 100_000])
def test_card_of_many_levels_is_refused(levels: int) -> None:
    with pytest.raises(AgentFileError, match="more than 32 levels"):
        unpack_card(Path("x.json"), nested_card(levels))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (with_tensors(layer_0__bias=None), "tensors missing or not on the card: layer_0.bias"),
        (with_tensors(extra=np.zeros(1)), "tensors missing or not on the card: extra"),
        (
            with_tensors(layer_0__bias=np.zeros(4)),
            "tensor 'layer_0.bias' is float64 (4,); the card says float32 (4,)",
        ),
        (with_tensors(layer_0__bias=np.zeros(5, np.float32)), "float32 (5,); the card says float32 (4,)"),
        (
            with_tensors(layer_0__bias=np.full(4, np.nan, np.float32)),
            "tensor 'layer_0.bias' has NaN or infinity",
        ),
        (
            with_tensors(layer_1__weight=np.full((3, 4), np.inf, np.float32)),
            "tensor 'layer_1.weight' has NaN or",
        ),
        (with_tensors(normalizer__mean=np.full(33, np.inf)), "tensor 'normalizer.mean' has NaN or infinity"),
        (with_tensors(normalizer__clip=np.array(np.nan)), "tensor 'normalizer.clip' has NaN or infinity"),
        (with_tensors(normalizer__clip=np.array(-1.0)), "negative clip or epsilon"),
        (with_tensors(normalizer__epsilon=np.array(-1e-9)), "negative clip or epsilon"),
        (with_tensors(normalizer__variance=np.full(33, -1.0)), "no positive variance"),
        (b"", "is not a safetensors file"),
        (struct.pack("<Q", 2**62) + b"{}", "is not a safetensors file"),
        (struct.pack("<Q", 2) + b"{}", "tensors missing or not on the card"),
        (
            struct.pack("<Q", 60) + b'{"x":{"dtype":"BF16","shape":[1],"data_offsets":[0,2]}}     \0\0',
            "safetensors",
        ),
    ],
)
def test_other_numbers_than_the_card_s_are_refused(saved: Path, content: bytes, message: str) -> None:
    replace_tensors(saved, content)
    assert message in refusal(saved)


@pytest.mark.parametrize("suffix", [".json", ".safetensors"])
def test_file_larger_than_any_agent_is_refused_unread(
    saved: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    monkeypatch.setitem(agent_file._READERS, suffix, FileReader(100, AgentFileError))
    assert "is larger than 100 bytes" in refusal(saved)
