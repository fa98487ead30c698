"""The checksum beside the content of a file: right, wrong, missing."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import DataFileError
from prp_gym.files.checksum import seal, unseal, unseal_or_former

PATH = Path("result.json")


def test_checksum_is_that_of_the_sorted_text_without_spaces() -> None:
    sealed = seal({"b": np.array([1.5, np.nan]), "a": {"z": "é"}})
    digest = hashlib.sha256(b'{"a":{"z":"\\u00e9"},"b":[1.5,null]}').hexdigest()
    assert sealed == {"b": [1.5, None], "a": {"z": "é"}, "checksum": digest}
    assert unseal(PATH, sealed) == {"b": [1.5, None], "a": {"z": "é"}}


@pytest.mark.parametrize("change", [{"b": 2}, {"c": 1}, {"checksum": "0" * 64}, {"checksum": None}])
def test_what_does_not_fit_its_checksum_is_refused(change: dict[str, Any]) -> None:
    for read in (unseal, unseal_or_former):
        with pytest.raises(DataFileError, match="'checksum' does not fit the rest"):
            read(PATH, {**seal({"b": 1}), **change})


@pytest.mark.parametrize("content", [{}, {"b": 1}, [], None, 3])
def test_content_without_a_checksum_is_that_of_a_former_version(content: Any) -> None:
    assert unseal_or_former(PATH, content) == content
    with pytest.raises(DataFileError, match="has no checksum"):
        unseal(PATH, content)
