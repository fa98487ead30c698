"""Code in the place of an agent's files is never run."""

import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.agents.policy.agent_file import load_agent, save_agent
from prp_gym.errors import AgentFileError
from tests.support.agent_files import (
    POLICY,
    card_of,
    put,
    refusal,
    replace_tensors,
    rewrite,
    tensors_of,
    with_tensors,
)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Path of an agent's files, without suffix."""
    save_agent(POLICY, tmp_path / "agent")
    return tmp_path / "agent"


class Touch:
    """Unpickled, it makes a file."""

    def __init__(self, marker: Path) -> None:
        self.marker = marker

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.marker,)


@pytest.fixture
def marker(tmp_path: Path) -> Path:
    return tmp_path / "marker"


def test_payload_works_where_it_is_opened(marker: Path) -> None:
    pickle.loads(pickle.dumps(Touch(marker)))
    assert marker.exists()


@pytest.mark.parametrize("suffix", [".zip", ".pkl", ".pickle", ".pt", ".pth", ".npy", ".npz", ".ZIP", ".Pkl"])
def test_file_that_can_hold_code_is_refused_unopened(tmp_path: Path, marker: Path, suffix: str) -> None:
    path = tmp_path / f"agent{suffix}"
    path.write_bytes(pickle.dumps(Touch(marker)))
    for given_path in (path, str(path)):
        message = refusal(given_path)
        assert "run code" in message
        assert f"prp-gym export {path} --trust" in message
    with pytest.raises(AgentFileError, match="run code"):
        save_agent(POLICY, path)
    assert not marker.exists()


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_pickle_in_the_place_of_either_file_is_refused(saved: Path, marker: Path, protocol: int) -> None:
    payload = pickle.dumps(Touch(marker), protocol)
    card = card_of(saved).read_bytes()
    card_of(saved).write_bytes(payload)
    assert "is not text in UTF-8" in refusal(saved) or "cannot be read as JSON" in refusal(saved)
    card_of(saved).write_bytes(card)
    tensors_of(saved).write_bytes(payload)
    refusal(saved)
    replace_tensors(saved, payload)
    assert "is not a safetensors file" in refusal(saved)
    assert not marker.exists()


def test_archives_with_pickles_in_the_place_of_the_numbers_are_refused(saved: Path, marker: Path) -> None:
    with zipfile.ZipFile(tensors_of(saved), "w") as archive:
        for name in ("data", "data.pkl", "archive/data.pkl", "policy.pth", "mean.npy"):
            archive.writestr(name, pickle.dumps(Touch(marker)))
    replace_tensors(saved, tensors_of(saved).read_bytes())
    assert "is not a safetensors file" in refusal(saved)
    np.save(str(marker.with_name("x.npy")), np.array([Touch(marker)]), allow_pickle=True)
    replace_tensors(saved, marker.with_name("x.npy").read_bytes())
    assert "is not a safetensors file" in refusal(saved)
    assert not marker.exists()


def test_pickle_within_a_tensor_or_a_text_is_nothing_but_numbers_and_letters(
    saved: Path, marker: Path
) -> None:
    payload = np.frombuffer(pickle.dumps(Touch(marker)), np.uint8)
    replace_tensors(saved, with_tensors(layer_0__bias=payload))
    assert "tensor 'layer_0.bias' is uint8" in refusal(saved)
    save_agent(POLICY, saved)
    rewrite(saved, put("algorithm", value=pickle.dumps(Touch(marker), 0).decode()))
    load_agent(saved)
    assert not marker.exists()
